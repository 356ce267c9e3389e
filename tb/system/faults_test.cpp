#include <catch2/catch.hpp>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "machine_checks.h"
#include "machine_run.h"
#include "random_scenario.h"
#include "random_seed.h"
#include "scenario/names.h"
#include "scenario/scenario_loader.h"
#include "tlm_run.h"
#include "trace_switch.h"

using namespace metabuffer;
using namespace metabuffer::test;

namespace {

constexpr int kFrames = 4;
constexpr int kImageWidth = 24;
constexpr int kImageHeight = 10;
constexpr int kFaultyRenderer = 0;  // index
constexpr FaultKind kFaultKinds[] = {FaultKind::kMagic,    FaultKind::kVersion,    FaultKind::kKind,
                                     FaultKind::kCrc,      FaultKind::kNumber,     FaultKind::kShortLine,
                                     FaultKind::kLongLine, FaultKind::kShortFrame, FaultKind::kLongFrame,
                                     FaultKind::kMissing,  FaultKind::kDelay};

PixelImage noise(Random& random) {
    PixelImage image(kImageWidth, kImageHeight);
    for (Pixel& pixel : image.values) {
        const std::uint64_t bits = random.bits();
        pixel =
            Pixel(static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                  static_cast<std::uint8_t>(bits >> 16), 255, static_cast<std::uint32_t>(bits >> 32) & 0xFFU);
    }
    return image;
}

/// Two displays, two renderers whose every pair has an image of its own, so that a picture made of parts of
/// two pairs cannot pass for a good one. The bus is wide: nothing starves.
Scenario two_renderers(int different_pairs) {
    Random random(2026);
    Scenario scenario;
    scenario.name = "faults";
    scenario.displays.columns = 2;
    scenario.displays.width_pixels = 14;
    scenario.displays.height_pixels = 12;
    scenario.memory.words_per_cycle = 4;
    scenario.bus.width_bits = 256;
    scenario.frames = kFrames;
    for (int r = 0; r < 2; ++r) {
        Renderer renderer;
        renderer.name = "renderer_" + std::to_string(r + 1);
        renderer.image_width_pixels = kImageWidth;
        renderer.image_height_pixels = kImageHeight;
        for (int pair = 0; pair < different_pairs; ++pair) {
            RendererFrame frame;
            frame.image = static_cast<std::size_t>(pair);
            frame.viewport = Viewport{2 + (pair + r) % 3, 1 + pair % 2, 1};
            frame.table =
                split_viewport(*frame.viewport, kImageWidth, kImageHeight, scenario.displays.wall());
            renderer.images.push_back(std::make_shared<const PixelImage>(noise(random)));
            renderer.frames.push_back(frame);
        }
        scenario.renderers.push_back(renderer);
    }
    check_scenario(scenario);
    return scenario;
}

Scenario with_fault(FaultKind kind, FrameKind frame, std::uint32_t pair, int delay_pairs) {
    Scenario scenario = two_renderers(kFrames);
    scenario.faults.push_back(
        {kFaultyRenderer, pair, kind, frame, kind == FaultKind::kDelay ? delay_pairs : 0});
    check_scenario(scenario);
    return scenario;
}

/// A machine for every kind of fault and either frame of a pair, all in one elaboration.
MachineRuns machines_with_faults(std::uint32_t pair, int delay_pairs, Pacing pacing) {
    MachineRuns runs;
    for (const FaultKind kind : kFaultKinds) {
        for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
            Scenario scenario = with_fault(kind, frame, pair, delay_pairs);
            scenario.pacing = pacing;
            runs.push_back(std::make_unique<MachineRun>(std::string(to_string(kind)) + "_" + to_string(frame),
                                                        std::move(scenario)));
        }
    }
    return runs;
}

/// Runs the machines, and beside them those of level tlm, which must do the same.
void run_traced(MachineRuns& runs) {
    TraceSwitch trace;
    TlmRuns tlm_runs;
    for (const auto& run : runs) {
        trace.add(run->machine());
        const std::string name = "tlm_" + std::to_string(tlm_runs.size() + 1);
        tlm_runs.push_back(std::make_unique<TlmRun>(name, run->scenario()));
    }
    REQUIRE(run_to_end(runs));
    simulate_until([&tlm_runs] {
        return std::all_of(tlm_runs.begin(), tlm_runs.end(), [](const auto& run) { return run->finished(); });
    });
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO(describe(runs[i]->scenario()));
        const std::vector<std::string> differences = level_differences(*runs[i], *tlm_runs[i]);
        INFO(first_lines(differences));
        CHECK(differences.empty());
    }
}

/// The cause under which the decoder counts a fault; none for one that is no frame's own fault.
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
        case FaultKind::kDelay:
            break;
    }
    return std::nullopt;
}

using RejectedFrames = std::array<std::int64_t, kRejectCauseCount>;

RejectedFrames one_rejection(FaultKind kind) {
    RejectedFrames expected{};
    if (const auto cause = cause_of(kind)) expected[static_cast<std::size_t>(*cause)] = 1;
    return expected;
}

std::vector<int> pairs_of(const MachineRun& run, std::size_t renderer) {
    std::vector<int> pairs;
    for (const FrameRecord& frame : run.report().frames) pairs.push_back(frame.pairs.at(renderer));
    return pairs;
}

const RendererCounters& faulty(const MachineRun& run) { return run.report().renderers[kFaultyRenderer]; }

/// What holds for a machine with a fault as for any other: whole pictures of whole pairs, on every display;
/// and the other renderer goes on in step.
void check_machine(const MachineRun& run) {
    const Fault& fault = run.scenario().faults.at(0);
    INFO("fault " << to_string(fault.kind) << " in the " << to_string(fault.frame) << " frame of pair "
                  << fault.pair);
    check_run(run);
    CHECK(run.report().total_starved_pixels() == 0);
    const RendererCounters& other = run.report().renderers[1 - kFaultyRenderer];
    CHECK(other.rejected_frames == RejectedFrames{});
}

}  // namespace

TEST_CASE("a faulty pair is counted by its cause and replaced by the last good one", "[system][faults]") {
    constexpr std::uint32_t kPair = 1;
    MachineRuns runs = machines_with_faults(kPair, 3, Pacing::kLockstep);
    run_traced(runs);
    for (const auto& run : runs) {
        const Fault& fault = run->scenario().faults[0];
        INFO("fault " << to_string(fault.kind) << " in the " << to_string(fault.frame) << " frame");
        check_machine(*run);
        CHECK(faulty(*run).rejected_frames == one_rejection(fault.kind));
        CHECK(run->report().renderers[1].repeated_frames == 0);
        CHECK(pairs_of(*run, 1) == std::vector<int>{0, 1, 2, 3});
        if (fault.kind == FaultKind::kDelay) {
            // Three pair times of silence are past the timeout of two.
            CHECK(faulty(*run).repeated_frames >= 1);
            CHECK(pairs_of(*run, 0)[kPair] == 0);
            CHECK(pairs_of(*run, 0).back() >= 2);
        } else {
            CHECK(faulty(*run).repeated_frames == 1);
            CHECK(faulty(*run).dropped_frames == 0);
            CHECK(pairs_of(*run, 0) == std::vector<int>{0, 0, 2, 3});  // recovered at the next good pair
        }
    }
}

TEST_CASE("a renderer without a good pair yet contributes an empty table", "[system][faults]") {
    MachineRuns runs = machines_with_faults(0, 3, Pacing::kLockstep);
    run_traced(runs);
    for (const auto& run : runs) {
        const Fault& fault = run->scenario().faults[0];
        INFO("fault " << to_string(fault.kind) << " in the " << to_string(fault.frame) << " frame");
        check_machine(*run);
        CHECK(pairs_of(*run, 0)[0] == -1);
        CHECK(pairs_of(*run, 1) == std::vector<int>{0, 1, 2, 3});
        if (fault.kind != FaultKind::kDelay) {
            CHECK(pairs_of(*run, 0) == std::vector<int>{-1, 1, 2, 3});
        }
        // A link that begins with a depth frame has not begun: the decoder looks for a colour frame.
        const bool never_noticed = fault.kind == FaultKind::kMissing && fault.frame == FrameKind::kColour;
        CHECK(faulty(*run).rejected_frames == (never_noticed ? RejectedFrames{} : one_rejection(fault.kind)));
    }
}

TEST_CASE("the last pair's fault leaves the last good pair on the displays", "[system][faults]") {
    MachineRuns runs = machines_with_faults(kFrames - 1, 3, Pacing::kLockstep);
    run_traced(runs);
    for (const auto& run : runs) {
        const Fault& fault = run->scenario().faults[0];
        INFO("fault " << to_string(fault.kind) << " in the " << to_string(fault.frame) << " frame");
        check_machine(*run);
        CHECK(pairs_of(*run, 0) == std::vector<int>{0, 1, 2, 2});
        CHECK(faulty(*run).repeated_frames == 1);
        // Nothing follows a depth frame that is not sent: only the timeout tells.
        const bool never_noticed = fault.kind == FaultKind::kMissing && fault.frame == FrameKind::kDepth;
        CHECK(faulty(*run).rejected_frames == (never_noticed ? RejectedFrames{} : one_rejection(fault.kind)));
    }
}

TEST_CASE("a link that is silent for less than the timeout is waited for", "[system][faults]") {
    MachineRuns runs;
    for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
        runs.push_back(std::make_unique<MachineRun>(std::string("delay_") + to_string(frame),
                                                    with_fault(FaultKind::kDelay, frame, 1, 1)));
    }
    run_traced(runs);
    for (const auto& run : runs) {
        check_machine(*run);
        CHECK(pairs_of(*run, 0) == std::vector<int>{0, 1, 2, 3});
        CHECK(faulty(*run).repeated_frames == 0);
    }
}

TEST_CASE("a late pair is dropped, the renderer's next one is shown", "[system][faults]") {
    MachineRuns runs;
    runs.push_back(
        std::make_unique<MachineRun>("late", with_fault(FaultKind::kDelay, FrameKind::kColour, 0, 3)));
    run_traced(runs);
    check_machine(*runs[0]);
    // Pair 0 ends four pair times after the start. By then its frame has gone without it, after two; frame 1
    // is waited for until four, a few clocks longer than pair 0 takes, and goes without as well.
    CHECK(faulty(*runs[0]).dropped_frames >= 1);
    CHECK(faulty(*runs[0]).repeated_frames >= 1);
    CHECK(pairs_of(*runs[0], 0)[0] == -1);
    CHECK(pairs_of(*runs[0], 0).back() >= 2);
}

TEST_CASE("free-running: a faulty pair is never shown", "[system][faults]") {
    constexpr std::uint32_t kPair = 2;
    MachineRuns runs = machines_with_faults(kPair, 2, Pacing::kFreeRunning);
    run_traced(runs);
    for (const auto& run : runs) {
        const Fault& fault = run->scenario().faults[0];
        INFO("fault " << to_string(fault.kind) << " in the " << to_string(fault.frame) << " frame");
        check_machine(*run);
        if (fault.kind != FaultKind::kDelay) {
            for (const int pair : pairs_of(*run, 0)) CHECK(pair != static_cast<int>(kPair));
        }
    }
}

TEST_CASE("free-running: a slow machine drops pairs and shows whole ones", "[system][faults]") {
    constexpr int kDifferentPairs = 300;
    MachineRuns runs;
    for (const double core_mhz : {5.0, 11.3, 20.0}) {
        Scenario scenario = two_renderers(kDifferentPairs);
        scenario.pacing = Pacing::kFreeRunning;
        scenario.clocks = {core_mhz, 200.0, 150.0};
        scenario.frames = 8;
        scenario.displays.supersample = 4;  // a raster that takes longer than a pair on the link
        for (Renderer& renderer : scenario.renderers) {
            for (RendererFrame& frame : renderer.frames) {
                frame.viewport->multiple = 4;
                frame.table =
                    split_viewport(*frame.viewport, kImageWidth, kImageHeight, scenario.displays.wall());
            }
        }
        check_scenario(scenario);
        runs.push_back(
            std::make_unique<MachineRun>("slow_" + std::to_string(runs.size() + 1), std::move(scenario)));
    }
    run_traced(runs);
    for (const auto& run : runs) {
        INFO("core clock " << run->scenario().clocks.core_mhz << " MHz");
        check_run(*run);
        CHECK(run->report().total_starved_pixels() == 0);
        for (std::size_t r = 0; r < 2; ++r) {
            INFO("renderer " << r + 1);
            const RendererCounters& counters = run->report().renderers[r];
            CHECK(counters.dropped_frames > 0);
            CHECK(counters.rejected_frames == RejectedFrames{});
            const std::vector<int> pairs = pairs_of(*run, r);
            CHECK(pairs.back() < kDifferentPairs);  // so every pair shown had an image of its own
            // Frames 1 and 2 are asked for as soon as the buffers have swallowed what is before them, perhaps
            // before there is another pair; from then on many pairs pass in each frame, and each shows a
            // newer one.
            for (std::size_t k = 3; k < pairs.size(); ++k) {
                INFO("frame " << k);
                CHECK(pairs[k] > pairs[k - 1]);
            }
        }
    }
}

TEST_CASE("free-running: a fast machine shows a pair again while the next one comes", "[system][faults]") {
    Scenario scenario = two_renderers(kFrames);
    scenario.pacing = Pacing::kFreeRunning;
    scenario.clocks = {200.0, 20.0, 200.0};
    scenario.frames = 12;
    MachineRuns runs;
    runs.push_back(std::make_unique<MachineRun>("fast", std::move(scenario)));
    run_traced(runs);
    check_run(*runs[0]);
    for (const RendererCounters& counters : runs[0]->report().renderers) {
        CHECK(counters.repeated_frames > 0);
        CHECK(counters.dropped_frames == 0);
    }
}
