#include "run_coverage.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "bin_names.h"
#include "datapath/segment.h"
#include "scenario/derived_timing.h"
#include "scenario/names.h"
#include "segment_coverage.h"

namespace metabuffer::coverage {
namespace {

/// Which of three names fits the order of two values.
template <typename Value>
const char* by_order(Value left, Value right, const char* less, const char* equal, const char* greater) {
    if (left < right) return less;
    return left == right ? equal : greater;
}

bool whole_multiple(std::int64_t a, std::int64_t b) { return a % b == 0 || b % a == 0; }

bool has_fault(const Scenario& scenario, FaultKind kind) {
    return std::any_of(scenario.faults.begin(), scenario.faults.end(),
                       [kind](const Fault& fault) { return fault.kind == kind; });
}

/// Samples one run.
class RunCoverage {
  public:
    RunCoverage(Coverage& coverage, const Scenario& scenario, const RunReport& report)
        : coverage_(coverage), scenario_(scenario), report_(report) {}

    void sample() {
        cover_shape();
        cover_modes();
        cover_clocks();
        cover_memory();
        cover_buffers();
        cover_starvation();
        cover_arbitration();
        cover_watchdog();
        cover_tables();
        cover_viewports();
        cover_pacing();
        cover_rejections();
        cover_faults();
    }

  private:
    void hit(const char* group, const std::string& bin) { coverage_.hit(group, bin); }
    void hit_if(bool condition, const char* group, const std::string& bin) {
        coverage_.hit_if(condition, group, bin);
    }
    bool glitches() const { return scenario_.composer.on_starvation == StarvationMode::kGlitch; }
    bool lockstep() const { return scenario_.pacing == Pacing::kLockstep; }
    bool tripped() const { return !report_.watchdog.empty(); }

    void cover_shape() {
        const char* group = "machine/shape";
        const DisplayConfig& displays = scenario_.displays;
        const std::size_t renderers = scenario_.renderers.size();
        hit_if(renderers == 1, group, "1 renderer");
        for (std::size_t count = 2; count <= 4; ++count) {
            hit_if(renderers == count, group, std::to_string(count) + " renderers");
        }
        hit_if(renderers >= 5, group, "5 renderers or more");
        hit_if(displays.count() == 1, group, "1 display");
        hit_if(displays.columns > 1 && displays.rows == 1, group, "displays in a row");
        hit_if(displays.columns == 1 && displays.rows > 1, group, "displays in a column");
        hit_if(displays.columns > 1 && displays.rows > 1, group, "displays in a grid");
        const bool narrow = displays.width_pixels == 1;
        const bool low = displays.height_pixels == 1;
        hit_if(narrow && low, group, "display of one pixel");
        hit_if(narrow && !low, group, "display one pixel wide");
        hit_if(!narrow && low, group, "display one pixel high");
        hit_if(displays.height_pixels > displays.width_pixels, group, "raster higher than wide");
        hit_if(displays.height_pixels < displays.width_pixels, group, "raster wider than high");
        std::set<std::pair<int, int>> sizes;
        for (const Renderer& renderer : scenario_.renderers) {
            sizes.emplace(renderer.image_width_pixels, renderer.image_height_pixels);
            hit_if(renderer.images.size() > 1 && scenario_.frames > 1, group, "image changes between pairs");
            hit_if(renderer.frames.size() < static_cast<std::size_t>(scenario_.frames), group,
                   "frames beyond a renderer's list");
        }
        hit_if(sizes.size() > 1, group, "renderers of different image sizes");
        const int raster_pixels = displays.raster_width_pixels() * displays.raster_height_pixels();
        const char* frames = "frames/sequence";
        hit_if(raster_pixels == 1, frames, "raster of one pixel");
        hit_if(raster_pixels < static_cast<int>(renderers), frames, "frame shorter than the column");
        hit_if(scenario_.frames == 1, frames, "one frame");
        hit_if(scenario_.frames == 2, frames, "two frames");
        hit_if(scenario_.frames > 2, frames, "three frames or more");
        hit("supersample", std::to_string(displays.supersample));
        hit_if(displays.supersample > 1, "supersample",
               std::string("with ") + to_string(scenario_.composition));
    }

    void cover_modes() {
        hit("machine/modes", both(to_string(scenario_.pacing), to_string(scenario_.composer.on_starvation)));
        hit("machine/modes", both(to_string(scenario_.composition), to_string(scenario_.depth_format)));
        hit("machine/modes", both(to_string(scenario_.pacing), to_string(scenario_.bus.arbitration)));
    }

    void cover_clocks() {
        const char* group = "link/timing";
        const std::int64_t core = clock_period_picoseconds(scenario_.clocks.core_mhz);
        const std::int64_t in = clock_period_picoseconds(scenario_.clocks.dvi_in_mhz);
        const std::int64_t out = clock_period_picoseconds(scenario_.clocks.dvi_out_mhz);
        hit(group, both(by_order(in, core, "DVI in faster", "DVI in equal", "DVI in slower"),
                        by_order(out, core, "DVI out faster", "DVI out equal", "DVI out slower")));
        hit_if(!whole_multiple(in, core), group, "DVI in no whole multiple");
        hit_if(!whole_multiple(out, core), group, "DVI out no whole multiple");
        hit_if(in != core && whole_multiple(in, core), group, "DVI in whole multiple");
        hit_if(out != core && whole_multiple(out, core), group, "DVI out whole multiple");
        hit_if(in != core && out != core && in != out, group, "three different clocks");
        hit_if(in != core && in == out, group, "DVI in and out share a clock");
    }

    void cover_memory() {
        const MemoryConfig& memory = scenario_.memory;
        const BusConfig& bus = scenario_.bus;
        hit("memory/words", std::to_string(memory.words_per_cycle));
        const char* group = "memory/page";
        hit_if(memory.page_miss_cycles == 0, group, "miss costs nothing");
        hit_if(memory.page_miss_cycles == 1, group, "miss costs 1 clock");
        hit_if(memory.page_miss_cycles > 1, group, "miss costs more");
        hit_if(memory.page_words == 1, group, "of one word");
        hit_if(memory.page_words < pixels_per_beat(bus, memory), group, "smaller than a beat could be");
        hit_if(memory.page_words < bus.burst_pixels, group, "smaller than a burst");
        hit_if(memory.page_words > bus.burst_pixels, group, "larger than a burst");
        for (const Renderer& renderer : scenario_.renderers) {
            hit_if(memory.page_words > renderer.image_width_pixels * renderer.image_height_pixels, group,
                   "larger than the image");
        }
        const int bus_pixels = bus.width_bits / kPixelBits;
        hit_if(bus.width_bits == 16, "bus/beat", "4 clocks a pixel");
        hit_if(bus.width_bits == 32, "bus/beat", "2 clocks a pixel");
        if (bus_pixels >= 1) {
            hit("bus/beat", by_order(bus_pixels, memory.words_per_cycle, "bus limits", "bus equals memory",
                                     "memory limits"));
        }
    }

    void cover_buffers() {
        const char* group = "composer/buffer";
        const int in_flight = in_flight_pixels(scenario_.bus, scenario_.memory);
        const ComposerConfig& composer = scenario_.composer;
        hit_if(composer.buffer_pixels == in_flight, group, "smallest legal size");
        hit_if(composer.buffer_pixels == scenario_.bus.burst_pixels + 1, group, "one pixel beyond a burst");
        hit_if(composer.ready_space_pixels == in_flight, group, "ready space is in-flight only");
        hit_if(composer.ready_space_pixels > scenario_.bus.burst_pixels, group,
               "ready space is more than a burst");
    }

    void cover_starvation() {
        const std::string policy = to_string(scenario_.bus.arbitration);
        const bool starved = report_.total_starved_pixels() > 0;
        const bool stalled = report_.total_stalled_cycles() > 0;
        const char* group = "starvation/mode";
        hit_if(starved, group, both(policy, "starved in glitch"));
        hit_if(stalled, group, both(policy, "stalled in stall"));
        hit_if(!starved && glitches(), group, "glitch without starving");
        hit_if(!stalled && !glitches(), group, "stall without stalling");
    }

    void cover_arbitration() {
        const std::string policy = to_string(scenario_.bus.arbitration);
        const BusCounters bus = report_.total_bus();
        hit_if(bus.poll_cycles > 0, "bus/arbitration", both(policy, "poll"));
        if (bus.recovered_slots > 0 && is_goal("bus/arbitration", both(policy, "slots recovered"))) {
            hit("bus/arbitration", both(policy, "slots recovered"));
        }
        hit_if(bus.lost_cycles > 0, "bus/arbitration", "slot-allocation, slot lost");
    }

    void cover_watchdog() {
        const char* group = "watchdog";
        hit(group, scenario_.watchdog_cycles == 0 ? "interval derived" : "interval given");
        hit(group, tripped() ? "ends a run" : "silent in a whole run");
        for (const std::string& line : report_.watchdog) {
            hit_if(line.find("input_framebuffer_") != std::string::npos, group, "names an input framebuffer");
            hit_if(line.find("composer_") != std::string::npos, group, "names a composer");
            hit_if(line.find("output_framebuffer_") != std::string::npos, group,
                   "names an output framebuffer");
        }
        if (tripped()) {
            hit(group, report_.frames_shown() > 0 ? "trips after a frame was shown"
                                                  : "trips before the first frame is shown");
        }
    }

    /// The tables of the pairs that were composited.
    void cover_tables() {
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            const Renderer& renderer = scenario_.renderers[r];
            std::set<const RendererFrame*> seen;
            for (const FrameRecord& frame : report_.frames) {
                const int pair = frame.pairs.at(r);
                if (pair < 0) continue;
                const RendererFrame& entry = renderer.frame_of_pair(static_cast<std::uint32_t>(pair));
                if (seen.insert(&entry).second) cover_table(coverage_, scenario_, renderer, entry.table);
            }
        }
        for (const FrameRecord& frame : report_.frames) cover_frame(frame);
    }

    /// Who shows where in one frame, and how segments follow each other.
    void cover_frame(const FrameRecord& frame) {
        std::vector<std::vector<Segment>> segments(static_cast<std::size_t>(scenario_.displays.count()));
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            const ViewportTable rows = valid_rows(r, frame.pairs.at(r));
            for (const ViewportRow& row : rows) {
                segments[row.dcomp - std::size_t{1}].emplace_back(
                    row, scenario_.displays.raster_width_pixels(), scenario_.displays.raster_height_pixels());
            }
            hit_if(rows.empty(), "machine/shape", "renderer that no display shows");
        }
        for (const std::vector<Segment>& of_display : segments) {
            hit_if(of_display.empty(), "frames/sequence", "no renderer covers a display");
            cover_three_at_a_pixel(of_display);
        }
    }

    void cover_three_at_a_pixel(const std::vector<Segment>& segments) {
        const auto overlap = [](const Segment& a, const Segment& b, const Segment& c) {
            return std::max({a.left(), b.left(), c.left()}) < std::min({a.right(), b.right(), c.right()}) &&
                   std::max({a.top(), b.top(), c.top()}) < std::min({a.bottom(), b.bottom(), c.bottom()});
        };
        for (std::size_t i = 0; i < segments.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                for (std::size_t k = 0; k < j; ++k) {
                    hit_if(overlap(segments[i], segments[j], segments[k]), "compose/depth",
                           "three renderers at one raster pixel");
                }
            }
        }
    }

    ViewportTable valid_rows(std::size_t renderer, int pair) const {
        if (pair < 0) return {};
        const Renderer& source = scenario_.renderers[renderer];
        return validate_table(source.frame_of_pair(static_cast<std::uint32_t>(pair)).table,
                              scenario_.limits(source))
            .rows;
    }

    void cover_viewports() {
        for (const Renderer& renderer : scenario_.renderers) {
            for (const RendererFrame& frame : renderer.frames) {
                if (frame.viewport) cover_viewport(coverage_, scenario_, renderer, frame);
            }
        }
    }

    void cover_pacing() {
        const char* group = "link/pacing";
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            const RendererCounters& counters = report_.renderers[r];
            if (!report_.frames.empty() && report_.frames.front().pairs.at(r) < 0) {
                hit(group, lockstep() ? "lockstep, nothing before the first pair"
                                      : "free-running, nothing before the first pair");
            }
            if (lockstep()) {
                hit_if(counters.dropped_frames > 0, group, "lockstep, pair too late dropped");
                continue;
            }
            hit_if(counters.repeated_frames > 0, group, "free-running, again");
            hit_if(counters.dropped_frames > 0, group, "free-running, overwritten pair dropped");
            hit_if(counters.repeated_frames > 0 && counters.dropped_frames > 0, group,
                   "free-running, drops and repeats in one run");
        }
    }

    void cover_rejections() {
        const char* group = "link/rejected";
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            if (report_.renderers[r].total_rejected_frames() == 0) continue;
            hit(group, lockstep() ? "in lockstep" : "free-running");
            for (const Fault& fault : scenario_.faults) {
                if (fault.renderer != static_cast<int>(r)) continue;
                const std::string cause = cause_name(fault.kind);
                if (cause.empty() || rejected(r, cause) == 0) continue;
                hit(group, both(cause, fault.frame == FrameKind::kColour ? "colour frame" : "depth frame"));
                const int pair = static_cast<int>(fault.pair);
                hit_if(pair == 0, group, "first pair");
                hit_if(pair > 0, group, "later pair");
                hit_if(pair == scenario_.frames - 1, group, "last pair");
                hit_if(std::any_of(report_.frames.begin(), report_.frames.end(),
                                   [&](const FrameRecord& frame) { return frame.pairs.at(r) > pair; }),
                       group, "good pair behind it");
                for (const Fault& other : scenario_.faults) {
                    const bool rejects = !cause_name(other.kind).empty();
                    hit_if(rejects && other.renderer == fault.renderer && other.pair == fault.pair + 1, group,
                           "two pairs running");
                    hit_if(rejects && other.renderer != fault.renderer && other.pair == fault.pair, group,
                           "two renderers in a frame");
                }
            }
        }
    }

    std::int64_t rejected(std::size_t renderer, const std::string& cause) const {
        for (int i = 0; i < kRejectCauseCount; ++i) {
            if (cause == reject_cause_key(static_cast<RejectCause>(i))) {
                return report_.renderers[renderer].rejected_frames[static_cast<std::size_t>(i)];
            }
        }
        return 0;
    }

    /// The cause that a fault is rejected for; empty for one that no frame is rejected for.
    static std::string cause_name(FaultKind kind) {
        switch (kind) {
            case FaultKind::kMagic:
            case FaultKind::kVersion:
            case FaultKind::kKind:
            case FaultKind::kCrc:
                return to_string(kind);
            case FaultKind::kNumber:
            case FaultKind::kMissing:
                return "pair";
            case FaultKind::kShortLine:
            case FaultKind::kLongLine:
            case FaultKind::kShortFrame:
            case FaultKind::kLongFrame:
                return "geometry";
            default:
                return {};
        }
    }

    /// A fault of a pair that the run did not come to, or of a clock behind its end, has done nothing.
    bool struck(const Fault& fault) const {
        switch (fault.kind) {
            case FaultKind::kBusreadyLow:
            case FaultKind::kPipereadyLow:
            case FaultKind::kLostBeat:
            case FaultKind::kRandomStalls:
                return fault.from_cycle < report_.core_cycles;
            default:
                return static_cast<int>(fault.pair) < scenario_.frames;
        }
    }

    bool at_a_clock(FaultKind kind) const { return kind >= FaultKind::kBusreadyLow; }

    void cover_faults() {
        const char* group = "faults/place";
        std::set<int> renderers;
        int faults = 0;
        for (const Fault& fault : scenario_.faults) {
            if (!struck(fault)) continue;
            ++faults;
            renderers.insert(fault.renderer);
            hit("faults/kind", to_string(fault.kind));
            if (fault.kind == FaultKind::kLostBeat) hit("faults/lost-beat", to_string(fault.of));
            hit(group, lockstep() ? "in lockstep" : "free-running");
            hit(group, glitches() ? "in glitch" : "in stall");
            if (at_a_clock(fault.kind)) continue;
            const int pair = static_cast<int>(fault.pair);
            hit_if(pair == 0, group, "first pair");
            hit_if(pair == scenario_.frames - 1, group, "last pair");
            hit_if(pair > 0 && pair < scenario_.frames - 1, group, "pair in between");
            hit_if(fault.kind == FaultKind::kDelay, group,
                   fault.delay_pairs < scenario_.link_timeout_pairs ? "silence shorter than the timeout"
                                                                    : "silence longer than the timeout");
            if (fault.kind == FaultKind::kDrift) {
                hit(group, fault.ppm > 0 ? "clock drifts fast" : "clock drifts slow");
            }
            hit_if(std::any_of(report_.frames.begin(), report_.frames.end(),
                               [&](const FrameRecord& frame) {
                                   return frame.pairs.at(static_cast<std::size_t>(fault.renderer)) > pair;
                               }),
                   group, "good frame shown behind a faulty one");
        }
        hit_if(faults > 1, group, "two faults in a run");
        hit_if(renderers.size() > 1, group, "two renderers at once");
        hit_if(has_fault(scenario_, FaultKind::kLostBeat) && report_.total_composer().lost_pixels > 0, group,
               "pixels lost on a bus");
        hit_if(report_.total_composer().lost_tables > 0, group, "table lost on a bus");
        hit_if(std::any_of(report_.displays.begin(), report_.displays.end(),
                           [](const DisplayCounters& display) { return display.kept_frames > 0; }),
               group, "frame kept off the displays");
    }

    Coverage& coverage_;
    const Scenario& scenario_;
    const RunReport& report_;
};

}  // namespace

void cover_run(Coverage& coverage, const Scenario& scenario, const RunReport& report) {
    RunCoverage(coverage, scenario, report).sample();
}

}  // namespace metabuffer::coverage
