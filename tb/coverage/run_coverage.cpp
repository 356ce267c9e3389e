#include "run_coverage.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <string>

#include "datapath/segment.h"
#include "scenario/derived_timing.h"
#include "scenario/fault_keys.h"
#include "scenario/link_program.h"

namespace metabuffer::coverage {
namespace {

/// By periods.
Speed speed(std::int64_t period, std::int64_t core_period) {
    if (period == core_period) return Speed::kEqual;
    return period < core_period ? Speed::kFaster : Speed::kSlower;
}

bool whole_multiple(std::int64_t a, std::int64_t b) { return a % b == 0 || b % a == 0; }

bool has_fault(const Scenario& scenario, FaultKind kind) {
    return std::any_of(scenario.faults.begin(), scenario.faults.end(),
                       [kind](const Fault& fault) { return fault.kind == kind; });
}

/// The cause for which a fault's frame is rejected, if it is.
std::optional<RejectCause> cause_of(FaultKind kind) {
    switch (kind) {
        case FaultKind::kMagic:
            return RejectCause::kMagic;
        case FaultKind::kVersion:
            return RejectCause::kVersion;
        case FaultKind::kKind:
            return RejectCause::kKind;
        case FaultKind::kCrc:
            return RejectCause::kCrc;
        case FaultKind::kNumber:
        case FaultKind::kMissing:
            return RejectCause::kPair;
        case FaultKind::kShortLine:
        case FaultKind::kLongLine:
        case FaultKind::kShortFrame:
        case FaultKind::kLongFrame:
            return RejectCause::kGeometry;
        default:
            return std::nullopt;
    }
}

/// Samples one run.
class RunCoverage {
  public:
    RunCoverage(const RunGoals& goals, const Scenario& scenario, const RunReport& report)
        : goals_(goals), scenario_(scenario), report_(report) {}

    void sample() {
        goals_.keys.cover(scenario_);
        cover_shape();
        cover_correction();
        cover_clocks();
        cover_memory();
        cover_buffers();
        cover_links();
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
    bool glitches() const { return scenario_.composer.on_starvation == StarvationMode::kGlitch; }
    bool lockstep() const { return scenario_.pacing == Pacing::kLockstep; }
    bool tripped() const { return !report_.watchdog.empty(); }

    void cover_shape() {
        const ShapeGoals& goals = goals_.shape;
        const DisplayConfig& displays = scenario_.displays;
        const std::size_t renderers = scenario_.renderers.size();
        goals.renderers(static_cast<std::int64_t>(renderers)).hit();
        goals.one_display.hit_if(displays.count() == 1);
        goals.displays_in_row.hit_if(displays.columns > 1 && displays.rows == 1);
        goals.displays_in_column.hit_if(displays.columns == 1 && displays.rows > 1);
        goals.displays_in_grid.hit_if(displays.columns > 1 && displays.rows > 1);
        const bool narrow = displays.width_pixels == 1;
        const bool low = displays.height_pixels == 1;
        goals.display_of_one_pixel.hit_if(narrow && low);
        goals.display_one_pixel_wide.hit_if(narrow && !low);
        goals.display_one_pixel_high.hit_if(!narrow && low);
        goals.raster_higher.hit_if(displays.height_pixels > displays.width_pixels);
        goals.raster_wider.hit_if(displays.height_pixels < displays.width_pixels);
        std::set<std::pair<int, int>> sizes;
        for (const Renderer& renderer : scenario_.renderers) {
            sizes.emplace(renderer.image_width_pixels, renderer.image_height_pixels);
            goals.image_changes.hit_if(renderer.images.size() > 1 && scenario_.frames > 1);
            goals.frames_beyond_list.hit_if(renderer.frames.size() <
                                            static_cast<std::size_t>(scenario_.frames));
        }
        goals.different_image_sizes.hit_if(sizes.size() > 1);
        const int raster_pixels = displays.raster_width_pixels() * displays.raster_height_pixels();
        goals_.frames.raster_of_one_pixel.hit_if(raster_pixels == 1);
        goals_.frames.shorter_than_column.hit_if(raster_pixels < static_cast<int>(renderers));
        goals_.frames.frames(scenario_.frames).hit();
    }

    void cover_correction() {
        const CorrectionGoals& goals = goals_.correction;
        const DisplayConfig& displays = scenario_.displays;
        if (displays.correction.empty() || report_.frames_shown() == 0) return;
        const bool all = static_cast<int>(displays.correction.size()) == displays.count();
        goals.every_display.hit_if(all && displays.count() > 1);
        goals.some_displays.hit_if(!all);
        goals.averaged.hit_if(displays.supersample > 1);
        for (const DisplayCorrection& correction : displays.correction) {
            const bool formula = !correction.has_lut();
            goals.by_table.hit_if(!formula);
            goals.by_gains.hit_if(formula && correction.gamma == 1.0);
            goals.by_gamma.hit_if(formula && correction.gamma != 1.0);
            goals.brighter.hit_if(formula &&
                                  std::any_of(std::begin(correction.gain), std::end(correction.gain),
                                              [](double gain) { return gain > 1.0; }));
            const auto display = static_cast<std::size_t>(correction.display) - 1;
            goals.kept_frame.hit_if(report_.displays.at(display).kept_frames > 0);
        }
    }

    void cover_clocks() {
        const ClockGoals& goals = goals_.clocks;
        const std::int64_t core = clock_period_picoseconds(scenario_.clocks.core_mhz);
        const std::int64_t in = clock_period_picoseconds(scenario_.clocks.dvi_in_mhz);
        const std::int64_t out = clock_period_picoseconds(scenario_.clocks.dvi_out_mhz);
        goals.speed(speed(in, core), speed(out, core)).hit();
        goals.in_no_whole_multiple.hit_if(!whole_multiple(in, core));
        goals.out_no_whole_multiple.hit_if(!whole_multiple(out, core));
        goals.in_whole_multiple.hit_if(in != core && whole_multiple(in, core));
        goals.out_whole_multiple.hit_if(out != core && whole_multiple(out, core));
        goals.three_clocks.hit_if(in != core && out != core && in != out);
        goals.shared_clock.hit_if(in != core && in == out);
    }

    void cover_memory() {
        const MemoryConfig& memory = scenario_.memory;
        const BusConfig& bus = scenario_.bus;
        const PageSizeGoals& page = goals_.page;
        page.miss_cycles(memory.page_miss_cycles).hit();
        page.one_word.hit_if(memory.page_words == 1);
        page.smaller_than_beat.hit_if(memory.page_words < pixels_per_beat(bus, memory));
        page.smaller_than_burst.hit_if(memory.page_words < bus.burst_pixels);
        page.larger_than_burst.hit_if(memory.page_words > bus.burst_pixels);
        for (const Renderer& renderer : scenario_.renderers) {
            page.larger_than_image.hit_if(memory.page_words >
                                          renderer.image_width_pixels * renderer.image_height_pixels);
        }
        const int bus_pixels = bus.width_bits / kPixelBits;
        const BeatLimitGoals& beat = goals_.beat;
        beat.four_clocks.hit_if(cycles_per_beat(bus) == 4);
        beat.two_clocks.hit_if(cycles_per_beat(bus) == 2);
        beat.bus_limits.hit_if(bus_pixels >= 1 && bus_pixels < memory.words_per_cycle);
        beat.bus_equals_memory.hit_if(bus_pixels >= 1 && bus_pixels == memory.words_per_cycle);
        beat.memory_limits.hit_if(bus_pixels > memory.words_per_cycle);
        cover_ports();
        goals_.delay.both.hit_if(memory.read_latency_cycles > 0 && bus.register_stages > 0);
        goals_.delay.beats_of_several_clocks.hit_if(bus_loop_cycles(bus, memory) > 0 &&
                                                    cycles_per_beat(bus) > 1);
    }

    void cover_links() {
        const LinkLayerGoals& goals = goals_.links;
        if (!scenario_.links.tmds()) return;
        const ClockConfig& clocks = scenario_.clocks;
        goals.tmds_free_running.hit_if(!lockstep());
        goals.tmds_own_clocks.hit_if(clocks.core_mhz != clocks.dvi_in_mhz &&
                                     clocks.dvi_in_mhz != clocks.dvi_out_mhz &&
                                     clocks.dvi_out_mhz != clocks.core_mhz);
        goals.tmds_reset.hit_if(has_fault(scenario_, FaultKind::kReset));
        goals.tmds_drift.hit_if(has_fault(scenario_, FaultKind::kDrift));
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            const bool rejects = report_.renderers.at(r).total_rejected_frames() > 0;
            goals.tmds_rejected.hit_if(rejects);
            if (!disturbs_characters(scenario_, r)) continue;
            (rejects ? goals.tmds_frame_lost : goals.tmds_pixel_passes).hit();
        }
    }

    void cover_ports() {
        const MemoryConfig& memory = scenario_.memory;
        if (!memory.shared()) return;
        const MemoryPortGoals& goals = goals_.ports;
        goals.refreshed.hit_if(memory.refreshes());
        goals.read_latency.hit_if(memory.read_latency_cycles > 0);
        goals.block_of_one_clock.hit_if(memory.write_cycles(memory.write_block_words) == 1);
        goals.block_is_page.hit_if(memory.write_block_words == memory.page_words);
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            const Renderer& renderer = scenario_.renderers[r];
            const RendererCounters& counters = report_.renderers.at(r);
            const int words = renderer.image_width_pixels * renderer.image_height_pixels;
            goals.short_last_block.hit_if(words % memory.write_block_words != 0);
            goals.bursts_wait.hit_if(counters.bus.write_cycles > 0);
            goals.no_burst_waits.hit_if(counters.bus.bursts > 0 && counters.bus.write_cycles == 0);
            goals.broken_off_frame.hit_if(
                counters.rejected_frames[static_cast<std::size_t>(RejectCause::kGeometry)] > 0);
        }
    }

    void cover_buffers() {
        const BufferSizeGoals& goals = goals_.buffer;
        const int in_flight = in_flight_pixels(scenario_.bus, scenario_.memory);
        const ComposerConfig& composer = scenario_.composer;
        goals.smallest.hit_if(composer.buffer_pixels == in_flight);
        goals.beyond_a_burst.hit_if(composer.buffer_pixels == scenario_.bus.burst_pixels + 1);
        goals.ready_space_in_flight.hit_if(composer.ready_space_pixels == in_flight);
        goals.ready_space_beyond_a_burst.hit_if(composer.ready_space_pixels > scenario_.bus.burst_pixels);
    }

    void cover_starvation() {
        const StarvationModeGoals& goals = goals_.starvation;
        const bool starved = report_.total_starved_pixels() > 0;
        const bool stalled = report_.total_stalled_cycles() > 0;
        goals.starved(scenario_.bus.arbitration).hit_if(starved);
        goals.stalled(scenario_.bus.arbitration).hit_if(stalled);
        goals.glitch_without_starving.hit_if(!starved && glitches());
        goals.stall_without_stalling.hit_if(!stalled && !glitches());
    }

    void cover_arbitration() {
        const SlotGoals& goals = goals_.slots;
        const Arbitration policy = scenario_.bus.arbitration;
        const BusCounters bus = report_.total_bus();
        goals.poll(policy).hit_if(bus.poll_cycles > 0);
        goals.irsa_recovers.hit_if(bus.recovered_slots > 0 && policy == Arbitration::kIrsa);
        goals.round_robin_recovers.hit_if(bus.recovered_slots > 0 && policy == Arbitration::kRoundRobin);
        goals.slot_lost.hit_if(bus.lost_cycles > 0);
    }

    void cover_watchdog() {
        const WatchdogGoals& goals = goals_.watchdog;
        (scenario_.watchdog_cycles == 0 ? goals.interval_derived : goals.interval_given).hit();
        (tripped() ? goals.ends_run : goals.silent).hit();
        for (const std::string& line : report_.watchdog) {
            goals.names_input_framebuffer.hit_if(line.find("input_framebuffer_") != std::string::npos);
            goals.names_composer.hit_if(line.find("composer_") != std::string::npos);
            goals.names_output_framebuffer.hit_if(line.find("output_framebuffer_") != std::string::npos);
        }
        if (tripped()) (report_.frames_shown() > 0 ? goals.after_a_frame : goals.before_first_frame).hit();
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
                if (!seen.insert(&entry).second) continue;
                cover_table(goals_.tables, scenario_, renderer, entry.table);
                cover_slots(renderer, entry);
            }
        }
        for (const FrameRecord& frame : report_.frames) cover_frame(frame);
    }

    void cover_slots(const Renderer& renderer, const RendererFrame& entry) {
        const ValidatedTable table = validate_table(entry.table, scenario_.limits(renderer));
        const std::vector<int> of_policy = slots_of(scenario_.bus.arbitration, table.rows);
        if (of_policy.empty()) return;
        const SlotTableGoals& goals = goals_.slot_tables;
        if (scenario_.bus.slot_table == SlotTableMaker::kBuilt) {
            goals.built.hit();
            return;
        }
        const SentSlots sent = frame_slots(scenario_, renderer, entry, table);
        if (sent.rejected) {
            (entry.slots->empty() ? goals.missing : goals.wrong).hit();
            return;
        }
        goals.beside_dropped_rows.hit_if(!table.rejected.empty());
        if (entry.slots) {
            goals.given.hit();
        } else {
            (sent.slots == of_policy ? goals.of_host : goals.shortened).hit();
        }
    }

    /// Which renderers show where in one frame, and how segments follow each other.
    void cover_frame(const FrameRecord& frame) {
        std::vector<std::vector<Segment>> segments(static_cast<std::size_t>(scenario_.displays.count()));
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            const ViewportTable rows = valid_rows(r, frame.pairs.at(r));
            for (const ViewportRow& row : rows) {
                segments[row.dcomp - std::size_t{1}].emplace_back(
                    row, scenario_.displays.raster_width_pixels(), scenario_.displays.raster_height_pixels());
            }
            goals_.shape.renderer_not_shown.hit_if(rows.empty());
        }
        for (const std::vector<Segment>& of_display : segments) {
            goals_.frames.display_not_covered.hit_if(of_display.empty());
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
                    goals_.overlap.three_renderers.hit_if(overlap(segments[i], segments[j], segments[k]));
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
                if (frame.viewport) cover_viewport(goals_.tables.viewport, scenario_, renderer, frame);
            }
        }
    }

    void cover_pacing() {
        const PacingGoals& goals = goals_.pacing;
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            const RendererCounters& counters = report_.renderers[r];
            goals.nothing_before_first(scenario_.pacing)
                .hit_if(!report_.frames.empty() && report_.frames.front().pairs.at(r) < 0);
            const bool repeated = counters.repeated_frames > 0;
            const bool dropped = counters.dropped_frames > 0;
            goals.lockstep_too_late_dropped.hit_if(lockstep() && dropped);
            goals.free_running_again.hit_if(!lockstep() && repeated);
            goals.free_running_dropped.hit_if(!lockstep() && dropped);
            goals.drops_and_repeats.hit_if(!lockstep() && repeated && dropped);
        }
    }

    void cover_rejections() {
        const RejectedFrameGoals& goals = goals_.rejected;
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            if (report_.renderers[r].total_rejected_frames() == 0) continue;
            goals.pacing(scenario_.pacing).hit();
            for (const Fault& fault : scenario_.faults) {
                if (fault.renderer != static_cast<int>(r)) continue;
                const std::optional<RejectCause> cause = cause_of(fault.kind);
                if (!cause || rejected(r, *cause) == 0) continue;
                goals.cause(*cause, fault.frame).hit();
                const int pair = static_cast<int>(fault.pair);
                goals.first_pair.hit_if(pair == 0);
                goals.later_pair.hit_if(pair > 0);
                goals.last_pair.hit_if(pair == scenario_.frames - 1);
                goals.good_pair_behind.hit_if(
                    std::any_of(report_.frames.begin(), report_.frames.end(),
                                [&](const FrameRecord& frame) { return frame.pairs.at(r) > pair; }));
                for (const Fault& other : scenario_.faults) {
                    const bool rejects = cause_of(other.kind).has_value();
                    const bool same_renderer = other.renderer == fault.renderer;
                    goals.two_pairs_running.hit_if(rejects && same_renderer && other.pair == fault.pair + 1);
                    goals.two_renderers.hit_if(rejects && !same_renderer && other.pair == fault.pair);
                }
            }
        }
    }

    std::int64_t rejected(std::size_t renderer, RejectCause cause) const {
        return report_.renderers[renderer].rejected_frames[static_cast<std::size_t>(cause)];
    }

    /// A fault of a pair that the run did not reach, or of a clock after its end, has had no effect.
    bool struck(const Fault& fault) const {
        return !is_on_link(fault.kind) ? fault.from_cycle < report_.core_cycles
                                       : static_cast<int>(fault.pair) < scenario_.frames;
    }

    void cover_faults() {
        const FaultLocationGoals& goals = goals_.fault_location;
        std::set<int> renderers;
        int faults = 0;
        for (const Fault& fault : scenario_.faults) {
            if (!struck(fault)) continue;
            ++faults;
            renderers.insert(fault.renderer);
            goals_.keys.cover(fault);
            goals.pacing(scenario_.pacing).hit();
            goals.starvation(scenario_.composer.on_starvation).hit();
            if (!is_on_link(fault.kind)) continue;
            const int pair = static_cast<int>(fault.pair);
            goals.first_pair.hit_if(pair == 0);
            goals.last_pair.hit_if(pair == scenario_.frames - 1);
            goals.pair_between.hit_if(pair > 0 && pair < scenario_.frames - 1);
            const bool delayed = fault.kind == FaultKind::kDelay;
            const bool in_time = fault.delay_pairs < scenario_.link_timeout_pairs;
            goals.short_silence.hit_if(delayed && in_time);
            goals.long_silence.hit_if(delayed && !in_time);
            if (fault.kind == FaultKind::kDrift)
                (fault.ppm > 0 ? goals.drifts_fast : goals.drifts_slow).hit();
            goals.good_frame_behind.hit_if(
                std::any_of(report_.frames.begin(), report_.frames.end(), [&](const FrameRecord& frame) {
                    return frame.pairs.at(static_cast<std::size_t>(fault.renderer)) > pair;
                }));
        }
        goals.two_faults.hit_if(faults > 1);
        goals.two_renderers.hit_if(renderers.size() > 1);
        goals.pixels_lost.hit_if(has_fault(scenario_, FaultKind::kLostBeat) &&
                                 report_.total_composer().lost_pixels > 0);
        goals.table_lost.hit_if(report_.total_composer().lost_tables > 0);
        goals.frame_kept_off.hit_if(
            std::any_of(report_.displays.begin(), report_.displays.end(),
                        [](const DisplayCounters& display) { return display.kept_frames > 0; }));
    }

    const RunGoals& goals_;
    const Scenario& scenario_;
    const RunReport& report_;
};

}  // namespace

Axis<Speed> ClockGoals::speeds(const std::string& clock) {
    return {{Speed::kSlower, clock + " slower"},
            {Speed::kEqual, clock + " equal"},
            {Speed::kFaster, clock + " faster"}};
}

Axis<RejectCause> RejectedFrameGoals::causes() {
    Axis<RejectCause> axis;
    for (int i = 0; i < kRejectCauseCount; ++i) {
        const auto cause = static_cast<RejectCause>(i);
        axis.emplace_back(cause, reject_cause_key(cause));
    }
    return axis;
}

void cover_run(const RunGoals& goals, const Scenario& scenario, const RunReport& report) {
    RunCoverage(goals, scenario, report).sample();
}

}  // namespace metabuffer::coverage
