#include <algorithm>
#include <catch2/catch.hpp>
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
#include "noise_image.h"
#include "random_scenario.h"
#include "random_seed.h"
#include "rtl/wires.h"
#include "scenario/names.h"
#include "scenario/scenario_loader.h"
#include "trace_switch.h"

using namespace metabuffer;
using namespace metabuffer::test;

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

/// Three renderers on two displays. Every pair has an image of its own, so that a picture made of parts of two frames
/// cannot pass for a good one. The links are so fast that the buses have hardly a pause.
Scenario three_renderers(const Machine& machine) {
    Random random(77);
    Scenario scenario;
    scenario.name = "machine-faults";
    scenario.displays.columns = kDisplays;
    scenario.displays.width_pixels = 14;
    scenario.displays.height_pixels = 12;
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
    const int width = 24 / machine.multiple;
    const int height = 10 / machine.multiple;
    for (int r = 0; r < 3; ++r) {
        Renderer renderer;
        renderer.name = "renderer_" + std::to_string(r + 1);
        renderer.image_width_pixels = std::max(width, kNarrowestForTwoRows);
        renderer.image_height_pixels = height;
        for (int pair = 0; pair < kFrames; ++pair) {
            RendererFrame frame;
            frame.image = static_cast<std::size_t>(pair);
            frame.viewport = Viewport{2 + (pair + r) % 3, 1 + pair % 2, machine.multiple};
            frame.table = split_viewport(*frame.viewport, renderer.image_width_pixels,
                                         renderer.image_height_pixels, scenario.displays.wall());
            renderer.images.push_back(std::make_shared<const PixelImage>(
                noise_image(random, renderer.image_width_pixels, renderer.image_height_pixels)));
            renderer.frames.push_back(frame);
        }
        scenario.renderers.push_back(renderer);
    }
    check_scenario(scenario);
    return scenario;
}

Scenario with_fault(Scenario scenario, const Fault& fault) {
    scenario.faults.push_back(fault);
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

/// What has been shown, as far as the run came, is whole: every frame that is not kept back is its own picture, and in
/// place of the others the one before stays, on every display. Gives the frames shown on every display.
int check_shown(const MachineRun& run, const std::set<int>& kept) {
    int shown_on_all = kFrames;
    for (int display = 1; display <= kDisplays; ++display) {
        ColourImage before = black(run.scenario());
        for (int frame = 0; frame < kFrames; ++frame) {
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
        // The PIPEMASTER has no wire for its own: it is kept from raising it.
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

TEST_CASE("a wire that is low for a while: every frame is shown and right", "[system][faults]") {
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
    /// The frames that can be kept off the displays: the composer has known before its last raster pixel.
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
                // Nothing came behind the segment's last pixels.
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

/// Which places of a loss a set of runs has met.
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

struct LossRuns {
    MachineRuns runs;
    std::vector<std::unique_ptr<LossProbe>> probes;

    void add(const Scenario& scenario) {
        const std::string number = std::to_string(runs.size());
        runs.push_back(std::make_unique<MachineRun>("run_" + number, scenario));
        probes.push_back(
            std::make_unique<LossProbe>(("probe_" + number).c_str(), *runs.back(), runs.back()->machine()));
    }
};

/// Everything that is asked of a run in which beats were lost.
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
        // The last frame's last pixels: nothing comes behind them that could tell.
        CHECK_FALSE(probe.all_known());
        CHECK(shown == kFrames - 1);
        CHECK(any_contains(run.machine().watchdog_findings(), "composer_2_2 waits for "));
    }
    for (const DisplayCounters& display : run.report().displays) {
        CHECK(display.frames_shown == shown);
        CHECK(display.kept_frames == static_cast<std::int64_t>(kept.size()));
    }
    // Nothing is composited without its pixels and shown, but where nobody could know.
    if (stall) {
        CHECK(run.report().total_starved_pixels() == 0);
        CHECK((probe.frames_not_known_in_time().empty() || !probe.all_known()));
    }
}

}  // namespace

namespace {

/// Machines that lose beats here and there, and what is asked of each. Gives what they have met.
LossCoverage lose_beats(StarvationMode mode, std::uint64_t seed) {
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    LossRuns all;
    constexpr int kBeats[] = {1, 1, 1, 1, 2, 3, 8, 30, 400};
    for (int i = 0; i < 36; ++i) {
        Machine machine;
        machine.mode = mode;
        machine.multiple = i % 3 == 2 ? 2 : 1;
        machine.buffer_pixels = random.one_in(3) ? 32 : random.between(40, 200);
        machine.bus_bits = 64 << random.between(0, 2);
        Fault fault = machine_fault(FaultKind::kLostBeat, random.between(500, 3200));
        fault.beats = kBeats[random.between(0, 8)];
        all.add(with_fault(three_renderers(machine), fault));
    }
    run_traced(all.runs);
    LossCoverage coverage;
    for (std::size_t i = 0; i < all.runs.size(); ++i) {
        INFO("run " << i << ": " << describe(all.runs[i]->scenario()));
        check_losses(*all.runs[i], *all.probes[i]);
        coverage.take(*all.probes[i]);
    }
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

TEST_CASE("lost beats in stall mode: their frame is not shown and the next good one is", "[system][faults]") {
    const LossCoverage coverage = lose_beats(StarvationMode::kStall, random_seed(4201));
    CHECK(coverage.never_known > 0);  // and the watchdog has told
}

TEST_CASE("lost beats in glitch mode: their frame is not shown and the next good one is",
          "[system][faults]") {
    const LossCoverage coverage = lose_beats(StarvationMode::kGlitch, random_seed(4301));
    CHECK(coverage.not_known_in_time > 0);  // shown, and its starved pixels counted
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

TEST_CASE("random stalls: clock gating changes neither clocks nor counters", "[system][faults]") {
    constexpr std::uint64_t kFirstSeed = 7001;
    constexpr int kMachines = 5;
    MachineRuns runs;
    for (int i = 0; i < kMachines; ++i) {
        const Scenario scenario = random_stalled_scenario(kFirstSeed + static_cast<std::uint64_t>(i));
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
