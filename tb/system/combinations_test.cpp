#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "machine_checks.h"
#include "machine_coverage.h"
#include "machine_run.h"
#include "scenario/limits.h"
#include "scenario/names.h"
#include "scenario/scenario_loader.h"
#include "support/images.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

// Every arbitration policy with every width of bus and every kind of display clock, in both modes of starvation. The
// machines are small, two composers of each bus want it at once, and all monitors watch. Their pictures must be the
// functional level's.

namespace metabuffer::test::combinations_test {

namespace {

/// So slow that run_to_end lets a machine run on for only a few hundred clocks after its end.
constexpr double kCoreMhz = 4.0;
/// One for each coverage::ClockRatio.
constexpr std::array<double, 5> kDviOutMhz{2.0, 2.9, 4.0, 5.3, 8.0};

constexpr int kDisplayWidth = 9;
constexpr int kDisplayHeight = 4;
constexpr int kImageWidth = 17;  ///< its control scanline holds a table of two rows
constexpr int kImageHeight = 3;

/// Two renderers whose images lie on both displays, at slightly different positions in each frame.
Scenario contested_buses(const std::string& name, std::uint64_t seed) {
    Random random(seed);
    Scenario scenario = small_scenario(kDisplayWidth, kDisplayHeight, 2);
    scenario.name = name;
    scenario.composition = one_of(random, kCompositionTable).value;
    scenario.clocks = {kCoreMhz, kCoreMhz, kCoreMhz};
    scenario.memory.words_per_cycle = 8;
    scenario.memory.page_words = random.between(8, 40);
    scenario.memory.page_miss_cycles = random.between(0, 3);
    scenario.bus.burst_pixels = random.between(3, 9);
    scenario.frames = 2;
    for (int r = 0; r < 2; ++r) {
        const PixelImage image = opaque_noise_image(random, kImageWidth, kImageHeight);
        std::vector<Viewport> viewports;
        for (int pair = 0; pair < scenario.frames; ++pair) {
            viewports.push_back(Viewport{random.between(0, 2), random.between(0, 1), 1});
        }
        add_renderer(scenario, renderer_of({image}, viewports, scenario.displays.wall()));
    }
    return scenario;
}

/// Chooses a buffer for the bus that the scenario has. Most buffers hold less than a segment, so that the order of
/// bursts decides who waits. With little ready space a burst can be cut, on a narrow bus in the middle of a beat.
void choose_buffer(Scenario& scenario, std::uint64_t seed) {
    Random random(seed);
    const int in_flight = in_flight_pixels(scenario.bus, scenario.memory);
    scenario.composer.ready_space_pixels =
        random.one_in(2) ? in_flight : std::max(scenario.bus.burst_pixels, in_flight);
    scenario.composer.buffer_pixels = scenario.composer.ready_space_pixels + random.between(0, 8);
    check_scenario(scenario);
}

/// Frames counted for irsa on a bus of 64 bits with equal clocks, in mode stall. No other combination may have any.
std::int64_t contested_frames(const coverage::MachineCoverage& sampler) {
    const std::int64_t frames =
        sampler.goals()
            .combination.bins(Arbitration::kIrsa, 64, coverage::ClockRatio::kEqual, StarvationMode::kStall)
            .count();
    std::int64_t sum = 0;
    for (const coverage::Goal& goal : sampler.counts().groups().at("bus/policy-width-ratio").goals) {
        sum += goal.count;
    }
    CHECK(sum == frames);
    return frames;
}

/// Holds a handshake of the second display's composers low from the start, for ever if `cycles` is empty.
void hold_second_display(Scenario& scenario, FaultKind kind, std::optional<std::int64_t> cycles) {
    for (int renderer = 0; renderer < 2; ++renderer) {
        Fault fault;
        fault.kind = kind;
        fault.renderer = renderer;
        fault.display = 2;
        fault.cycles = cycles;
        scenario.faults.push_back(fault);
    }
}

/// Runs every width of bus with every display clock. Fixed seeds choose what else differs between the machines.
void run_and_check(Arbitration arbitration, StarvationMode mode) {
    MachineRuns runs;
    for (const int width_bits : limits::kBusWidthsBits) {
        for (const double dvi_out_mhz : kDviOutMhz) {
            const std::string name = "machine_" + std::to_string(runs.size());
            const std::uint64_t seed = runs.size() + 1;
            Scenario scenario = contested_buses(name, seed);
            scenario.bus.arbitration = arbitration;
            scenario.bus.width_bits = width_bits;
            scenario.composer.on_starvation = mode;
            scenario.clocks.dvi_out_mhz = dvi_out_mhz;
            choose_buffer(scenario, seed);
            runs.push_back(std::make_unique<MachineRun>(name, std::move(scenario)));
        }
    }
    const bool ended = run_to_end(runs);
    for (const auto& run : runs) {
        INFO(run->scenario().name << ": " << to_string(arbitration) << ", " << to_string(mode) << ", "
                                  << run->scenario().bus.width_bits << " bits, DVI out "
                                  << run->scenario().clocks.dvi_out_mhz << " MHz");
        REQUIRE((ended || run->finished()));
        check_run(*run);
    }
}

class Combination final : public Catch::ITestInvoker {
  public:
    Combination(Arbitration arbitration, StarvationMode mode) : arbitration_(arbitration), mode_(mode) {}
    void invoke() const override { run_and_check(arbitration_, mode_); }

  private:
    Arbitration arbitration_;
    StarvationMode mode_;
};

/// The sanitizers run two of them; the others are more of the same.
bool is_quick(Arbitration arbitration, StarvationMode mode) {
    return mode == StarvationMode::kStall ? arbitration == Arbitration::kIrsa
                                          : arbitration == Arbitration::kEdf;
}

bool register_combinations() {
    for (const auto& policy : EnumNames<Arbitration>::kTable) {
        for (const auto& mode : EnumNames<StarvationMode>::kTable) {
            const std::string name =
                std::string("every width and display clock under ") + policy.name + " in " + mode.name;
            const std::string tags =
                std::string("[system][coverage]") + (is_quick(policy.value, mode.value) ? "" : "[slow]");
            // Registers in its constructor, as the macro does for a function.
            const Catch::AutoReg registration(new Combination(policy.value, mode.value),
                                              CATCH_INTERNAL_LINEINFO, Catch::StringRef(),
                                              Catch::NameAndTags{name, tags});
        }
    }
    return true;
}

const bool kRegistered = register_combinations();

}  // namespace

TEST_CASE("coverage: a combination counts the frames that its composers competed for and the displays showed",
          "[system][coverage]") {
    REQUIRE(kRegistered);
    std::vector<Scenario> scenarios;
    for (const char* name : {"contested", "one_display", "one_behind_the_other", "never_shown"}) {
        scenarios.push_back(contested_buses(name, 1));
        scenarios.back().bus.width_bits = 64;
        scenarios.back().composer.on_starvation = StarvationMode::kStall;
    }
    for (Renderer& renderer : scenarios[1].renderers) {
        for (RendererFrame& frame : renderer.frames) {
            frame.viewport.reset();
            frame.table.resize(1);
        }
    }
    constexpr std::int64_t kFirstFrameIsSent = 6000;
    scenarios[2].frames = 1;
    scenarios[2].watchdog_cycles = 2 * kFirstFrameIsSent;
    hold_second_display(scenarios[2], FaultKind::kBusreadyLow, kFirstFrameIsSent);
    hold_second_display(scenarios[3], FaultKind::kPipereadyLow, std::nullopt);
    MachineRuns runs;
    std::vector<std::unique_ptr<coverage::MachineCoverage>> samplers;
    for (Scenario& scenario : scenarios) {
        choose_buffer(scenario, 1);
        const std::string name = scenario.name;
        runs.push_back(std::make_unique<MachineRun>(name, scenario));
        samplers.push_back(std::make_unique<coverage::MachineCoverage>(
            (name + "_sampler").c_str(), runs.back()->machine(), runs.back()->scenario()));
    }
    REQUIRE(run_to_end(runs));
    constexpr std::array<std::int64_t, 4> kShown{2, 2, 1, 0};
    constexpr std::array<std::int64_t, 4> kCounted{2, 0, 0, 0};
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO(runs[i]->scenario().name);
        samplers[i]->finished(runs[i]->report());
        CHECK(runs[i]->report().frames_shown() == kShown[i]);
        CHECK(contested_frames(*samplers[i]) == kCounted[i]);
    }
    // The third had something to send to both displays, the fourth to each in turn.
    CHECK(runs[2]->report().core_cycles > kFirstFrameIsSent);
    CHECK(runs[3]->report().total_bus().bursts > 4);
}

}  // namespace metabuffer::test::combinations_test
