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

/// All clocks have one period.
Scenario one_clock(const std::vector<Fault>& faults) {
    Scenario scenario = three_renderers({});
    scenario.clocks = {100.0, 100.0, 100.0};
    scenario.faults = faults;
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

MachineRuns run_all(const std::vector<Scenario>& scenarios) {
    MachineRuns runs;
    for (const Scenario& scenario : scenarios) {
        runs.push_back(std::make_unique<MachineRun>("run_" + std::to_string(runs.size()), scenario));
    }
    run_traced(runs);
    return runs;
}

/// Machines, each with a probe on its wires.
template <typename Probe>
struct ProbedRuns {
    MachineRuns runs;
    std::vector<std::unique_ptr<Probe>> probes;

    void add(const Scenario& scenario) {
        const std::string number = std::to_string(runs.size());
        runs.push_back(std::make_unique<MachineRun>("run_" + number, scenario));
        probes.push_back(std::make_unique<Probe>(("probe_" + number).c_str(), *runs.back()));
    }
};

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

TEST_CASE("a wire that never rises: the watchdog names it and nothing half done is shown",
          "[system][faults]") {
    struct Row {
        FaultKind kind;
        int renderer;
        StarvationMode mode;
        std::vector<std::string> findings;
    };
    const std::vector<std::string> without_busready{
        "composer_2_2 waits for its buffer to be prefetched with frame 0",
        "input_framebuffer_2 waits for BUSREADY of the composers of display 2",
        "busready_fault_2_2 holds BUSREADY_2_2 low"};
    const std::string first_waits = "composer_1_2 waits for PIPEREADY from below for frame 0";
    const std::vector<Row> rows{
        {FaultKind::kBusreadyLow, 1, StarvationMode::kStall, without_busready},
        {FaultKind::kBusreadyLow, 1, StarvationMode::kGlitch, without_busready},
        // The PIPEMASTER has no wire for its own PIPEREADY: the fault keeps it from raising it.
        {FaultKind::kPipereadyLow,
         0,
         StarvationMode::kStall,
         {first_waits, "pipeready_fault_2_2 holds PIPEREADY_2_2 low"}},
        {FaultKind::kPipereadyLow,
         1,
         StarvationMode::kStall,
         {first_waits, "composer_2_2 waits for STARTFRAME of frame 0",
          "pipeready_fault_2_2 holds PIPEREADY_2_2 low"}},
        {FaultKind::kPipereadyLow,
         2,
         StarvationMode::kStall,
         {"composer_2_2 waits for PIPEREADY from below for frame 0",
          "composer_3_2 waits for STARTFRAME of frame 0", "pipeready_fault_3_2 holds PIPEREADY_3_2 low"}}};
    std::vector<Scenario> scenarios;
    for (const Row& row : rows) {
        Machine machine;
        machine.mode = row.mode;
        Fault fault = machine_fault(row.kind, 0);
        fault.renderer = row.renderer;
        scenarios.push_back(with_fault(three_renderers(machine), fault));
    }
    const MachineRuns runs = run_all(scenarios);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const MachineRun& run = *runs[i];
        INFO(joined(run.machine().watchdog_findings()));
        for (const std::string& line : rows[i].findings) {
            INFO(line);
            CHECK(any_contains(run.machine().watchdog_findings(), line));
        }
        CHECK(check_shown(run, {}) == 0);
        CHECK(run.picture(0, 1) == nullptr);  // display 1 could, but they swap together
        CHECK(run.report().renderers[static_cast<std::size_t>(rows[i].renderer)].injected_faults == 1);
        if (rows[i].kind == FaultKind::kBusreadyLow) CHECK(faulty_composer(run).buffer_high_water == 0);
    }
}

TEST_CASE("a wire that goes low for ever in the middle of a run: the last good frame stays",
          "[system][faults]") {
    std::vector<Scenario> scenarios;
    for (const FaultKind kind : {FaultKind::kBusreadyLow, FaultKind::kPipereadyLow}) {
        for (const std::int64_t from : {1500, 1801, 2102, 2403, 2704}) {
            scenarios.push_back(with_fault(three_renderers({}), machine_fault(kind, from)));
        }
    }
    std::set<int> frames_shown;
    for (const auto& run : run_all(scenarios)) {
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
    std::vector<Scenario> scenarios;
    for (int i = 0; i < 30; ++i) {
        Machine machine;
        machine.multiple = i % 3 == 0 ? 2 : 1;
        machine.bus_bits = 16 << random.between(0, 4);
        machine.mode = i % 4 == 0 ? StarvationMode::kGlitch : StarvationMode::kStall;
        Fault fault = machine_fault(i % 2 == 0 ? FaultKind::kBusreadyLow : FaultKind::kPipereadyLow,
                                    random.between(0, 1400));
        fault.cycles = random.one_in(3) ? random.between(1, 3) : random.between(1, 300);
        fault.renderer = random.between(0, 2);
        scenarios.push_back(with_fault(three_renderers(machine), fault));
    }
    for (const auto& run : run_all(scenarios)) {
        const Fault& fault = run->scenario().faults[0];
        INFO(to_string(fault.kind) << " of renderer " << fault.renderer << " from cycle " << fault.from_cycle
                                   << " for " << *fault.cycles << ": " << describe(run->scenario()));
        check_run(*run);
        for (const ComposerCounters& composer : run->report().composers) CHECK(composer.lost_pixels == 0);
    }
}

// ---- lost beats ----

namespace {

using Kind = rtl::BusBeat::Kind;

/// A beat for the faulty composer that was lost, and where in the run, seen at the machine's wires.
struct LostBeat {
    rtl::BusBeat beat;
    int frame = 0;
    bool first_of_burst = false;
    bool last_of_segment = false;
    bool while_compositing = false;  ///< this very frame
    std::int64_t known_cycle = -1;   ///< the edge at which the composer can know; -1: never
    Kind shown_by = Kind::kNone;     ///< the beat that came then

    bool known() const { return known_cycle >= 0; }
};

/// What of a frame was lost.
struct FrameLosses {
    bool start = false, rows = false, pixels = false;
    LostBeat last;

    bool table() const { return start || rows; }
    bool any() const { return table() || pixels; }
    bool known() const { return last.known(); }
};

/// Follows the bus of the faulty renderer, before and behind the fault, and the faulty composer's pixels.
class LossProbe final : public sc_core::sc_module {
  public:
    LossProbe(const sc_core::sc_module_name& name, MachineRun& run)
        : sc_core::sc_module(name),
          raster_pixels_(std::int64_t{run.scenario().displays.raster_width_pixels()} *
                         run.scenario().displays.raster_height_pixels()),
          sent_(run.machine().wires().bus[kFaultyRenderer]),
          seen_(run.machine().wires().bus_seen_by(kFaultyRenderer * kDisplays + kFaultyDisplay - 1)),
          pipe_(run.machine().wires().pipe[(kFaultyRenderer + 1) * kDisplays + kFaultyDisplay - 1]),
          column_stall_(run.machine().wires().column_stall[kFaultyDisplay - 1]) {
        SC_METHOD(clock_edge);
        sensitive << run.machine().core_clk().posedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(LossProbe);

    const std::vector<LostBeat>& losses() const { return losses_; }
    /// Those for the other composer, too.
    std::int64_t beats_lost() const { return beats_lost_; }
    FrameLosses of(int frame) const {
        FrameLosses of_frame;
        for (const LostBeat& loss : losses_) {
            if (loss.frame != frame) continue;
            bool& lost = loss.beat.kind == Kind::kFrameStart ? of_frame.start
                         : loss.beat.kind == Kind::kTableRow ? of_frame.rows
                                                             : of_frame.pixels;
            lost = true;
            of_frame.last = loss;
        }
        return of_frame;
    }
    /// The frames whose pixels have left the composer marked as lost.
    const std::set<int>& marked() const { return marked_; }
    /// The frames that can be replaced by the picture before, since the composer knew before its last raster pixel.
    std::set<int> known_in_time() const {
        std::set<int> frames;
        for (const LostBeat& loss : losses_) {
            const auto frame = static_cast<std::size_t>(loss.frame);
            const bool ended = frame < frame_ends_.size();
            if (loss.known() && (!ended || loss.known_cycle < frame_ends_[frame])) frames.insert(loss.frame);
        }
        return frames;
    }
    std::set<int> not_known_in_time() const {
        const std::set<int> in_time = known_in_time();
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
            if (pipe_.read().lost) marked_.insert(static_cast<int>(piped_ / raster_pixels_));
            // Composited at the edge before this one.
            if (++piped_ % raster_pixels_ == 0) frame_ends_.push_back(cycle_ - 1);
        }
        const rtl::BusBeat& sent = sent_.read();
        if (sent.kind == Kind::kNone) return;
        if (sent.kind == Kind::kFrameStart) {
            // Nothing came after the segment's last pixels.
            if (last_pixels_lost_ && losses_.back().frame == frame_) losses_.back().last_of_segment = true;
            ++frame_;
            table_lost_ = false;
        }
        const bool for_all = sent.kind != Kind::kPixels;
        const bool mine = sent.kind == Kind::kPixels && sent.destination == std::uint16_t{kFaultyDisplay};
        const bool arrives = seen_.read().kind == sent.kind;
        const bool first = left_ == 0;
        if (mine) {
            left_ = sent.remaining;
            last_pixels_lost_ = !arrives;
        }
        if (arrives) {
            arrive(sent, mine);
            return;
        }
        ++beats_lost_;
        if (!for_all && !mine) return;
        LostBeat& loss = losses_.emplace_back();
        loss.beat = sent;
        loss.frame = frame_;
        loss.first_of_burst = first;
        table_lost_ = table_lost_ || for_all;
        loss.while_compositing = piped_ / raster_pixels_ == frame_ && piped_ % raster_pixels_ != 0;
    }
    void arrive(const rtl::BusBeat& beat, bool mine) {
        for (LostBeat& loss : losses_) {
            // Pixels for another display show that a table was lost, but not that pixels were.
            if (loss.known() || (loss.frame == frame_ && !mine && !table_lost_)) continue;
            loss.known_cycle = cycle_;
            loss.shown_by = beat.kind;
        }
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
    std::set<int> marked_;
    int frame_ = -1;          ///< whose beats the bus carries
    std::uint32_t left_ = 0;  ///< of the burst, by the last beat
    bool last_pixels_lost_ = false;
    bool table_lost_ = false;  ///< of this frame, or a part of it
    std::int64_t beats_lost_ = 0;
    std::vector<LostBeat> losses_;
};

/// What a set of runs has met, and how often.
using Happened = std::map<std::string, int>;

void count(const LossProbe& probe, Happened& happened) {
    for (const LostBeat& loss : probe.losses()) {
        if (loss.beat.kind != Kind::kPixels) continue;
        const bool last = loss.beat.remaining == 0;
        ++happened[loss.first_of_burst ? (last ? "the beat of a burst" : "a burst's first beat")
                                       : (last ? "a burst's last beat" : "a beat within a burst")];
        ++happened[loss.while_compositing ? "pixels of the frame composited" : "pixels prefetched"];
        happened["a segment's last pixels"] += loss.last_of_segment ? 1 : 0;
        happened["pixels, and nothing shows it"] += loss.known() ? 0 : 1;
    }
    happened["several beats"] += probe.losses().size() > 1 ? 1 : 0;
    happened["a whole burst"] += probe.losses().size() >= 8 ? 1 : 0;
    happened["a frame, known in time"] += static_cast<int>(probe.known_in_time().size());
    happened["a frame, not known in time"] += static_cast<int>(probe.not_known_in_time().size());
    int tables = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
        const FrameLosses lost = probe.of(frame);
        happened["nothing after a table"] += tables > 0 && !lost.any() && probe.marked().count(frame) == 0;
        if (!lost.table()) continue;
        if (!lost.known()) {
            ++happened["a table, and nothing shows it"];
            continue;
        }
        ++tables;
        happened["a table and pixels"] += lost.pixels ? 1 : 0;
        const Kind shown_by = lost.last.shown_by;
        ++happened[std::string(lost.start ? "a start" : "rows") + ", shown by a " +
                   (shown_by == Kind::kTableRow ? "row"
                    : shown_by == Kind::kPixels ? "beat"
                                                : "start")];
    }
    happened["several tables"] += tables > 1 ? 1 : 0;
}

void check_happened(const Happened& happened, const std::map<std::string, int>& least) {
    for (const auto& [what, times] : least) {
        INFO("lost: " << what);
        CHECK((happened.count(what) > 0 && happened.at(what) >= times));
    }
}

/// All checks of a run in which beats were lost.
void check_losses(const MachineRun& run, const LossProbe& probe) {
    const Fault& fault = run.scenario().faults[0];
    const std::vector<std::string>& findings = run.machine().watchdog_findings();
    const bool stall = run.scenario().composer.on_starvation == StarvationMode::kStall;
    std::int64_t known_pixels = 0;
    bool all_known = true;
    for (const LostBeat& loss : probe.losses()) {
        UNSCOPED_INFO("lost " << loss.beat << " of frame " << loss.frame << ", known at "
                              << loss.known_cycle);
        if (loss.known() && loss.beat.kind == Kind::kPixels) known_pixels += loss.beat.count;
        all_known = all_known && loss.known();
    }
    UNSCOPED_INFO(fault.beats << " beats of " << to_string(fault.of) << " from cycle " << fault.from_cycle
                              << ", " << joined(findings));
    CHECK(faulty(run).injected_faults == probe.beats_lost());
    std::int64_t tables = 0;
    std::int64_t known_tables = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
        const FrameLosses lost = probe.of(frame);
        tables += lost.table() ? 1 : 0;
        known_tables += lost.table() && lost.known() ? 1 : 0;
    }
    CHECK(faulty_composer(run).lost_tables == known_tables);
    if (tables == 0) CHECK(faulty_composer(run).lost_pixels == known_pixels);
    for (const ComposerCounters& composer : run.drained_report().composers) {
        if (composer.renderer == static_cast<int>(kFaultyRenderer) + 1 && composer.display == kFaultyDisplay)
            continue;
        CHECK(composer.lost_pixels + composer.lost_tables == 0);
        CHECK((!stall || composer.starved_pixels == 0));
    }
    // The frames that are marked are those of which the composer knew in time; all of a frame whose table was lost.
    const int shown = check_shown(run, probe.known_in_time());
    std::int64_t kept = 0;
    for (int frame = 0; frame < shown; ++frame) {
        INFO("frame " << frame);
        const bool marked = probe.marked().count(frame) > 0;
        CHECK(marked == (probe.known_in_time().count(frame) > 0));
        CHECK((!probe.of(frame).table() || marked));
        kept += marked ? 1 : 0;
    }
    if (findings.empty()) {
        CHECK(shown == kFrames);
    } else {
        // Nothing comes after what was lost that could show it; of lost pixels, after the last frame's last.
        REQUIRE(shown < kFrames);
        const FrameLosses lost = probe.of(shown);
        CHECK((lost.any() && !lost.known()));
        CHECK((tables > 0 || fault.of != LostBeats::kPixels || shown == kFrames - 1));
        CHECK(any_contains(findings,
                           lost.table() ? "composer_2_2 waits for the table of frame " + std::to_string(shown)
                                        : std::string("composer_2_2 waits for ")));
    }
    for (const DisplayCounters& display : run.report().displays) {
        CHECK(display.frames_shown == shown);
        CHECK(display.kept_frames == kept);
    }
    // No frame that was composited without its pixels is shown, unless nobody could know.
    if (stall && tables == 0) {
        CHECK(run.report().total_starved_pixels() == 0);
        CHECK((probe.not_known_in_time().empty() || !all_known));
    }
}

/// Runs the machines and checks each. Returns what they have met.
Happened run_and_check(ProbedRuns<LossProbe>& all) {
    run_traced(all.runs);
    Happened happened;
    for (std::size_t i = 0; i < all.runs.size(); ++i) {
        INFO("run " << i << ": " << describe(all.runs[i]->scenario()));
        check_losses(*all.runs[i], *all.probes[i]);
        count(*all.probes[i], happened);
    }
    return happened;
}

Machine random_machine(Random& random, StarvationMode mode, bool magnified) {
    Machine machine;
    machine.mode = mode;
    machine.multiple = magnified ? 2 : 1;
    machine.buffer_pixels = random.one_in(3) ? 32 : random.between(40, 200);
    machine.bus_bits = 64 << random.between(0, 2);
    return machine;
}

constexpr StarvationMode kModes[] = {StarvationMode::kStall, StarvationMode::kGlitch};

/// Pixels here and there. stalled: while the swap is held back.
Happened lose_pixels(StarvationMode mode, std::uint64_t seed, bool stalled) {
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ProbedRuns<LossProbe> all;
    constexpr int kBeats[] = {1, 1, 1, 1, 2, 3, 8, 30, 400};
    for (int i = 0; i < (stalled ? 20 : 36); ++i) {
        const Machine machine = random_machine(random, mode, i % 3 == 2);
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
    const Happened happened = run_and_check(all);
    for (const char* what : {"a burst's first beat", "a beat within a burst", "a burst's last beat",
                             "a segment's last pixels", "pixels prefetched", "pixels of the frame composited",
                             "several beats", "a whole burst", "a frame, known in time"}) {
        check_happened(happened, {{what, 1}});
    }
    return happened;
}

}  // namespace

TEST_CASE("lost beats of pixels in stall mode: their frame is not shown and the next good one is",
          "[system][faults][repeat]") {
    const Happened happened = lose_pixels(StarvationMode::kStall, random_seed(4201), false);
    check_happened(happened, {{"pixels, and nothing shows it", 1}});  // and the watchdog has reported it
}

TEST_CASE("lost beats of pixels in glitch mode: their frame is not shown and the next good one is",
          "[system][faults][repeat]") {
    const Happened happened = lose_pixels(StarvationMode::kGlitch, random_seed(4301), false);
    check_happened(happened, {{"a frame, not known in time", 1}});  // shown, and its starved pixels counted
}

TEST_CASE("lost beats in stall mode while the swap is held back: a bad frame is kept off every display",
          "[system][faults][repeat]") {
    lose_pixels(StarvationMode::kStall, random_seed(4401), true);
}

TEST_CASE("lost beats in glitch mode while the swap is held back: a bad frame is kept off every display",
          "[system][faults][repeat]") {
    lose_pixels(StarvationMode::kGlitch, random_seed(4501), true);
}

// ---- lost tables ----

namespace {

/// A pair that lies off the wall: its table is empty, a frame start alone.
void take_off_the_wall(RendererFrame& frame) {
    frame.viewport.reset();
    frame.table.clear();
}

/// Beats of tables, or any beats.
void lose_tables(LostBeats of, StarvationMode mode, std::uint64_t seed) {
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ProbedRuns<LossProbe> all;
    const auto add = [&](Machine machine, std::int64_t from_cycle, int beats, int pair_off_the_wall) {
        machine.mode = mode;
        Fault fault = machine_fault(FaultKind::kLostBeat, from_cycle);
        fault.of = of;
        fault.beats = beats;
        Scenario scenario = three_renderers(machine);
        std::vector<RendererFrame>& frames = scenario.renderers[kFaultyRenderer].frames;
        if (pair_off_the_wall < kFrames)
            take_off_the_wall(frames[static_cast<std::size_t>(pair_off_the_wall)]);
        all.add(with_fault(scenario, fault));
    };
    const bool tables = of == LostBeats::kTable;
    add({}, 0, 1, 0);                                       // an empty table, whose loss the next one shows
    add({}, 0, tables ? 6 : 300, kFrames);                  // a frame and some more
    add({}, random.between(500, 2000), 2000, kFrames - 1);  // all from then on
    constexpr int kTableBeats[] = {1, 1, 1, 2, 2, 3, 4, 7, 12};
    constexpr int kAnyBeats[] = {1, 2, 3, 5, 10, 30, 100, 200, 1000};
    for (int i = 0; i < 21; ++i) {
        const Machine machine = random_machine(random, mode, i % 3 == 2);
        const int from_cycle = random.between(0, 3000);
        const int beats = (tables ? kTableBeats : kAnyBeats)[random.between(0, 8)];
        add(machine, from_cycle, beats, random.between(0, 2 * kFrames));
    }
    Happened happened = run_and_check(all);
    check_happened(happened, {{"nothing after a table", 6},
                              {"several tables", 1},
                              {"a start, shown by a start", 1},
                              {"a table, and nothing shows it", 1}});  // and the watchdog has reported it
    if (tables) {
        check_happened(happened, {{"a start, shown by a row", 1}, {"a start, shown by a beat", 1}});
        CHECK(happened["a table and pixels"] == 0);
    } else {
        check_happened(happened, {{"a table and pixels", 1}});
    }
}

}  // namespace

TEST_CASE("lost beats of tables in stall mode: their frame is not shown and the next one is right",
          "[system][faults][repeat]") {
    lose_tables(LostBeats::kTable, StarvationMode::kStall, random_seed(4401));
}

TEST_CASE("lost beats of tables in glitch mode: their frame is not shown and the next one is right",
          "[system][faults][repeat]") {
    lose_tables(LostBeats::kTable, StarvationMode::kGlitch, random_seed(4501));
}

TEST_CASE("lost beats of any kind in stall mode: their frame is not shown and the next one is right",
          "[system][faults][repeat]") {
    lose_tables(LostBeats::kAny, StarvationMode::kStall, random_seed(4601));
}

TEST_CASE("lost beats of any kind in glitch mode: their frame is not shown and the next one is right",
          "[system][faults][repeat]") {
    lose_tables(LostBeats::kAny, StarvationMode::kGlitch, random_seed(4701));
}

TEST_CASE("lost beats of a table: hundreds of frames in a row, and the first whole one after them is right",
          "[system][faults][repeat]") {
    constexpr int kLost = 260;
    constexpr int kRunFrames = kLost + 20;
    Scenario scenario = one_clock({});
    scenario.frames = kRunFrames;
    // Empty tables, a beat each, which its composers do not receive. If one of them received one, the bus would wait.
    for (RendererFrame& frame : scenario.renderers[0].frames) take_off_the_wall(frame);
    for (int display = 1; display <= kDisplays; ++display) {
        Fault fault = machine_fault(FaultKind::kLostBeat, 0);
        fault.renderer = 0;
        fault.display = display;
        fault.of = LostBeats::kTable;
        fault.beats = kLost;
        scenario.faults.push_back(fault);
    }
    check_scenario(scenario);
    const MachineRuns runs = run_all({scenario});
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
    ProbedRuns<LossProbe> all;
    for (const StarvationMode mode : kModes) {
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
    check_happened(run_and_check(all), {{"a start, shown by a row", 1},
                                        {"rows, shown by a row", 1},
                                        {"rows, shown by a beat", 1},
                                        {"rows, shown by a start", 1},
                                        {"a table and pixels", 1},
                                        {"nothing after a table", 51}});
}

// ---- a link's clock that drifts ----

TEST_CASE("a link's clock that drifts and comes back: every picture is right", "[system][faults]") {
    std::vector<Scenario> scenarios;
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
            scenarios.push_back(scenario);
        }
    }
    for (const auto& run : run_all(scenarios)) {
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

/// Ten from this seed on.
void check_stalled_machines(std::uint64_t first_seed) {
    constexpr std::uint64_t kMachines = 10;
    std::vector<Scenario> scenarios;
    for (std::uint64_t i = 0; i < kMachines; ++i)
        scenarios.push_back(random_stalled_scenario(first_seed + i));
    const MachineRuns runs = run_all(scenarios);
    std::int64_t taken_effect = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO("seed " << first_seed + i << ": " << describe(runs[i]->scenario()));
        check_run(*runs[i]);
        for (const ComposerCounters& composer : runs[i]->report().composers) CHECK(composer.lost_pixels == 0);
        for (const RendererCounters& renderer : runs[i]->report().renderers) {
            taken_effect += renderer.injected_faults;
        }
    }
    CHECK(taken_effect >= static_cast<std::int64_t>(kMachines));
}

/// Counts the clocks in which a reader samples another value of a handshake than its block drives.
class HandshakeProbe final : public sc_core::sc_module {
  public:
    HandshakeProbe(const sc_core::sc_module_name& name, MachineRun& run)
        : sc_core::sc_module(name),
          handshakes_(run.machine().faults().handshakes()),
          held_(handshakes_.size()) {
        SC_METHOD(clock_edge);
        sensitive << run.machine().core_clk().posedge_event();
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

TEST_CASE(
    "random stalls hold every handshake of their row, by a module each, the last one's outputs too, and no "
    "other",
    "[system][faults][repeat]") {
    constexpr double kClocks[][3] = {{25, 250, 125}, {100, 100, 100}, {125, 70, 30}};
    ProbedRuns<HandshakeProbe> all;
    for (const StarvationMode mode : kModes) {
        for (int i = 0; i < 9; ++i) {
            Machine machine;
            machine.mode = mode;
            Scenario scenario = three_renderers(machine);
            const double* clocks = kClocks[i / 3];
            scenario.clocks = {clocks[0], clocks[1], clocks[2]};
            scenario.watchdog_cycles = 30000;
            all.add(with_fault(scenario, random_stalls(i % 3, 30 + 10 * (i / 3))));
        }
    }
    run_traced(all.runs);
    std::map<std::pair<int, StarvationMode>, std::set<std::string>> held;  // by row, from 1
    for (std::size_t i = 0; i < all.runs.size(); ++i) {
        const MachineRun& run = *all.runs[i];
        const Fault& fault = run.scenario().faults[0];
        INFO("renderer " << fault.renderer << ", " << fault.percent << " %: " << describe(run.scenario()));
        check_run(run);
        const StarvationMode mode = run.scenario().composer.on_starvation;
        std::set<std::string> expected = handshakes_of_row(fault.renderer + 1, mode);
        const bool holds_swap_lock = expected.count("SWAPLOCK") > 0;
        CHECK(run.machine().matching_blocks({"*_fault*"}) == static_cast<int>(expected.size()));
        CHECK(run.machine().matching_blocks({"swap_lock_fault"}) == (holds_swap_lock ? 1 : 0));
        if (holds_swap_lock) expected.insert("SWAPSKIP");  // no frame is bad: never high
        CHECK(all.probes[i]->wires() == expected);
        // In a run of a few frames a rise may happen never to be held.
        const std::set<std::string> now_held = all.probes[i]->held();
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

TEST_CASE("a fault of a link makes no module that holds a handshake, and drift alone a clock of the link",
          "[system][faults]") {
    Fault crc;
    crc.kind = FaultKind::kCrc;
    MachineRun without("without", with_fault(three_renderers({}), crc));
    CHECK(without.machine().faults().handshakes().empty());
    CHECK(without.machine().matching_blocks({"*_fault*", "link_clock_*"}) == 0);
    Fault drift;
    drift.kind = FaultKind::kDrift;
    drift.renderer = 1;
    drift.ppm = 1'000;
    const Scenario scenario = with_fault(with_fault(three_renderers({}), random_stalls(0, 50)), drift);
    MachineRun drifting("drifting", scenario);
    CHECK(drifting.machine().matching_blocks({"link_clock_*"}) == 1);
    CHECK(drifting.machine().matching_blocks({"link_clock_2"}) == 1);
}

TEST_CASE("a column that random stalls hold nearly for ever: the watchdog names the wires",
          "[system][faults]") {
    // In the middle of a frame, so that the columns move.
    Scenario scenario = three_renderers({});
    for (int r = 0; r < 3; ++r) scenario = with_fault(scenario, random_stalls(r, 99, 1900));
    const MachineRuns runs = run_all({scenario});
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
    check_stalled_machines(random_seed(5001));
}

TEST_CASE("random stalls on every handshake of a row: nothing is lost or late (seeds 6001 on)",
          "[system][slow]") {
    check_stalled_machines(6001);
}

TEST_CASE("random stalls on every handshake of a row: nothing is lost or late (seeds 6101 on)",
          "[system][slow]") {
    check_stalled_machines(6101);
}

Fault reset_at(std::int64_t cycle, std::int64_t cycles) {
    Fault fault;
    fault.kind = FaultKind::kReset;
    fault.from_cycle = cycle;
    fault.cycles = cycles;
    return fault;
}

/// With clocks of one period a run after the last reset is the run from power-up, so many clocks later.
TEST_CASE(
    "resets at any moment: the run begins again and goes as it does from power-up, and each is counted, also "
    "of those that overlap",
    "[system][faults]") {
    constexpr std::int64_t kPowerUpCycles = 2;
    const std::vector<std::vector<Fault>> rows{{},
                                               {reset_at(1, 9)},
                                               {reset_at(300, 2)},
                                               {reset_at(600, 20), reset_at(610, 20)},
                                               {reset_at(100, 20), reset_at(600, 30)},
                                               {reset_at(1111, 3)},
                                               {reset_at(2600, 5)},
                                               {reset_at(4700, 2)},
                                               {reset_at(9001, 2)},
                                               {reset_at(14'000, 4)}};
    std::vector<Scenario> scenarios;
    for (const std::vector<Fault>& resets : rows) scenarios.push_back(one_clock(resets));
    const MachineRuns runs = run_all(scenarios);
    const RunReport& undisturbed = runs.front()->report();
    REQUIRE(undisturbed.core_cycles > 14'000);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const RunReport& report = runs[i]->report();
        const std::int64_t end =
            rows[i].empty() ? kPowerUpCycles : rows[i].back().from_cycle + *rows[i].back().cycles;
        const std::int64_t later = end - kPowerUpCycles;
        INFO("reset until core clock " << end);
        CHECK(report.core_cycles == undisturbed.core_cycles + later);
        CHECK(check_shown(*runs[i], {}) == kFrames);
        REQUIRE(report.frames.size() == undisturbed.frames.size());
        for (std::size_t f = 0; f < report.frames.size(); ++f) {
            CHECK(report.frames[f].pairs == undisturbed.frames[f].pairs);
            CHECK(report.frames[f].start_cycle == undisturbed.frames[f].start_cycle + later);
        }
        for (std::size_t r = 0; r < report.renderers.size(); ++r) {
            CHECK(report.renderers[r].injected_faults == static_cast<std::int64_t>(rows[i].size()));
            // What was sent before the reset stays counted.
            CHECK(report.renderers[r].bus.pixels_sent >= undisturbed.renderers[r].bus.pixels_sent);
        }
    }
    CHECK(runs.back()->report().renderers[0].bus.pixels_sent > undisturbed.renderers[0].bus.pixels_sent);
}

TEST_CASE("after a reset the starved pixels of a frame are its own, and composers go on counting",
          "[system][faults]") {
    const auto starving = [](const std::vector<Fault>& faults) {
        Scenario scenario = one_clock(faults);
        scenario.bus.width_bits = 16;
        scenario.composer.buffer_pixels = 24;
        scenario.composer.on_starvation = StarvationMode::kGlitch;
        check_scenario(scenario);
        return scenario;
    };
    const MachineRuns runs = run_all({starving({}), starving({reset_at(14'000, 2)})});
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
