#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "random_scenario.h"
#include "report/bus_use.h"
#include "report/report.h"
#include "scenario/derived_timing.h"
#include "support/painted_segment.h"
#include "support/scenarios.h"
#include "tlm/run.h"
#include "tlm/schedule_observer.h"

// What level tlm reports to an observer of its time must be what its report counts, bus by bus and column by column.
namespace metabuffer::test::schedule_test {
namespace {

class Tally final : public tlm::ScheduleObserver {
  public:
    struct Bus {
        std::array<std::int64_t, kBusUseTable.size()> cycles{};  ///< by use
        std::int64_t pixels = 0, recovered_slots = 0;
        int frames = 0;
        std::int64_t last_cycle = -1;
        bool in_order = true;
    };
    std::map<int, Bus> buses;                            ///< by renderer
    std::map<std::pair<int, int>, std::int64_t> levels;  ///< the highest, by renderer and display
    std::map<int, std::vector<int>> composited_frames;   ///< by display
    std::map<int, CycleSpan> compositions;               ///< by frame, from the first column's first pixel on
    std::map<int, std::vector<int>> shown_frames;
    std::map<int, std::int64_t> stalled;
    std::map<std::pair<int, int>, std::map<int, std::int64_t>>
        starved_pixels;                                               ///< by renderer, display; frame
    std::map<std::pair<int, std::uint32_t>, CycleSpan> depth_frames;  ///< taken, by renderer, pair
    std::map<int, std::int64_t> rejected_links;                       ///< by renderer
    struct Beats {
        int frame;
        int pixels;
        std::int64_t first_cycle;
    };
    struct Level {
        std::int64_t cycle;
        int held_pixels;
    };
    std::map<std::pair<int, int>, std::vector<Beats>> sent;             ///< by renderer, display
    std::map<std::pair<int, int>, std::vector<Level>> reported;         ///< likewise: levels of buffers
    std::map<std::pair<int, int>, CycleSpan> columns;                   ///< by display, frame
    std::map<std::pair<int, int>, std::vector<CycleSpan>> standstills;  ///< likewise
    bool destinations_good = true;
    bool frames_good = true;  ///< tables are in order, and beats go on with the last one's segments
    bool levels_in_order = true;
    bool levels_of_beats = true;  ///< none is of a clock before the renderer's first beat

    void bus(int renderer, const tlm::BusSpan& span) override {
        Bus& bus = buses[renderer];
        bus.cycles.at(static_cast<std::size_t>(span.use)) += span.cycles.cycles();
        bus.in_order = bus.in_order && span.cycles.first > bus.last_cycle && span.cycles.cycles() > 0;
        bus.last_cycle = std::max(bus.last_cycle, span.cycles.last);
        if (span.use == BusUse::kTable) {
            frames_good = frames_good && span.frame == bus.frames++;
            sent_[renderer].clear();
        }
        if (span.use == BusUse::kBusy) {
            std::int64_t& next = sent_[renderer][span.display];
            frames_good = frames_good && span.frame == bus.frames - 1 && span.first_pixel == next;
            next += span.pixels;
            first_beats_.emplace(renderer, span.cycles.first);
            sent[{renderer, span.display}].push_back({span.frame, span.pixels, span.cycles.first});
            bus.pixels += span.pixels;
            bus.recovered_slots += span.recovered_slots;
        }
        if (span.use == BusUse::kBusy || span.use == BusUse::kPageMiss) {
            destinations_good = destinations_good && span.display >= 1;
        }
    }
    void buffer_level(int renderer, int display, std::int64_t cycle, int held_pixels) override {
        std::int64_t& last = level_cycles_[{renderer, display}];
        levels_in_order = levels_in_order && cycle >= last;
        last = cycle;
        levels_of_beats = levels_of_beats && cycle >= first_beats_.at(renderer);
        std::int64_t& highest = levels[{renderer, display}];
        highest = std::max<std::int64_t>(highest, held_pixels);
        reported[{renderer, display}].push_back({cycle, held_pixels});
    }
    void composited(int display, int frame, CycleSpan span) override {
        composited_frames[display].push_back(frame);
        columns[{display, frame}] = span;
        const auto [entry, is_first] = compositions.emplace(frame, span);
        if (!is_first) {
            entry->second.first = std::min(entry->second.first, span.first);
            entry->second.last = std::max(entry->second.last, span.last);
        }
    }
    void column_stall(int display, int frame, CycleSpan span) override {
        stalled[display] += span.cycles();
        standstills[{display, frame}].push_back(span);
    }
    void shown(int display, int frame, CycleSpan /*span*/) override {
        shown_frames[display].push_back(frame);
    }
    void link_frame(int renderer, const tlm::LinkFrameSeen& frame) override {
        if (frame.cause) ++rejected_links[renderer];
        if (frame.taken && frame.kind == FrameKind::kDepth) depth_frames[{renderer, frame.pair}] = frame.span;
    }
    void starved(int renderer, int display, const StarvedRun& run) override {
        starved_pixels[{renderer, display}][run.frame] += run.x_last - run.x_first + 1;
    }

  private:
    std::map<std::pair<int, int>, std::int64_t> level_cycles_;
    std::map<int, std::int64_t> first_beats_;          ///< clocks, by renderer
    std::map<int, std::map<int, std::int64_t>> sent_;  ///< pixels of the frame, by renderer, display
};

/// The latency of a frame is counted from the last pixel of its newest pair. The input framebuffer, whose clocks are
/// reported, has a pixel a link clock after that.
void check_links(const Tally& tally, const Scenario& scenario, const RunReport& report) {
    const std::int64_t link_clock = 1 + clock_period_picoseconds(scenario.clocks.dvi_in_mhz) /
                                            clock_period_picoseconds(scenario.clocks.core_mhz);
    std::vector<int> before(report.renderers.size(), -1);
    for (const FrameRecord& frame : report.frames) {
        std::int64_t newest = -1;
        for (std::size_t r = 0; r < before.size(); ++r) {
            if (frame.pairs[r] == before[r]) continue;
            before[r] = frame.pairs[r];
            const auto depth = tally.depth_frames.find(
                {static_cast<int>(r) + 1, static_cast<std::uint32_t>(frame.pairs[r])});
            REQUIRE(depth != tally.depth_frames.end());
            CHECK(depth->second.cycles() > 0);
            newest = std::max(newest, depth->second.last);
        }
        if (!frame.latency_cycles || newest < 0) continue;
        const std::int64_t last_pixel = frame.end_cycle - *frame.latency_cycles;
        CHECK(last_pixel <= newest);
        CHECK(newest <= last_pixel + link_clock);
    }
}

void check_tally(const Tally& tally, const Scenario& scenario, const RunReport& report) {
    REQUIRE(tally.buses.size() == report.renderers.size());
    for (std::size_t r = 0; r < report.renderers.size(); ++r) {
        INFO("renderer " << r + 1);
        const Tally::Bus& reported = tally.buses.at(static_cast<int>(r) + 1);
        const BusCounters& counted = report.renderers[r].bus;
        for (const BusUseTraits& use : kBusUseTable) {
            CHECK(reported.cycles.at(static_cast<std::size_t>(use.value)) == counted.*use.counter);
        }
        CHECK(reported.pixels == counted.pixels_sent);
        CHECK(reported.recovered_slots == counted.recovered_slots);
        CHECK(reported.in_order);
    }
    CHECK(tally.destinations_good);
    CHECK(tally.frames_good);
    CHECK(tally.levels_in_order);
    CHECK(tally.levels_of_beats);
    for (const ComposerCounters& composer : report.composers) {
        const auto level = tally.levels.find({composer.renderer, composer.display});
        const std::int64_t highest = level == tally.levels.end() ? 0 : level->second;
        CHECK(highest == composer.buffer_high_water);
    }
    for (const ComposerCounters& composer : report.composers) {
        INFO("renderer " << composer.renderer << ", display " << composer.display);
        const auto starved = tally.starved_pixels.find({composer.renderer, composer.display});
        for (int frame = 0; frame < scenario.frames; ++frame) {
            std::int64_t reported = 0;
            if (starved != tally.starved_pixels.end() && starved->second.count(frame) > 0) {
                reported = starved->second.at(frame);
            }
            CHECK(reported == composer.starved_pixels_of(frame));
        }
    }
    check_links(tally, scenario, report);
    std::vector<int> frames(static_cast<std::size_t>(scenario.frames));
    for (int frame = 0; frame < scenario.frames; ++frame) frames[static_cast<std::size_t>(frame)] = frame;
    for (const int frame : frames) {
        INFO("frame " << frame);
        CHECK(tally.compositions.at(frame).first ==
              report.frames.at(static_cast<std::size_t>(frame)).start_cycle);
        CHECK(tally.compositions.at(frame).last ==
              report.frames.at(static_cast<std::size_t>(frame)).end_cycle);
    }
    for (std::size_t d = 0; d < report.displays.size(); ++d) {
        INFO("display " << d + 1);
        const int display = static_cast<int>(d) + 1;
        CHECK(tally.composited_frames.at(display) == frames);
        CHECK(tally.shown_frames.at(display) == frames);
        const auto stalled = tally.stalled.find(display);
        CHECK((stalled == tally.stalled.end() ? 0 : stalled->second) == report.displays[d].stalled_cycles);
    }
}

/// A composer's buffer, pixel by pixel: its segment is painted, and the column takes its steps clock by clock.
class HeldPixels {
  public:
    HeldPixels(const Tally& tally, const Scenario& scenario, const RunReport& report, int renderer,
               int display)
        : tally_(tally), scenario_(scenario), renderer_(renderer), display_(display) {
        const Size raster{scenario.displays.raster_width_pixels(), scenario.displays.raster_height_pixels()};
        const Renderer& of = scenario.renderers[static_cast<std::size_t>(renderer) - 1];
        for (const FrameRecord& frame : report.frames) {
            const int pair = frame.pairs[static_cast<std::size_t>(renderer) - 1];
            std::optional<ViewportRow> own;
            if (pair >= 0) {
                const ViewportTable& table = of.frame_of_pair(static_cast<std::uint32_t>(pair)).table;
                for (const ViewportRow& row : validate_table(table, scenario.limits(of)).rows) {
                    if (row.dcomp == display) own = row;
                }
            }
            segments_.emplace_back(own, raster, scenario.composer.smoothing);
        }
    }

    std::int64_t at(std::int64_t cycle) const {
        std::int64_t held = 0;
        for (int frame = 0; frame < static_cast<int>(segments_.size()); ++frame) {
            held += std::max<std::int64_t>(0, arrived(frame, cycle) - released(frame, cycle));
        }
        return held;
    }

  private:
    std::int64_t arrived(int frame, std::int64_t cycle) const {
        const auto sent = tally_.sent.find({renderer_, display_});
        if (sent == tally_.sent.end()) return 0;
        const int beat_cycles = cycles_per_beat(scenario_.bus);
        const int beat_pixels = pixels_per_beat(scenario_.bus, scenario_.memory);
        std::int64_t pixels = 0;
        for (const Tally::Beats& beats : sent->second) {
            // The clock that samples the first beat is the one after the beat's last, and later by registers on the way.
            const std::int64_t first =
                beats.first_cycle + beat_cycles + bus_delay_cycles(scenario_.bus, scenario_.memory);
            if (beats.frame != frame || cycle < first) continue;
            const std::int64_t whole = (cycle - first) / beat_cycles + 1;
            pixels += std::min<std::int64_t>(beats.pixels, whole * beat_pixels);
        }
        return pixels;
    }
    std::int64_t released(int frame, std::int64_t cycle) const {
        const auto column = tally_.columns.find({display_, frame});
        if (column == tally_.columns.end()) return 0;
        std::int64_t step = cycle - column->second.first + 1;  // the span begins with step 1
        if (const auto stalls = tally_.standstills.find({display_, frame});
            stalls != tally_.standstills.end()) {
            for (const CycleSpan& stall : stalls->second) {
                if (stall.first > column->second.first) {
                    step -= std::clamp<std::int64_t>(cycle + 1 - stall.first, 0, stall.cycles());
                }
            }
        }
        const PaintedSegment& segment = segments_[static_cast<std::size_t>(frame)];
        const std::int64_t composited = step - (renderer_ - 1);  // positions
        if (composited <= 0) return composited == 0 ? segment.skipped : 0;
        const auto positions = static_cast<std::int64_t>(segment.released.size());
        return segment.released[static_cast<std::size_t>(std::min(composited, positions)) - 1];
    }

    const Tally& tally_;
    const Scenario& scenario_;
    int renderer_;
    int display_;
    std::vector<PaintedSegment> segments_;  ///< by frame
};

/// Each level that is reported is what the buffer holds in that clock.
void check_levels(const Tally& tally, const Scenario& scenario, const RunReport& report) {
    REQUIRE_FALSE(tally.reported.empty());
    for (const auto& [composer, levels] : tally.reported) {
        const auto [renderer, display] = composer;
        const HeldPixels held(tally, scenario, report, renderer, display);
        for (const Tally::Level& level : levels) {
            INFO("renderer " << renderer << ", display " << display << ", clock " << level.cycle);
            REQUIRE(level.held_pixels == held.at(level.cycle));
        }
    }
}

void check_machine(const Scenario& scenario) {
    INFO(describe(scenario));
    Tally tally;
    tlm::RunOptions options;
    options.observer = &tally;
    const tlm::RunResult result = tlm::run(scenario, options);
    check_tally(tally, scenario, result.report);
    check_levels(tally, scenario, result.report);
}

}  // namespace

namespace {

/// The first random machine from a seed on that has something.
template <typename Wanted>
Scenario machine_with(std::uint64_t seed, Wanted wanted) {
    for (;; ++seed) {
        Scenario scenario = random_scenario(seed);
        if (scenario.faults.empty() && scenario.displays.count() > 1 && scenario.renderers.size() > 1 &&
            wanted(scenario)) {
            return scenario;
        }
    }
}

}  // namespace

TEST_CASE("schedule: what a machine reports of its time is what it counts", "[system][schedule]") {
    check_machine(machine_with(100, [](const Scenario& scenario) { return scenario.frames > 1; }));
}

TEST_CASE("schedule: times and counters agree where pixels starve", "[system][schedule]") {
    Scenario scenario = machine_with(640, [](const Scenario& of) {
        return of.composer.on_starvation == StarvationMode::kGlitch && of.frames > 1;
    });
    scenario.memory.page_miss_cycles = 60;
    scenario.memory.precharge_cycles = 0;
    scenario.memory.given_activate_cycles.reset();
    Tally tally;
    tlm::RunOptions options;
    options.observer = &tally;
    const RunReport report = tlm::run(scenario, options).report;
    REQUIRE(report.total_starved_pixels() > 0);
    check_tally(tally, scenario, report);
}

TEST_CASE("schedule: times and counters agree where the link rejects frames", "[system][schedule]") {
    Scenario scenario = machine_with(700, [](const Scenario& of) { return of.frames > 2; });
    Fault fault;
    fault.kind = FaultKind::kCrc;
    fault.pair = 1;
    scenario.faults.push_back(fault);
    Tally tally;
    tlm::RunOptions options;
    options.observer = &tally;
    const RunReport report = tlm::run(scenario, options).report;
    check_tally(tally, scenario, report);
    CHECK(report.renderers[0].total_rejected_frames() == 1);
    CHECK(tally.rejected_links.at(1) == 1);
    CHECK(tally.depth_frames.count({1, 1}) == 0);
}

TEST_CASE("schedule: times and counters agree where the memory refreshes and the arbiter is slow",
          "[system][schedule]") {
    check_machine(machine_with(200, [](const Scenario& scenario) {
        return scenario.memory.refreshes() && scenario.bus.grant_cycles > 0 &&
               scenario.bus.slot_table == SlotTableMaker::kBuilt;
    }));
}

TEST_CASE("schedule: times and counters agree where slots are lost", "[system][schedule]") {
    check_machine(machine_with(300, [](const Scenario& scenario) {
        return scenario.bus.arbitration == Arbitration::kSlotAllocation;
    }));
}

TEST_CASE("schedule: times and counters agree where columns stall", "[system][schedule]") {
    Scenario scenario = machine_with(400, [](const Scenario& of) {
        return of.composer.on_starvation == StarvationMode::kStall && of.memory.page_miss_cycles > 6;
    });
    check_machine(scenario);
}

TEST_CASE("schedule: times and counters agree where ports are shared", "[system][schedule]") {
    check_machine(machine_with(
        500, [](const Scenario& scenario) { return scenario.memory.shared() && scenario.frames > 1; }));
}

}  // namespace metabuffer::test::schedule_test
