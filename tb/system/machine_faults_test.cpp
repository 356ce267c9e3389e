#include "rtl/machine_faults.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <systemc>
#include <utility>
#include <vector>

#include "functional/functional_compositor.h"
#include "machine_checks.h"
#include "machine_run.h"
#include "naive_pipeline.h"
#include "random_scenario.h"
#include "rtl/wires.h"
#include "scenario/derived_timing.h"
#include "scenario/names.h"
#include "scenario/scenario_loader.h"
#include "support/images.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "support/trace_switch.h"

namespace metabuffer::test::machine_faults_test {

namespace {

constexpr int kFrames = 5;
constexpr int kNarrowestForTwoRows = 17;  ///< image whose control scanline holds a table of two rows
constexpr int kDisplays = 2;
constexpr std::size_t kFaultyRenderer = 1;  // index: in the middle of three
constexpr int kFaultyDisplay = 2;

struct Machine {
    StarvationMode mode = StarvationMode::kStall;
    int multiple = 1;
    int buffer_pixels = 64;
    int bus_bits = 64;
    Pacing pacing = Pacing::kLockstep;
};

/// Three renderers on two displays. Every pair has its own image, so that a picture made of parts of two frames cannot
/// pass for a good one. The links are so fast that the buses have hardly a pause.
Scenario three_renderers(const Machine& machine) {
    Random random(77);
    Scenario scenario = small_scenario(14, 12, kDisplays);
    scenario.name = "machine-faults";
    scenario.clocks = {25.0, 250.0, 125.0};
    scenario.watchdog_cycles = 6000;
    scenario.memory.words_per_cycle = 4;
    scenario.memory.page_words = 64;
    scenario.memory.page_miss_cycles = 3;
    scenario.bus.width_bits = machine.bus_bits;
    scenario.bus.burst_pixels = 8;
    scenario.composer.buffer_pixels = machine.buffer_pixels;
    scenario.composer.ready_space_pixels = 8;
    scenario.composer.on_starvation = machine.mode;
    scenario.pacing = machine.pacing;
    scenario.frames = kFrames;
    // What is kept is kept corrected, and black stays black.
    DisplayCorrection& correction = scenario.displays.correction.emplace_back();
    correction.display = kDisplays;
    correction.gamma = 0.8;
    const int width = 24 / machine.multiple;
    const int height = 10 / machine.multiple;
    for (int r = 0; r < 3; ++r) {
        std::vector<PixelImage> images;
        std::vector<Viewport> viewports;
        for (int pair = 0; pair < kFrames; ++pair) {
            images.push_back(opaque_noise_image(random, std::max(width, kNarrowestForTwoRows), height));
            viewports.push_back(Viewport{2 + (pair + r) % 3, 1 + pair % 2, machine.multiple});
        }
        add_renderer(scenario, renderer_of(images, viewports, scenario.displays.wall()));
    }
    check_scenario(scenario);
    return scenario;
}

Fault machine_fault(FaultKind kind, std::int64_t from_cycle) {
    Fault fault;
    fault.kind = kind;
    fault.renderer = static_cast<int>(kFaultyRenderer);
    if (kind != FaultKind::kRandomStalls) fault.display = kFaultyDisplay;
    fault.from_cycle = from_cycle;
    return fault;
}

/// What level functional makes of the pairs that the machine took for a frame.
ColourImage reference(const MachineRun& run, int frame, int display) {
    const auto& pairs = run.report().frames.at(static_cast<std::size_t>(frame)).pairs;
    return functional::composite_display(run.scenario(), functional::contributions_of(run.scenario(), pairs),
                                         display);
}

ColourImage black(const Scenario& scenario) {
    return ColourImage(scenario.displays.width_pixels, scenario.displays.height_pixels);
}

/// Checks that what the run has shown is whole, on every display: each frame shows its own picture, and each of those
/// in `kept` the picture before. Returns how many frames every display has shown.
int check_shown(const MachineRun& run, const std::set<int>& kept) {
    const int frames = run.scenario().frames;
    int shown_on_all = frames;
    for (int display = 1; display <= kDisplays; ++display) {
        ColourImage before = black(run.scenario());
        for (int frame = 0; frame < frames; ++frame) {
            INFO("frame " << frame << " on display " << display);
            const ColourImage* shown = run.picture(frame, display);
            if (shown == nullptr) {
                shown_on_all = std::min(shown_on_all, frame);
                break;
            }
            if (frame >= static_cast<int>(run.report().frames.size())) break;  // not yet on the other display
            if (kept.count(frame) == 0) {
                const bool starved = run.report().total_starved_pixels() > 0;
                before =
                    starved ? picture_without_glitches(run, frame, display) : reference(run, frame, display);
            }
            CHECK(differing_pixels(shown, before) == 0);
        }
    }
    return shown_on_all;
}

void run_traced(MachineRuns& runs) {
    TraceSwitch trace;
    for (const auto& run : runs) trace.add(run->machine());
    REQUIRE(run_to_end(runs));
}

const RendererCounters& faulty(const MachineRun& run) { return run.report().renderers[kFaultyRenderer]; }

const ComposerCounters& faulty_composer(const MachineRun& run) {
    return run.drained_report().composers[kFaultyRenderer * kDisplays + kFaultyDisplay - 1];
}

bool any_contains(const std::vector<std::string>& lines, const std::string& text) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(text) != std::string::npos; });
}

std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
}

}  // namespace

// ---- wires that stay low ----

TEST_CASE("a composer that never raises BUSREADY: the watchdog names it and nothing half done is shown",
          "[system][faults]") {
    MachineRuns runs;
    for (const StarvationMode mode : {StarvationMode::kStall, StarvationMode::kGlitch}) {
        Machine machine;
        machine.mode = mode;
        runs.push_back(std::make_unique<MachineRun>(
            "run_" + std::to_string(runs.size()),
            with_fault(three_renderers(machine), machine_fault(FaultKind::kBusreadyLow, 0))));
    }
    run_traced(runs);
    for (const auto& run : runs) {
        const std::vector<std::string>& findings = run->machine().watchdog_findings();
        INFO(joined(findings));
        CHECK(any_contains(findings, "composer_2_2 waits for its buffer to be prefetched with frame 0"));
        CHECK(any_contains(findings, "input_framebuffer_2 waits for BUSREADY of the composers of display 2"));
        CHECK(any_contains(findings, "busready_fault_2_2 holds BUSREADY_2_2 low"));
        CHECK(check_shown(*run, {}) == 0);
        CHECK(run->picture(0, 1) == nullptr);  // display 1 could, but they swap together
        CHECK(faulty(*run).injected_faults == 1);
        CHECK(faulty_composer(*run).buffer_high_water == 0);
    }
}

TEST_CASE("a composer that never raises PIPEREADY: the watchdog names it and nothing is shown",
          "[system][faults]") {
    MachineRuns runs;
    for (const int renderer : {0, 1, 2}) {
        Fault fault = machine_fault(FaultKind::kPipereadyLow, 0);
        fault.renderer = renderer;
        runs.push_back(std::make_unique<MachineRun>("run_" + std::to_string(renderer),
                                                    with_fault(three_renderers({}), fault)));
    }
    run_traced(runs);
    const std::vector<std::vector<std::string>> expected = {
        // The PIPEMASTER has no wire for its own PIPEREADY: the fault keeps it from raising it.
        {"composer_1_2 waits for PIPEREADY from below for frame 0",
         "pipeready_fault_2_2 holds PIPEREADY_2_2 low"},
        {"composer_1_2 waits for PIPEREADY from below for frame 0",
         "composer_2_2 waits for STARTFRAME of frame 0", "pipeready_fault_2_2 holds PIPEREADY_2_2 low"},
        {"composer_2_2 waits for PIPEREADY from below for frame 0",
         "composer_3_2 waits for STARTFRAME of frame 0", "pipeready_fault_3_2 holds PIPEREADY_3_2 low"},
    };
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const MachineRun& run = *runs[i];
        INFO(joined(run.machine().watchdog_findings()));
        for (const std::string& line : expected[i]) {
            INFO(line);
            CHECK(any_contains(run.machine().watchdog_findings(), line));
        }
        CHECK(check_shown(run, {}) == 0);
        CHECK(run.report().renderers[i].injected_faults == 1);
    }
}

TEST_CASE("a wire that goes low for ever in the middle of a run: the last good frame stays",
          "[system][faults]") {
    MachineRuns runs;
    for (const FaultKind kind : {FaultKind::kBusreadyLow, FaultKind::kPipereadyLow}) {
        for (const std::int64_t from : {1500, 1801, 2102, 2403, 2704}) {
            runs.push_back(
                std::make_unique<MachineRun>("run_" + std::to_string(runs.size()),
                                             with_fault(three_renderers({}), machine_fault(kind, from))));
        }
    }
    run_traced(runs);
    std::set<int> frames_shown;
    for (const auto& run : runs) {
        const Fault& fault = run->scenario().faults[0];
        INFO(to_string(fault.kind) << " from cycle " << fault.from_cycle);
        INFO(joined(run->machine().watchdog_findings()));
        CHECK_FALSE(run->machine().watchdog_findings().empty());
        const int shown = check_shown(*run, {});
        CHECK(shown >= 1);
        CHECK(shown < kFrames);
        CHECK(run->report().frames.size() == static_cast<std::size_t>(shown));
        CHECK(faulty(*run).injected_faults == 1);
        frames_shown.insert(shown);
    }
    CHECK(frames_shown.size() >= 2);
}

TEST_CASE("a wire that is low for a while: every frame is shown and right", "[system][faults][repeat]") {
    Random random(random_seed(4101));
    INFO("METABUFFER_SEED=" << random_seed(4101));
    MachineRuns runs;
    for (int i = 0; i < 30; ++i) {
        Machine machine;
        machine.multiple = i % 3 == 0 ? 2 : 1;
        machine.bus_bits = 16 << random.between(0, 4);
        machine.mode = i % 4 == 0 ? StarvationMode::kGlitch : StarvationMode::kStall;
        Fault fault = machine_fault(i % 2 == 0 ? FaultKind::kBusreadyLow : FaultKind::kPipereadyLow,
                                    random.between(0, 1400));
        fault.cycles = random.one_in(3) ? random.between(1, 3) : random.between(1, 300);
        fault.renderer = random.between(0, 2);
        runs.push_back(std::make_unique<MachineRun>("run_" + std::to_string(i),
                                                    with_fault(three_renderers(machine), fault)));
    }
    run_traced(runs);
    for (const auto& run : runs) {
        const Fault& fault = run->scenario().faults[0];
        INFO(to_string(fault.kind) << " of renderer " << fault.renderer << " from cycle " << fault.from_cycle
                                   << " for " << *fault.cycles << ": " << describe(run->scenario()));
        check_run(*run);
        for (const ComposerCounters& composer : run->report().composers) CHECK(composer.lost_pixels == 0);
    }
}

// ---- lost beats ----

namespace {

/// Where in the run a beat was lost, seen at the machine's wires.
struct LostBeat {
    int frame = 0;
    int pixels = 0;
    bool first_of_burst = false;
    bool last_of_burst = false;
    bool last_of_segment = false;
    bool while_compositing = false;  ///< this very frame
    std::int64_t known_cycle = -1;   ///< the edge at which the composer can know; -1: never
};

/// Follows the bus of the faulty renderer, before and behind the fault, and the faulty composer's pixels.
class LossProbe final : public sc_core::sc_module {
  public:
    LossProbe(const sc_core::sc_module_name& name, const MachineRun& run, rtl::Metabuffer& machine)
        : sc_core::sc_module(name),
          raster_pixels_(std::int64_t{run.scenario().displays.raster_width_pixels()} *
                         run.scenario().displays.raster_height_pixels()),
          sent_(machine.wires().bus[kFaultyRenderer]),
          seen_(machine.wires().bus_seen_by(kFaultyRenderer * kDisplays + kFaultyDisplay - 1)),
          pipe_(machine.wires().pipe[(kFaultyRenderer + 1) * kDisplays + kFaultyDisplay - 1]),
          column_stall_(machine.wires().column_stall[kFaultyDisplay - 1]) {
        SC_METHOD(clock_edge);
        sensitive << machine.core_clk().posedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(LossProbe);

    const std::vector<LostBeat>& losses() const { return losses_; }

    std::int64_t lost_pixels() const {
        std::int64_t pixels = 0;
        for (const LostBeat& loss : losses_) pixels += loss.known_cycle >= 0 ? loss.pixels : 0;
        return pixels;
    }
    bool all_known() const {
        return std::all_of(losses_.begin(), losses_.end(),
                           [](const LostBeat& loss) { return loss.known_cycle >= 0; });
    }
    /// The frames that can be replaced by the picture before, since the composer knew before its last raster pixel.
    std::set<int> frames_known_in_time() const {
        std::set<int> frames;
        for (const LostBeat& loss : losses_) {
            const auto frame = static_cast<std::size_t>(loss.frame);
            const bool ended = frame < frame_ends_.size();
            if (loss.known_cycle >= 0 && (!ended || loss.known_cycle < frame_ends_[frame])) {
                frames.insert(loss.frame);
            }
        }
        return frames;
    }
    std::set<int> frames_not_known_in_time() const {
        const std::set<int> in_time = frames_known_in_time();
        std::set<int> frames;
        for (const LostBeat& loss : losses_) {
            if (in_time.count(loss.frame) == 0) frames.insert(loss.frame);
        }
        return frames;
    }

  private:
    void clock_edge() {
        ++cycle_;
        // A pipeline that stands still shows its pixel again.
        const bool stood_still = std::exchange(standing_, column_stall_.read());
        if (pipe_.read().valid && !stood_still) {
            // Composited at the edge before this one.
            if (++piped_ % raster_pixels_ == 0) frame_ends_.push_back(cycle_ - 1);
        }
        const rtl::BusBeat& sent = sent_.read();
        const bool mine =
            sent.kind == rtl::BusBeat::Kind::kPixels && sent.destination == std::uint16_t{kFaultyDisplay};
        const bool arrives = seen_.read().kind == sent.kind;
        if (sent.kind == rtl::BusBeat::Kind::kFrameStart) {
            if (frame_ >= 0 && !losses_.empty()) {
                // Nothing came after the segment's last pixels.
                losses_.back().last_of_segment = losses_.back().frame == frame_ && last_mine_lost_;
            }
            ++frame_;
        }
        if ((sent.kind == rtl::BusBeat::Kind::kFrameStart || mine) && arrives) {
            for (LostBeat& loss : losses_) {
                if (loss.known_cycle < 0) loss.known_cycle = cycle_;
            }
        }
        if (!mine) return;
        const bool first = left_ == 0;
        left_ = sent.remaining;
        last_mine_lost_ = !arrives;
        if (arrives) return;
        LostBeat loss;
        loss.frame = frame_;
        loss.pixels = sent.count;
        loss.first_of_burst = first;
        loss.last_of_burst = sent.remaining == 0;
        loss.while_compositing = piped_ / raster_pixels_ == frame_ && piped_ % raster_pixels_ != 0;
        losses_.push_back(loss);
    }

    std::int64_t raster_pixels_;
    const sc_core::sc_signal<rtl::BusBeat>& sent_;
    const sc_core::sc_signal<rtl::BusBeat>& seen_;
    const sc_core::sc_signal<rtl::PipePixel>& pipe_;
    const sc_core::sc_signal<bool>& column_stall_;
    bool standing_ = false;
    std::int64_t cycle_ = -1;
    std::int64_t piped_ = 0;
    std::vector<std::int64_t> frame_ends_;  ///< edge of each frame's last pixel
    int frame_ = -1;                        ///< whose beats the bus carries
    std::uint32_t left_ = 0;                ///< of the burst, by the last beat
    bool last_mine_lost_ = false;
    std::vector<LostBeat> losses_;
};

/// Which kinds of loss a set of runs has met.
struct LossCoverage {
    int first = 0, middle = 0, last = 0, single = 0, segment_end = 0;
    int prefetching = 0, compositing = 0, several = 0, whole_burst = 0;
    int kept = 0, not_known_in_time = 0, never_known = 0;

    void take(const LossProbe& probe) {
        for (const LostBeat& loss : probe.losses()) {
            single += loss.first_of_burst && loss.last_of_burst ? 1 : 0;
            first += loss.first_of_burst && !loss.last_of_burst ? 1 : 0;
            last += loss.last_of_burst && !loss.first_of_burst ? 1 : 0;
            middle += !loss.first_of_burst && !loss.last_of_burst ? 1 : 0;
            segment_end += loss.last_of_segment ? 1 : 0;
            compositing += loss.while_compositing ? 1 : 0;
            prefetching += loss.while_compositing ? 0 : 1;
            never_known += loss.known_cycle < 0 ? 1 : 0;
        }
        several += probe.losses().size() > 1 ? 1 : 0;
        whole_burst += probe.losses().size() >= 8 ? 1 : 0;
        kept += static_cast<int>(probe.frames_known_in_time().size());
        not_known_in_time += static_cast<int>(probe.frames_not_known_in_time().size());
    }
};

/// Machines, each with a probe on its wires.
template <typename Probe>
struct ProbedRuns {
    MachineRuns runs;
    std::vector<std::unique_ptr<Probe>> probes;

    void add(const Scenario& scenario) {
        const std::string number = std::to_string(runs.size());
        runs.push_back(std::make_unique<MachineRun>("run_" + number, scenario));
        probes.push_back(
            std::make_unique<Probe>(("probe_" + number).c_str(), *runs.back(), runs.back()->machine()));
    }

    /// Runs them all, has judge(run, probe) judge each, and returns what they have covered.
    template <typename Coverage, typename Judge>
    Coverage run(Judge judge) {
        run_traced(runs);
        Coverage coverage;
        for (std::size_t i = 0; i < runs.size(); ++i) {
            INFO("run " << i << ": " << describe(runs[i]->scenario()));
            judge(*runs[i], *probes[i]);
            coverage.take(*probes[i]);
        }
        return coverage;
    }
};

/// All checks of a run in which beats were lost.
void check_losses(const MachineRun& run, const LossProbe& probe) {
    const Fault& fault = run.scenario().faults[0];
    const bool stall = run.scenario().composer.on_starvation == StarvationMode::kStall;
    for (const LostBeat& loss : probe.losses()) {
        UNSCOPED_INFO("lost " << loss.pixels << " pixels of frame " << loss.frame
                              << (loss.first_of_burst ? ", first of a burst" : "")
                              << (loss.last_of_burst ? ", last of a burst" : "") << ", known at "
                              << loss.known_cycle);
    }
    UNSCOPED_INFO(fault.beats << " beats from cycle " << fault.from_cycle << ", "
                              << joined(run.machine().watchdog_findings()));
    CHECK(faulty(run).injected_faults == static_cast<std::int64_t>(probe.losses().size()));
    CHECK(faulty_composer(run).lost_pixels == probe.lost_pixels());
    for (const ComposerCounters& composer : run.drained_report().composers) {
        if (composer.renderer == static_cast<int>(kFaultyRenderer) + 1 &&
            composer.display == kFaultyDisplay) {
            continue;
        }
        CHECK(composer.lost_pixels == 0);
        CHECK((!stall || composer.starved_pixels == 0));
    }
    const std::set<int> kept = probe.frames_known_in_time();
    const int shown = check_shown(run, kept);
    if (run.machine().watchdog_findings().empty()) {
        CHECK(shown == kFrames);
    } else {
        // The last frame's last pixels: nothing comes after them that could show the loss.
        CHECK_FALSE(probe.all_known());
        CHECK(shown == kFrames - 1);
        CHECK(any_contains(run.machine().watchdog_findings(), "composer_2_2 waits for "));
    }
    for (const DisplayCounters& display : run.report().displays) {
        CHECK(display.frames_shown == shown);
        CHECK(display.kept_frames == static_cast<std::int64_t>(kept.size()));
    }
    // No frame that was composited without its pixels is shown, unless nobody could know.
    if (stall) {
        CHECK(run.report().total_starved_pixels() == 0);
        CHECK((probe.frames_not_known_in_time().empty() || !probe.all_known()));
    }
}

}  // namespace

namespace {

/// Runs machines that lose beats here and there, and checks each. Returns what they have met.
LossCoverage lose_beats(StarvationMode mode, std::uint64_t seed, bool stalled = false) {
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ProbedRuns<LossProbe> all;
    constexpr int kBeats[] = {1, 1, 1, 1, 2, 3, 8, 30, 400};
    const int machines = stalled ? 20 : 36;
    for (int i = 0; i < machines; ++i) {
        Machine machine;
        machine.mode = mode;
        machine.multiple = i % 3 == 2 ? 2 : 1;
        machine.buffer_pixels = random.one_in(3) ? 32 : random.between(40, 200);
        machine.bus_bits = 64 << random.between(0, 2);
        Fault fault = machine_fault(FaultKind::kLostBeat, random.between(500, 3200));
        fault.beats = kBeats[random.between(0, 8)];
        Scenario scenario = with_fault(three_renderers(machine), fault);
        if (stalled) {
            // Of the last row, so that the swap is held back, too, and not of the row whose faults are counted.
            Fault stalls = random_stalls(2, random.between(20, 70));
            stalls.seed = random.bits() >> 20U;
            scenario = with_fault(scenario, stalls);
        }
        all.add(scenario);
    }
    const auto coverage = all.run<LossCoverage>(check_losses);
    CHECK(coverage.first > 0);
    CHECK(coverage.middle > 0);
    CHECK(coverage.last > 0);
    CHECK(coverage.segment_end > 0);
    CHECK(coverage.prefetching > 0);
    CHECK(coverage.compositing > 0);
    CHECK(coverage.several > 0);
    CHECK(coverage.whole_burst > 0);
    CHECK(coverage.kept > 0);
    return coverage;
}

}  // namespace

TEST_CASE("lost beats in stall mode: their frame is not shown and the next good one is",
          "[system][faults][repeat]") {
    const LossCoverage coverage = lose_beats(StarvationMode::kStall, random_seed(4201));
    CHECK(coverage.never_known > 0);  // and the watchdog has reported it
}

TEST_CASE("lost beats in glitch mode: their frame is not shown and the next good one is",
          "[system][faults][repeat]") {
    const LossCoverage coverage = lose_beats(StarvationMode::kGlitch, random_seed(4301));
    CHECK(coverage.not_known_in_time > 0);  // shown, and its starved pixels counted
}

TEST_CASE("lost beats in stall mode while the swap is held back: a bad frame is kept off every display",
          "[system][faults][repeat]") {
    lose_beats(StarvationMode::kStall, random_seed(4401), true);
}

TEST_CASE("lost beats in glitch mode while the swap is held back: a bad frame is kept off every display",
          "[system][faults][repeat]") {
    lose_beats(StarvationMode::kGlitch, random_seed(4501), true);
}

// ---- lost tables ----

namespace {

/// Follows the bus of the faulty renderer, before and behind the fault, and the faulty composer's pixels, frame by frame.
class TableProbe final : public sc_core::sc_module {
  public:
    struct Frame {
        bool start_lost = false;
        bool rows_lost = false;
        bool pixels_lost = false;
        bool loss_known = false;  ///< a beat has come after what was lost
        bool marked = false;      ///< its pixels have left the composer marked as lost
        rtl::BusBeat::Kind told_by = rtl::BusBeat::Kind::kNone;

        bool table_lost() const { return start_lost || rows_lost; }
        bool touched() const { return table_lost() || pixels_lost; }
    };

    TableProbe(const sc_core::sc_module_name& name, const MachineRun& run, rtl::Metabuffer& machine)
        : sc_core::sc_module(name),
          raster_pixels_(std::int64_t{run.scenario().displays.raster_width_pixels()} *
                         run.scenario().displays.raster_height_pixels()),
          sent_(machine.wires().bus[kFaultyRenderer]),
          seen_(machine.wires().bus_seen_by(kFaultyRenderer * kDisplays + kFaultyDisplay - 1)),
          pipe_(machine.wires().pipe[(kFaultyRenderer + 1) * kDisplays + kFaultyDisplay - 1]),
          column_stall_(machine.wires().column_stall[kFaultyDisplay - 1]),
          frames_(kFrames) {
        SC_METHOD(clock_edge);
        sensitive << machine.core_clk().posedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(TableProbe);

    const std::vector<Frame>& frames() const { return frames_; }
    std::int64_t beats_lost() const { return beats_lost_; }
    std::int64_t tables_known_to_be_lost() const {
        return std::count_if(frames_.begin(), frames_.end(),
                             [](const Frame& frame) { return frame.table_lost() && frame.loss_known; });
    }
    std::set<int> marked() const {
        return those([](const Frame& frame) { return frame.marked; });
    }
    std::set<int> not_known() const {
        return those([](const Frame& frame) { return frame.touched() && !frame.loss_known; });
    }

  private:
    template <typename Condition>
    std::set<int> those(Condition condition) const {
        std::set<int> numbers;
        for (int i = 0; i < kFrames; ++i) {
            if (condition(frames_[static_cast<std::size_t>(i)])) numbers.insert(i);
        }
        return numbers;
    }

    void clock_edge() {
        // A pipeline that stands still shows its pixel again.
        const bool stood_still = std::exchange(standing_, column_stall_.read());
        if (pipe_.read().valid && !stood_still) {
            Frame& frame = frames_.at(static_cast<std::size_t>(piped_++ / raster_pixels_));
            frame.marked = frame.marked || pipe_.read().lost;
        }
        const rtl::BusBeat& sent = sent_.read();
        if (sent.kind == rtl::BusBeat::Kind::kNone) return;
        sent_frame_ += sent.kind == rtl::BusBeat::Kind::kFrameStart ? 1 : 0;
        if (seen_.read().kind == sent.kind) {
            arrive(sent);
        } else {
            lose(sent);
        }
    }

    void lose(const rtl::BusBeat& beat) {
        ++beats_lost_;
        Frame& frame = frames_.at(static_cast<std::size_t>(sent_frame_));
        if (beat.kind == rtl::BusBeat::Kind::kPixels && beat.destination != kFaultyDisplay) return;
        frame.loss_known = false;
        frame.start_lost = frame.start_lost || beat.kind == rtl::BusBeat::Kind::kFrameStart;
        frame.rows_lost = frame.rows_lost || beat.kind == rtl::BusBeat::Kind::kTableRow;
        frame.pixels_lost = frame.pixels_lost || beat.kind == rtl::BusBeat::Kind::kPixels;
    }

    void arrive(const rtl::BusBeat& beat) {
        for (int i = 0; i <= sent_frame_; ++i) {
            Frame& frame = frames_[static_cast<std::size_t>(i)];
            if (!frame.touched() || frame.loss_known) continue;
            // Pixels for another display show that a table was lost, but not that pixels were.
            const bool tells = frame.table_lost() || i < sent_frame_ || beat.destination == kFaultyDisplay;
            frame.loss_known = tells;
            if (tells) frame.told_by = beat.kind;
        }
    }

    std::int64_t raster_pixels_;
    const sc_core::sc_signal<rtl::BusBeat>& sent_;
    const sc_core::sc_signal<rtl::BusBeat>& seen_;
    const sc_core::sc_signal<rtl::PipePixel>& pipe_;
    const sc_core::sc_signal<bool>& column_stall_;
    bool standing_ = false;
    std::int64_t piped_ = 0;
    int sent_frame_ = -1;
    std::int64_t beats_lost_ = 0;
    std::vector<Frame> frames_;
};

/// What a set of runs has met.
struct TableLossCoverage {
    int start_told_by_row = 0, start_told_by_pixels = 0, start_told_by_start = 0;
    int rows_told_by_row = 0, rows_told_by_pixels = 0, rows_told_by_start = 0;
    int several = 0, not_known = 0, recovered = 0, pixels_too = 0;

    void take(const TableProbe& probe) {
        int lost = 0;
        for (const TableProbe::Frame& frame : probe.frames()) {
            not_known += frame.table_lost() && !frame.loss_known ? 1 : 0;
            recovered += lost > 0 && !frame.touched() && !frame.marked ? 1 : 0;
            if (!frame.table_lost() || !frame.loss_known) continue;
            ++lost;
            pixels_too += frame.pixels_lost ? 1 : 0;
            const bool by_row = frame.told_by == rtl::BusBeat::Kind::kTableRow;
            const bool by_pixels = frame.told_by == rtl::BusBeat::Kind::kPixels;
            int& told =
                frame.start_lost
                    ? (by_row ? start_told_by_row : (by_pixels ? start_told_by_pixels : start_told_by_start))
                    : (by_row ? rows_told_by_row : (by_pixels ? rows_told_by_pixels : rows_told_by_start));
            ++told;
        }
        several += lost > 1 ? 1 : 0;
    }
};

/// All checks of a run in which beats of tables were lost.
void check_table_losses(const MachineRun& run, const TableProbe& probe) {
    const Fault& fault = run.scenario().faults[0];
    UNSCOPED_INFO(fault.beats << " beats of " << to_string(fault.of) << " from cycle " << fault.from_cycle
                              << ", " << joined(run.machine().watchdog_findings()));
    CHECK(faulty(run).injected_faults == probe.beats_lost());
    CHECK(faulty_composer(run).lost_tables == probe.tables_known_to_be_lost());
    for (const ComposerCounters& composer : run.drained_report().composers) {
        const bool is_faulty =
            composer.renderer == static_cast<int>(kFaultyRenderer) + 1 && composer.display == kFaultyDisplay;
        CHECK((is_faulty || composer.lost_pixels + composer.lost_tables == 0));
    }
    // A frame whose table was lost is marked as soon as it is composited. A frame that came whole is never marked.
    const std::set<int> marked = probe.marked();
    const int shown = check_shown(run, marked);
    for (int i = 0; i < shown; ++i) {
        const TableProbe::Frame& frame = probe.frames()[static_cast<std::size_t>(i)];
        INFO("frame " << i);
        CHECK((!frame.table_lost() || frame.marked));
        CHECK((frame.touched() || !frame.marked));
    }
    if (run.machine().watchdog_findings().empty()) {
        CHECK(shown == kFrames);
    } else {
        CHECK(probe.not_known().count(shown) == 1);
        CHECK(any_contains(run.machine().watchdog_findings(), "composer_2_2 waits for "));
        if (probe.frames()[static_cast<std::size_t>(shown)].table_lost()) {
            CHECK(any_contains(run.machine().watchdog_findings(),
                               "composer_2_2 waits for the table of frame " + std::to_string(shown)));
        }
    }
    const std::int64_t kept =
        std::count_if(marked.begin(), marked.end(), [&](int frame) { return frame < shown; });
    for (const DisplayCounters& display : run.report().displays) {
        CHECK(display.frames_shown == shown);
        CHECK(display.kept_frames == kept);
    }
}

/// A pair of the faulty renderer that lies off the wall: its table is empty, a frame start alone.
void take_off_the_wall(Scenario& scenario, std::size_t pair) {
    RendererFrame& frame = scenario.renderers[kFaultyRenderer].frames[pair];
    frame.viewport.reset();
    frame.table.clear();
}

using TableLossRuns = ProbedRuns<TableProbe>;

TableLossCoverage lose_tables(LostBeats of, StarvationMode mode, std::uint64_t seed) {
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    TableLossRuns all;
    const auto add = [&](Machine machine, std::int64_t from_cycle, int beats, std::size_t pair_off_the_wall) {
        machine.mode = mode;
        Fault fault = machine_fault(FaultKind::kLostBeat, from_cycle);
        fault.of = of;
        fault.beats = beats;
        Scenario scenario = three_renderers(machine);
        if (pair_off_the_wall < kFrames) take_off_the_wall(scenario, pair_off_the_wall);
        all.add(with_fault(scenario, fault));
    };
    add({}, 0, 1, 0);                                        // an empty table, whose loss the next one shows
    add({}, 0, of == LostBeats::kTable ? 6 : 300, kFrames);  // a frame and some more
    add({}, random.between(500, 2000), 2000, kFrames - 1);   // all from then on
    constexpr int kTableBeats[] = {1, 1, 1, 2, 2, 3, 4, 7, 12};
    constexpr int kAnyBeats[] = {1, 2, 3, 5, 10, 30, 100, 200, 1000};
    for (int i = 0; i < 21; ++i) {
        Machine machine;
        machine.multiple = i % 3 == 2 ? 2 : 1;
        machine.buffer_pixels = random.one_in(3) ? 32 : random.between(40, 200);
        machine.bus_bits = 64 << random.between(0, 2);
        const int from_cycle = random.between(0, 3000);
        const int beats = (of == LostBeats::kTable ? kTableBeats : kAnyBeats)[random.between(0, 8)];
        add(machine, from_cycle, beats, static_cast<std::size_t>(random.between(0, 2 * kFrames)));
    }
    const TableLossCoverage coverage = all.run<TableLossCoverage>(check_table_losses);
    CHECK(coverage.recovered > 5);
    CHECK(coverage.several > 0);
    CHECK(coverage.start_told_by_start > 0);
    CHECK(coverage.not_known > 0);  // the last frame's, and the watchdog has reported it
    return coverage;
}

void check_tables_lost_everywhere(StarvationMode mode, std::uint64_t seed) {
    const TableLossCoverage coverage = lose_tables(LostBeats::kTable, mode, seed);
    CHECK(coverage.start_told_by_row > 0);
    CHECK(coverage.start_told_by_pixels > 0);
    CHECK(coverage.pixels_too == 0);
}

}  // namespace

TEST_CASE("lost beats of tables in stall mode: their frame is not shown and the next one is right",
          "[system][faults][repeat]") {
    check_tables_lost_everywhere(StarvationMode::kStall, random_seed(4401));
}

TEST_CASE("lost beats of tables in glitch mode: their frame is not shown and the next one is right",
          "[system][faults][repeat]") {
    check_tables_lost_everywhere(StarvationMode::kGlitch, random_seed(4501));
}

TEST_CASE("lost beats of any kind in stall mode: their frame is not shown and the next one is right",
          "[system][faults][repeat]") {
    const TableLossCoverage coverage =
        lose_tables(LostBeats::kAny, StarvationMode::kStall, random_seed(4601));
    CHECK(coverage.pixels_too > 0);
}

TEST_CASE("lost beats of any kind in glitch mode: their frame is not shown and the next one is right",
          "[system][faults][repeat]") {
    const TableLossCoverage coverage =
        lose_tables(LostBeats::kAny, StarvationMode::kGlitch, random_seed(4701));
    CHECK(coverage.pixels_too > 0);
}

TEST_CASE("lost beats of a table: hundreds of frames in a row, and the first whole one after them is right",
          "[system][faults][repeat]") {
    constexpr int kLost = 260;
    constexpr int kRunFrames = kLost + 20;
    Scenario scenario = three_renderers({});
    scenario.clocks = {100.0, 100.0, 100.0};
    scenario.frames = kRunFrames;
    // Empty tables, a beat each, which its composers do not receive. If one of them received one, the bus would wait.
    for (RendererFrame& frame : scenario.renderers[0].frames) {
        frame.viewport.reset();
        frame.table.clear();
    }
    for (int display = 1; display <= kDisplays; ++display) {
        Fault fault = machine_fault(FaultKind::kLostBeat, 0);
        fault.renderer = 0;
        fault.display = display;
        fault.of = LostBeats::kTable;
        fault.beats = kLost;
        scenario.faults.push_back(fault);
    }
    check_scenario(scenario);
    MachineRuns runs;
    runs.push_back(std::make_unique<MachineRun>("machine", std::move(scenario)));
    run_traced(runs);
    const MachineRun& run = *runs.front();
    REQUIRE(run.finished());
    std::set<int> kept;
    for (int frame = 0; frame < kLost; ++frame) kept.insert(frame);
    CHECK(check_shown(run, kept) == kRunFrames);
    CHECK(run.report().total_composer().lost_tables == std::int64_t{kLost} * kDisplays);
    for (const DisplayCounters& display : run.report().displays) CHECK(display.kept_frames == kLost);
}

TEST_CASE("lost beats of a table: each row and all after it until the next frame starts",
          "[system][faults]") {
    // A bus so narrow that a row takes 8 clocks and a beat carries one pixel.
    constexpr int kRowClocks = 8;
    Machine machine;
    machine.bus_bits = 16;
    machine.multiple = 2;
    TableLossRuns all;
    for (const StarvationMode mode : {StarvationMode::kStall, StarvationMode::kGlitch}) {
        machine.mode = mode;
        const Scenario scenario = three_renderers(machine);
        const Renderer& renderer = scenario.renderers[kFaultyRenderer];
        const auto first_pair =
            static_cast<std::int64_t>(static_cast<double>(pair_clocks(renderer)) * scenario.clocks.core_mhz /
                                      scenario.clocks.dvi_in_mhz);
        int pixels = 0;
        for (const ViewportRow& row : renderer.frames[0].table) pixels += row.sdx * row.sdy;
        const int rows = static_cast<int>(renderer.frames[0].table.size());
        // The first table comes after the first pair: each of its beats is the first to be lost in some run.
        for (int at = 0; at < 6; ++at) {
            Fault fault = machine_fault(FaultKind::kLostBeat, first_pair + at * kRowClocks);
            fault.of = LostBeats::kTable;
            all.add(with_fault(scenario, fault));
            fault.of = LostBeats::kAny;
            fault.beats = rows + pixels;
            all.add(with_fault(scenario, fault));
        }
    }
    const TableLossCoverage coverage = all.run<TableLossCoverage>(check_table_losses);
    CHECK(coverage.start_told_by_row > 0);
    CHECK(coverage.rows_told_by_row > 0);
    CHECK(coverage.rows_told_by_pixels > 0);
    CHECK(coverage.rows_told_by_start > 0);
    CHECK(coverage.pixels_too > 0);
    CHECK(coverage.recovered > 50);
}

// ---- a link's clock that drifts ----

TEST_CASE("a link's clock that drifts and comes back: every picture is right", "[system][faults]") {
    MachineRuns runs;
    for (const Pacing pacing : {Pacing::kLockstep, Pacing::kFreeRunning}) {
        for (const int ppm : {-100'000, -5'000, -37, 50, 777, 100'000}) {
            Machine machine;
            machine.pacing = pacing;
            Scenario scenario = three_renderers(machine);
            if (ppm % 2 != 0) scenario.clocks = {100.0, 100.0, 100.0};  // one clock for all but this link
            Fault away = machine_fault(FaultKind::kDrift, 0);
            away.display = 0;
            away.pair = 1;
            away.ppm = ppm;
            Fault back = away;
            back.pair = 3;
            back.ppm = 0;
            scenario.faults = {away, back};
            check_scenario(scenario);
            runs.push_back(std::make_unique<MachineRun>("run_" + std::to_string(runs.size()), scenario));
        }
    }
    run_traced(runs);
    for (const auto& run : runs) {
        INFO("ppm " << run->scenario().faults[0].ppm << ", " << describe(run->scenario()));
        check_run(*run);
        CHECK(run->report().total_starved_pixels() == 0);
        if (run->scenario().pacing == Pacing::kLockstep) {
            CHECK(faulty(*run).injected_faults == 2);
            CHECK(faulty(*run).repeated_frames == 0);
        }
    }
}

// ---- random stalls ----

namespace {

void check_stalled_machines(std::uint64_t first_seed, int count) {
    MachineRuns runs;
    for (int i = 0; i < count; ++i) {
        runs.push_back(std::make_unique<MachineRun>(
            "run_" + std::to_string(i), random_stalled_scenario(first_seed + static_cast<std::uint64_t>(i))));
    }
    run_traced(runs);
    std::int64_t taken_effect = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO("seed " << first_seed + i << ": " << describe(runs[i]->scenario()));
        check_run(*runs[i]);
        for (const ComposerCounters& composer : runs[i]->report().composers) CHECK(composer.lost_pixels == 0);
        for (const RendererCounters& renderer : runs[i]->report().renderers) {
            taken_effect += renderer.injected_faults;
        }
    }
    CHECK(taken_effect >= count);
}

}  // namespace

namespace {

/// Counts the clocks in which a reader samples another value of a handshake than its block drives.
class HandshakeProbe final : public sc_core::sc_module {
  public:
    HandshakeProbe(const sc_core::sc_module_name& name, rtl::Metabuffer& machine)
        : sc_core::sc_module(name), handshakes_(machine.faults().handshakes()), held_(handshakes_.size()) {
        SC_METHOD(clock_edge);
        sensitive << machine.core_clk().posedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(HandshakeProbe);

    /// The wires behind a fault, and those that it has held.
    std::set<std::string> wires() const {
        return named([](int /*clocks*/) { return true; });
    }
    std::set<std::string> held() const {
        return named([](int clocks) { return clocks > 0; });
    }

  private:
    void clock_edge() {
        for (std::size_t i = 0; i < handshakes_.size(); ++i) {
            held_[i] += handshakes_[i].driven.read() != handshakes_[i].seen.read() ? 1 : 0;
        }
    }
    template <typename Condition>
    std::set<std::string> named(Condition condition) const {
        std::set<std::string> names;
        for (std::size_t i = 0; i < handshakes_.size(); ++i) {
            const std::string seen = handshakes_[i].seen.name();
            if (condition(held_[i])) names.insert(seen.substr(seen.rfind('.') + 1));
        }
        return names;
    }

    const std::vector<rtl::MachineFaults::Handshaking>& handshakes_;
    std::vector<int> held_;
};

/// The handshakes of a row (from 1) of the three renderers on two displays.
std::set<std::string> handshakes_of_row(int row, StarvationMode mode) {
    const std::string of_row = "_" + std::to_string(row);
    std::set<std::string> wires{"PAIR_REQUEST" + of_row};
    for (const std::string display : {"_1", "_2"}) {
        for (const char* wire : {"BUSREADY", "TABLEREADY"}) wires.insert(wire + of_row + display);
        if (mode == StarvationMode::kStall) wires.insert("STALL" + of_row + display);
        // The PIPEMASTER is kept from raising its own.
        wires.insert((row == 1 ? "PIPEREADY_2" : "PIPEREADY" + of_row) + display);
        if (row == 3) wires.insert({"PIPEREADY_4" + display, "FRAMEDONE" + display});
    }
    if (row == 3) wires.insert("SWAPLOCK");
    return wires;
}

}  // namespace

TEST_CASE("random stalls hold every handshake of their row, the last one's outputs too, and no other",
          "[system][faults][repeat]") {
    constexpr double kClocks[][3] = {{25, 250, 125}, {100, 100, 100}, {125, 70, 30}};
    MachineRuns runs;
    std::vector<std::unique_ptr<HandshakeProbe>> probes;
    for (const StarvationMode mode : {StarvationMode::kStall, StarvationMode::kGlitch}) {
        for (int i = 0; i < 9; ++i) {
            Machine machine;
            machine.mode = mode;
            Scenario scenario = three_renderers(machine);
            const double* clocks = kClocks[i / 3];
            scenario.clocks = {clocks[0], clocks[1], clocks[2]};
            scenario.watchdog_cycles = 30000;
            const std::string number = std::to_string(runs.size());
            runs.push_back(std::make_unique<MachineRun>(
                "run_" + number, with_fault(scenario, random_stalls(i % 3, 30 + 10 * (i / 3)))));
            probes.push_back(
                std::make_unique<HandshakeProbe>(("probe_" + number).c_str(), runs.back()->machine()));
        }
    }
    run_traced(runs);
    std::map<std::pair<int, StarvationMode>, std::set<std::string>> held;  // by row, from 1
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const MachineRun& run = *runs[i];
        const Fault& fault = run.scenario().faults[0];
        INFO("renderer " << fault.renderer << ", " << fault.percent << " %: " << describe(run.scenario()));
        check_run(run);
        const StarvationMode mode = run.scenario().composer.on_starvation;
        std::set<std::string> expected = handshakes_of_row(fault.renderer + 1, mode);
        if (expected.count("SWAPLOCK") > 0) expected.insert("SWAPSKIP");  // no frame is bad: never high
        CHECK(probes[i]->wires() == expected);
        // In a run of a few frames a rise may happen never to be held.
        const std::set<std::string> now_held = probes[i]->held();
        held[{fault.renderer + 1, mode}].insert(now_held.begin(), now_held.end());
        const auto renderer = static_cast<std::size_t>(fault.renderer);
        for (std::size_t r = 0; r < run.report().renderers.size(); ++r) {
            CHECK(run.report().renderers[r].injected_faults == (r == renderer ? 1 : 0));
        }
    }
    for (const auto& [row_and_mode, wires] : held) {
        CHECK(wires == handshakes_of_row(row_and_mode.first, row_and_mode.second));
    }
}

TEST_CASE(
    "random stalls have a module in each handshake of their row, one in the swap lock's, and in no other",
    "[system][faults]") {
    MachineRuns runs;
    for (const StarvationMode mode : {StarvationMode::kStall, StarvationMode::kGlitch}) {
        for (int row = 1; row <= 3; ++row) {
            INFO("row " << row << (mode == StarvationMode::kStall ? ", stall" : ", glitch"));
            Machine machine;
            machine.mode = mode;
            const std::string number = std::to_string(runs.size());
            runs.push_back(std::make_unique<MachineRun>(
                "run_" + number, with_fault(three_renderers(machine), random_stalls(row - 1, 50))));
            const HandshakeProbe probe(("probe_" + number).c_str(), runs.back()->machine());
            std::set<std::string> expected = handshakes_of_row(row, mode);
            CHECK(runs.back()->machine().matching_blocks({"*_fault*"}) == static_cast<int>(expected.size()));
            CHECK(runs.back()->machine().matching_blocks({"swap_lock_fault"}) == (row == 3 ? 1 : 0));
            if (row == 3) expected.insert("SWAPSKIP");
            CHECK(probe.wires() == expected);
        }
    }
}

TEST_CASE("a machine whose faults are on its links has no module that holds a handshake",
          "[system][faults]") {
    Scenario scenario = three_renderers({});
    Fault fault;
    fault.kind = FaultKind::kCrc;
    scenario.faults.push_back(fault);
    MachineRun run("run", scenario);
    CHECK(run.machine().faults().handshakes().empty());
    CHECK(run.machine().matching_blocks({"*_fault*"}) == 0);
}

TEST_CASE("a link has a clock module of its own if a fault lets its clock drift, and for no other fault",
          "[system][faults]") {
    Fault drift;
    drift.kind = FaultKind::kDrift;
    drift.renderer = 1;
    drift.ppm = 1'000;
    const Scenario scenario = with_fault(with_fault(three_renderers({}), random_stalls(0, 50)), drift);
    MachineRun run("run", scenario);
    CHECK(run.machine().matching_blocks({"link_clock_*"}) == 1);
    CHECK(run.machine().matching_blocks({"link_clock_2"}) == 1);
}

TEST_CASE("a column that random stalls hold nearly for ever: the watchdog names the wires",
          "[system][faults]") {
    // In the middle of a frame, so that the columns move.
    Scenario scenario = three_renderers({});
    for (int r = 0; r < 3; ++r) scenario = with_fault(scenario, random_stalls(r, 99, 1900));
    MachineRuns runs;
    runs.push_back(std::make_unique<MachineRun>("run", scenario));
    run_traced(runs);
    const std::vector<std::string>& findings = runs[0]->machine().watchdog_findings();
    INFO(joined(findings));
    CHECK(any_contains(findings, " waits for its column to move on"));
    CHECK(std::any_of(findings.begin(), findings.end(), [](const std::string& line) {
        return line.substr(0, 12) == "stall_fault_" && line.find(" holds STALL_") != std::string::npos &&
               line.substr(line.size() - 5) == " high";
    }));
    const int shown = check_shown(*runs[0], {});
    CHECK(shown >= 1);
    CHECK(shown < kFrames);
}

TEST_CASE("random stalls on every handshake of a row: nothing is lost or late (seeds 5001 on)",
          "[system][faults]") {
    check_stalled_machines(random_seed(5001), 10);
}

TEST_CASE("random stalls on every handshake of a row: nothing is lost or late (seeds 6001 on)",
          "[system][slow]") {
    check_stalled_machines(6001, 10);
}

TEST_CASE("random stalls on every handshake of a row: nothing is lost or late (seeds 6101 on)",
          "[system][slow]") {
    check_stalled_machines(6101, 10);
}

Fault reset_at(std::int64_t cycle, std::int64_t cycles) {
    Fault fault;
    fault.kind = FaultKind::kReset;
    fault.from_cycle = cycle;
    fault.cycles = cycles;
    return fault;
}

/// With clocks of one period a run after a reset is the run from power-up, so many clocks later.
TEST_CASE("a reset at any moment: the run begins again and goes as it does from power-up",
          "[system][faults]") {
    constexpr std::int64_t kPowerUpCycles = 2;
    const auto with_reset = [](std::int64_t cycle, std::int64_t cycles) {
        Scenario scenario = three_renderers({});
        scenario.clocks = {100.0, 100.0, 100.0};
        if (cycles > 0) scenario.faults.push_back(reset_at(cycle, cycles));
        check_scenario(scenario);
        return scenario;
    };
    const std::vector<std::pair<std::int64_t, std::int64_t>> resets{
        {2, 0}, {1, 9}, {300, 2}, {1111, 3}, {2600, 5}, {4700, 2}, {9001, 2}, {14000, 4}};
    MachineRuns runs;
    for (const auto& [cycle, cycles] : resets) {
        runs.push_back(
            std::make_unique<MachineRun>("machine_" + std::to_string(cycle), with_reset(cycle, cycles)));
    }
    run_traced(runs);
    const RunReport& undisturbed = runs.front()->report();
    REQUIRE(undisturbed.core_cycles > 14'000);
    for (std::size_t i = 0; i < resets.size(); ++i) {
        const RunReport& report = runs[i]->report();
        const std::int64_t later = resets[i].first + resets[i].second - kPowerUpCycles;
        INFO("reset at core clock " << resets[i].first);
        CHECK(report.core_cycles == undisturbed.core_cycles + later);
        CHECK(check_shown(*runs[i], {}) == kFrames);
        REQUIRE(report.frames.size() == undisturbed.frames.size());
        for (std::size_t f = 0; f < report.frames.size(); ++f) {
            CHECK(report.frames[f].pairs == undisturbed.frames[f].pairs);
            CHECK(report.frames[f].start_cycle == undisturbed.frames[f].start_cycle + later);
        }
        for (std::size_t r = 0; r < report.renderers.size(); ++r) {
            CHECK(report.renderers[r].injected_faults == (i == 0 ? 0 : 1));
            // What was sent before the reset stays counted.
            CHECK(report.renderers[r].bus.pixels_sent >= undisturbed.renderers[r].bus.pixels_sent);
        }
    }
    CHECK(runs.back()->report().renderers[0].bus.pixels_sent > undisturbed.renderers[0].bus.pixels_sent);
}

TEST_CASE("after a reset the starved pixels of a frame are its own, and composers go on counting",
          "[system][faults]") {
    const auto starving = [](std::int64_t reset_cycle) {
        Scenario scenario = three_renderers({});
        scenario.clocks = {100.0, 100.0, 100.0};
        scenario.bus.width_bits = 16;
        scenario.composer.buffer_pixels = 24;
        scenario.composer.on_starvation = StarvationMode::kGlitch;
        if (reset_cycle > 0) scenario.faults.push_back(reset_at(reset_cycle, 2));
        check_scenario(scenario);
        return scenario;
    };
    MachineRuns runs;
    runs.push_back(std::make_unique<MachineRun>("undisturbed", starving(0)));
    runs.push_back(std::make_unique<MachineRun>("reset", starving(14'000)));
    run_traced(runs);
    const RunReport& undisturbed = runs[0]->report();
    const RunReport& again = runs[1]->report();
    REQUIRE(undisturbed.frames.front().end_cycle < 14'000);
    CHECK(undisturbed.total_rejected_rows() == 0);
    REQUIRE(undisturbed.total_starved_pixels() > 0);
    REQUIRE(again.frames.size() == undisturbed.frames.size());
    for (std::size_t f = 0; f < again.frames.size(); ++f) {
        CHECK(again.frames[f].starved_pixels == undisturbed.frames[f].starved_pixels);
    }
    CHECK(again.total_starved_pixels() > undisturbed.total_starved_pixels());
}

TEST_CASE("resets that overlap are one, and several are each counted", "[system][faults]") {
    MachineRuns runs;
    for (const auto& resets : std::vector<std::vector<Fault>>{{reset_at(600, 30)},
                                                              {reset_at(600, 20), reset_at(610, 20)},
                                                              {reset_at(100, 20), reset_at(600, 30)}}) {
        Scenario scenario = three_renderers({});
        scenario.clocks = {100.0, 100.0, 100.0};
        scenario.faults = resets;
        check_scenario(scenario);
        runs.push_back(std::make_unique<MachineRun>("machine_" + std::to_string(runs.size()), scenario));
    }
    run_traced(runs);
    for (const auto& run : runs) {
        CHECK(check_shown(*run, {}) == kFrames);
        CHECK(run->report().core_cycles == runs.front()->report().core_cycles);
    }
    CHECK(runs[0]->report().renderers[0].injected_faults == 1);
    CHECK(runs[1]->report().renderers[0].injected_faults == 2);
    CHECK(runs[2]->report().renderers[0].injected_faults == 2);
}

TEST_CASE("machine: timing: a reset begins and ends half a core clock before the edge that reads it",
          "[system][faults]") {
    constexpr std::int64_t kPeriodPicoseconds = 40'000;
    Scenario scenario = three_renderers({});
    scenario.clocks.core_mhz = 1e6 / kPeriodPicoseconds;
    scenario.faults = {reset_at(30, 7)};
    check_scenario(scenario);
    MachineRun run("machine", scenario);
    const auto in_reset_at = [&run](std::int64_t picoseconds) {
        sc_core::sc_start(rtl::picoseconds(picoseconds) - sc_core::sc_time_stamp());
        return run.machine().reset().read();
    };
    bool in_reset = true;  // from power-up on
    for (const std::int64_t cycle : {2, 30, 37}) {
        INFO("core clock " << cycle);
        const std::int64_t change = cycle * kPeriodPicoseconds - kPeriodPicoseconds / 2;
        CHECK(in_reset_at(change - 1) == in_reset);
        in_reset = !in_reset;
        CHECK(in_reset_at(change + 1) == in_reset);
    }
}

TEST_CASE("random stalls: clock gating changes neither clocks nor counters", "[system][faults][repeat]") {
    constexpr std::uint64_t kFirstSeed = 7001;
    constexpr int kMachines = 5;
    MachineRuns runs;
    for (int i = 0; i < kMachines; ++i) {
        Scenario scenario = random_stalled_scenario(kFirstSeed + static_cast<std::uint64_t>(i));
        if (i == kMachines - 1) {
            // Composers that sleep while their column stands still for another's STALL.
            scenario = three_renderers({});
            for (int r = 0; r < 3; ++r) scenario = with_fault(scenario, random_stalls(r, 20 + 10 * r));
        }
        const std::string number = std::to_string(i);
        runs.push_back(std::make_unique<MachineRun>("gated_" + number, scenario, rtl::ClockGating::kOn));
        runs.push_back(std::make_unique<MachineRun>("ungated_" + number, scenario, rtl::ClockGating::kOff));
    }
    run_traced(runs);
    for (std::size_t i = 0; i < runs.size(); i += 2) {
        INFO("seed " << kFirstSeed + i / 2 << ": " << describe(runs[i]->scenario()));
        CHECK(report_json(runs[i]->report()) == report_json(runs[i + 1]->report()));
    }
}

}  // namespace metabuffer::test::machine_faults_test
