#pragma once

#include <cstdint>

#include "cover_group.h"
#include "key_coverage.h"
#include "report/report.h"
#include "scenario/scenario.h"
#include "segment_coverage.h"
#include "shared_groups.h"

namespace metabuffer::coverage {

struct ShapeGoals : CoverGroup {
    explicit ShapeGoals(Coverage& coverage)
        : CoverGroup(coverage, {"machine/shape", "renderers and displays"}) {}
    Ranges renderers{*this,
                     {{1, "1 renderer"},
                      {2, "2 renderers"},
                      {3, "3 renderers"},
                      {4, "4 renderers"},
                      {5, "5 renderers or more"}}};
    Bin one_display = bin("1 display");
    Bin displays_in_row = bin("displays in a row");
    Bin displays_in_column = bin("displays in a column");
    Bin displays_in_grid = bin("displays in a grid");
    Bin display_of_one_pixel = bin("display of one pixel");
    Bin display_one_pixel_wide = bin("display one pixel wide");
    Bin display_one_pixel_high = bin("display one pixel high");
    Bin raster_higher = bin("raster higher than wide");
    Bin raster_wider = bin("raster wider than high");
    Bin different_image_sizes = bin("renderers of different image sizes");
    Bin renderer_not_shown = bin("renderer that no display shows");
    Bin image_changes = bin("image changes between pairs");
    Bin frames_beyond_list = bin("frames beyond a renderer's list");
};

struct FrameGoals : CoverGroup {
    explicit FrameGoals(Coverage& coverage) : CoverGroup(coverage, groups::kSequence) {}
    Ranges frames{*this, {{1, "one frame"}, {2, "two frames"}, {3, "three frames or more"}}};
    Bin display_not_covered = bin("no renderer covers a display");
    Bin raster_of_one_pixel = bin("raster of one pixel");
    Bin shorter_than_column = bin("frame shorter than the column");
};

struct CorrectionGoals : CoverGroup {
    explicit CorrectionGoals(Coverage& coverage)
        : CoverGroup(coverage, {"display/correction", "colours that output framebuffers correct"}) {}
    Bin by_gains = bin("by gains alone");
    Bin by_gamma = bin("by gains and gamma");
    Bin by_table = bin("by a table of the host's");
    Bin brighter = bin("a channel brighter than its display can be");
    Bin every_display = bin("every display of several");
    Bin some_displays = bin("displays beside others without a table");
    Bin averaged = bin("behind averaging");
    Bin kept_frame = bin("a frame is kept off a corrected display");
};

/// A pixel clock compared with the core clock.
enum class Speed : std::uint8_t { kSlower, kEqual, kFaster };

struct ClockGoals : CoverGroup {
    explicit ClockGoals(Coverage& coverage)
        : CoverGroup(coverage, {"link/timing", "pixel clocks beside the core clock"}) {}
    static Axis<Speed> speeds(const std::string& clock);
    Cross<Speed, Speed> speed{*this, speeds("DVI in"), speeds("DVI out")};
    Bin in_no_whole_multiple = bin("DVI in no whole multiple");
    Bin out_no_whole_multiple = bin("DVI out no whole multiple");
    Bin in_whole_multiple = bin("DVI in whole multiple");
    Bin out_whole_multiple = bin("DVI out whole multiple");
    Bin three_clocks = bin("three different clocks");
    Bin shared_clock = bin("DVI in and out share a clock");
};

struct MemoryPortGoals : CoverGroup {
    explicit MemoryPortGoals(Coverage& coverage)
        : CoverGroup(coverage, {"memory/ports", "a memory whose data pins link and bus share"}) {}
    Bin bursts_wait = bin("bursts wait for the link's words");
    Bin no_burst_waits = bin("no burst waits for them");
    Bin refreshed = bin("refreshed");
    Bin read_latency = bin("with read latency");
    Bin short_last_block = bin("the image's last block is shorter");
    Bin block_of_one_clock = bin("a block takes one clock");
    Bin block_is_page = bin("a block is a page");
    Bin broken_off_frame = bin("a frame is broken off within a block");
};

struct BusDelayGoals : CoverGroup {
    explicit BusDelayGoals(Coverage& coverage)
        : CoverGroup(coverage, {"bus/delay", "clocks of the memory's reads and of registers on the bus"}) {}
    Bin both = bin("both");
    Bin beats_of_several_clocks = bin("with beats of several clocks");
};

struct LinkLayerGoals : CoverGroup {
    explicit LinkLayerGoals(Coverage& coverage)
        : CoverGroup(coverage, {"link/layer", "links of pixels and of characters"}) {}
    Bin tmds_free_running = bin("tmds, free-running");
    Bin tmds_own_clocks = bin("tmds, three clocks that differ");
    Bin tmds_rejected = bin("tmds, a frame rejected");
    Bin tmds_reset = bin("tmds, a reset");
    Bin tmds_drift = bin("tmds, a clock that drifts");
    Bin tmds_frame_lost = bin("tmds, a pair lost by its characters");
    Bin tmds_pixel_passes = bin("tmds, no pair lost by disturbed characters");
};

struct PageSizeGoals : CoverGroup {
    explicit PageSizeGoals(Coverage& coverage) : CoverGroup(coverage, groups::kPage) {}
    Ranges miss_cycles{*this, {{0, "miss costs nothing"}, {1, "miss costs 1 clock"}, {2, "miss costs more"}}};
    Bin one_word = bin("of one word");
    Bin smaller_than_beat = bin("smaller than a beat could be");
    Bin smaller_than_burst = bin("smaller than a burst");
    Bin larger_than_burst = bin("larger than a burst");
    Bin larger_than_image = bin("larger than the image");
};

struct BeatLimitGoals : CoverGroup {
    explicit BeatLimitGoals(Coverage& coverage) : CoverGroup(coverage, groups::kBeat) {}
    Bin four_clocks = bin("4 clocks a pixel");
    Bin two_clocks = bin("2 clocks a pixel");
    Bin bus_limits = bin("bus limits");
    Bin memory_limits = bin("memory limits");
    Bin bus_equals_memory = bin("bus equals memory");
};

struct BufferSizeGoals : CoverGroup {
    explicit BufferSizeGoals(Coverage& coverage) : CoverGroup(coverage, groups::kBuffer) {}
    Bin smallest = bin("smallest legal size");
    Bin beyond_a_burst = bin("one pixel beyond a burst");
    Bin ready_space_in_flight = bin("ready space is in-flight only");
    Bin ready_space_beyond_a_burst = bin("ready space is more than a burst");
};

struct StarvationModeGoals : CoverGroup {
    explicit StarvationModeGoals(Coverage& coverage)
        : CoverGroup(coverage, {"starvation/mode", "what starves does, under each arbitration"}) {}
    Cross<Arbitration> starved{*this, every<Arbitration>("", ", starved in glitch")};
    Cross<Arbitration> stalled{*this, every<Arbitration>("", ", stalled in stall")};
    Bin glitch_without_starving = bin("glitch without starving");
    Bin stall_without_stalling = bin("stall without stalling");
};

struct SlotGoals : CoverGroup {
    explicit SlotGoals(Coverage& coverage) : CoverGroup(coverage, groups::kArbitration) {}
    Cross<Arbitration> poll{*this, every<Arbitration>("", ", poll")};
    Bin irsa_recovers = bin("irsa, slots recovered");
    Bin round_robin_recovers = bin("round-robin, slots recovered");
    Bin slot_lost = bin("slot-allocation, slot lost");
};

struct SlotTableGoals : CoverGroup {
    explicit SlotTableGoals(Coverage& coverage)
        : CoverGroup(coverage, {"table/slots", "slot tables of frames that were composited"}) {}
    Bin built = bin("made by the hardware");
    Bin of_host = bin("the host's, as the policy has it");
    Bin shortened = bin("the host's, shortened to fit the scanline");
    Bin given = bin("given in the scenario");
    Bin missing = bin("missing");
    Bin wrong = bin("wrong");
    Bin beside_dropped_rows = bin("the host's, of a table with dropped rows");
};

struct WatchdogGoals : CoverGroup {
    explicit WatchdogGoals(Coverage& coverage) : CoverGroup(coverage, {"watchdog", "the watchdog"}) {}
    Bin silent = bin("silent in a whole run");
    Bin interval_derived = bin("interval derived");
    Bin interval_given = bin("interval given");
    Bin ends_run = bin("ends a run");
    Bin names_input_framebuffer = bin("names an input framebuffer");
    Bin names_composer = bin("names a composer");
    Bin names_output_framebuffer = bin("names an output framebuffer");
    Bin before_first_frame = bin("trips before the first frame is shown");
    Bin after_a_frame = bin("trips after a frame was shown");
};

struct PacingGoals : CoverGroup {
    explicit PacingGoals(Coverage& coverage) : CoverGroup(coverage, groups::kPacing) {}
    Cross<Pacing> nothing_before_first{*this, every<Pacing>("", ", nothing before the first pair")};
    Bin lockstep_too_late_dropped = bin("lockstep, pair too late dropped");
    Bin free_running_again = bin("free-running, again");
    Bin free_running_dropped = bin("free-running, overwritten pair dropped");
    Bin drops_and_repeats = bin("free-running, drops and repeats in one run");
};

inline Axis<Pacing> in_pacing() {
    return {{Pacing::kLockstep, "in lockstep"}, {Pacing::kFreeRunning, "free-running"}};
}

struct RejectedFrameGoals : CoverGroup {
    explicit RejectedFrameGoals(Coverage& coverage)
        : CoverGroup(coverage, {"link/rejected", "frames and pairs rejected, by cause and fault"}) {}
    static Axis<RejectCause> causes();
    Cross<RejectCause, FrameKind> cause{*this, causes(), every<FrameKind>("", " frame")};
    Bin first_pair = bin("first pair");
    Bin later_pair = bin("later pair");
    Bin last_pair = bin("last pair");
    Bin good_pair_behind = bin("good pair behind it");
    Bin two_pairs_running = bin("two pairs running");
    Bin two_renderers = bin("two renderers in a frame");
    Cross<Pacing> pacing{*this, in_pacing()};
};

struct FaultLocationGoals : CoverGroup {
    explicit FaultLocationGoals(Coverage& coverage)
        : CoverGroup(coverage, {"faults/place", "where faults strike"}) {}
    Bin first_pair = bin("first pair");
    Bin last_pair = bin("last pair");
    Bin pair_between = bin("pair in between");
    Bin two_faults = bin("two faults in a run");
    Bin two_renderers = bin("two renderers at once");
    Cross<Pacing> pacing{*this, in_pacing()};
    Cross<StarvationMode> starvation{*this, every<StarvationMode>("in ")};
    Bin pixels_lost = bin("pixels lost on a bus");
    Bin table_lost = bin("table lost on a bus");
    Bin frame_kept_off = bin("frame kept off the displays");
    Bin good_frame_behind = bin("good frame shown behind a faulty one");
    Bin short_silence = bin("silence shorter than the timeout");
    Bin long_silence = bin("silence longer than the timeout");
    Bin drifts_fast = bin("clock drifts fast");
    Bin drifts_slow = bin("clock drifts slow");
};

struct OverlapGoals : CoverGroup {
    explicit OverlapGoals(Coverage& coverage) : CoverGroup(coverage, groups::kDepth) {}
    Bin three_renderers = bin("three renderers at one raster pixel");
};

/// Goals of a run, by its scenario and its report.
struct RunGoals : GoalSet {
    using GoalSet::GoalSet;
    KeyGoals keys{coverage};
    TableGoals tables{coverage};
    SlotTableGoals slot_tables{coverage};
    ShapeGoals shape{coverage};
    FrameGoals frames{coverage};
    CorrectionGoals correction{coverage};
    ClockGoals clocks{coverage};
    PageSizeGoals page{coverage};
    BeatLimitGoals beat{coverage};
    MemoryPortGoals ports{coverage};
    BusDelayGoals delay{coverage};
    LinkLayerGoals links{coverage};
    BufferSizeGoals buffer{coverage};
    StarvationModeGoals starvation{coverage};
    SlotGoals slots{coverage};
    WatchdogGoals watchdog{coverage};
    PacingGoals pacing{coverage};
    RejectedFrameGoals rejected{coverage};
    FaultLocationGoals fault_location{coverage};
    OverlapGoals overlap{coverage};
};

/// Counts what the scenario and the report of a finished run at level rtl show: modes, clocks, tables and segments of
/// the frames composited, pacing, faults. MachineCoverage counts what only the wires show.
void cover_run(const RunGoals& goals, const Scenario& scenario, const RunReport& report);

}  // namespace metabuffer::coverage
