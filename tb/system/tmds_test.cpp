#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "functional/functional_compositor.h"
#include "machine_checks.h"
#include "machine_run.h"
#include "naive_pipeline.h"
#include "random_scenario.h"
#include "report/report_difference.h"
#include "rtl/wires.h"
#include "scenario/fault_kinds.h"
#include "scenario/link_program.h"
#include "scenario/names.h"
#include "support/images.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "support/tmds_flow_chart.h"
#include "tlm_run.h"

// Machines whose DVI links carry characters, healthy and disturbed.
namespace metabuffer::test::tmds_test {
namespace {

constexpr int kFrames = 5;
constexpr int kWidth = 20;
constexpr int kHeight = 9;
constexpr int kFirstActiveLine = 6;               // of a frame on the link, after its back porch
constexpr int kImageLine = kFirstActiveLine + 1;  // after the control scanline
constexpr int kLineClocks = kWidth + 80;
constexpr std::uint32_t kPair = 1;  // in which faults are

/// Two renderers on one display, each of whose pairs has its own image. The second one is never hidden.
Scenario two_links(Pacing pacing = Pacing::kLockstep) {
    Random random(91);
    Scenario scenario = small_scenario(kWidth, 2 * kHeight);
    scenario.name = "links";
    scenario.links.layer = LinkLayer::kTmds;
    scenario.pacing = pacing;
    scenario.frames = kFrames;
    scenario.composer.on_starvation = StarvationMode::kStall;
    for (int r = 0; r < 2; ++r) {
        std::vector<PixelImage> images;
        for (int pair = 0; pair < kFrames; ++pair) {
            images.push_back(opaque_noise_image(random, kWidth, kHeight));
        }
        add_renderer(scenario,
                     renderer_of(images, {table_row(1, {0, 0}, {kWidth, kHeight}, {0, r * kHeight})}));
    }
    check_scenario(scenario);
    return scenario;
}

Fault fault_at(FaultKind kind, FrameKind frame, TmdsChannel channel, int line, int clock) {
    Fault fault;
    fault.kind = kind;
    fault.renderer = 1;
    fault.pair = kPair;
    fault.frame = frame;
    fault.channel = channel;
    fault.at_line = line;
    fault.at_clock = clock;
    return fault;
}

Fault flip_at(FrameKind frame, TmdsChannel channel, int line, int clock, std::uint32_t bits) {
    Fault fault = fault_at(FaultKind::kTmdsBits, frame, channel, line, clock);
    fault.bits = bits;
    return fault;
}

Scenario with_faults(Scenario scenario, const std::vector<Fault>& faults) {
    scenario.faults.insert(scenario.faults.end(), faults.begin(), faults.end());
    check_scenario(scenario);
    return scenario;
}

ColourImage reference(const Scenario& scenario, const MachineRun& run, int frame) {
    const auto& pairs = run.report().frames.at(static_cast<std::size_t>(frame)).pairs;
    return functional::composite_display(scenario, functional::contributions_of(scenario, pairs), 1);
}

/// Every frame shows what the reference makes of its pairs.
void check_pictures(const MachineRun& run) {
    for (int frame = 0; frame < kFrames; ++frame) {
        CHECK(differing_pixels(run.picture(frame, 1), reference(run.scenario(), run, frame)) == 0);
    }
}

std::vector<std::string> report_differences(const MachineRun& one, const MachineRun& other) {
    return compare_reports(report_json(one.report()), report_json(other.report()), {"one", "other"})
        .differences;
}

std::int64_t rejected(const MachineRun& run, RejectCause cause) {
    return run.report().renderers[1].rejected_frames[static_cast<std::size_t>(cause)];
}

/// The pairs of renderer 2 in the frames of a run.
std::vector<int> pairs_shown(const MachineRun& run) {
    std::vector<int> pairs;
    for (const FrameRecord& frame : run.report().frames) pairs.push_back(frame.pairs.at(1));
    return pairs;
}

/// Whether a picture differs from the reference only within these rows of the second renderer's image, up to and with
/// the last one.
bool differs_only_in(const ColourImage& shown, const ColourImage& right, int first_row, int last_row) {
    for (int y = 0; y < shown.height_pixels; ++y) {
        const bool may_differ = y >= kHeight + first_row && y <= kHeight + last_row;
        for (int x = 0; x < shown.width_pixels && !may_differ; ++x) {
            if (shown.at(x, y) != right.at(x, y)) return false;
        }
    }
    return true;
}

// ---- healthy links ----

TEST_CASE("levels agree on machines whose links carry characters", "[system][tmds]") {
    std::vector<LevelRuns> runs;
    const std::vector<ClockConfig> clocks{{100, 100, 100}, {100, 25, 60}, {100, 100, 30},
                                          {20, 100, 33},   {20, 33, 100}, {41, 100, 100}};
    for (std::size_t i = 0; i < clocks.size(); ++i) {
        for (const Pacing pacing : {Pacing::kLockstep, Pacing::kFreeRunning}) {
            Scenario scenario = two_links(pacing);
            scenario.clocks = clocks[i];
            scenario.frames = 3;
            scenario.link_timeout_pairs = 1;
            if (i % 2 == 0) scenario.composer.on_starvation = StarvationMode::kGlitch;
            Fault fault;
            fault.renderer = 1;
            fault.pair = 1;
            fault.kind = i % 2 == 0 ? FaultKind::kDelay : FaultKind::kShortFrame;
            fault.delay_pairs = i % 2 == 0 ? 2 : 0;
            scenario.faults.push_back(fault);
            check_scenario(scenario);
            runs.emplace_back("machine_" + std::to_string(runs.size()), scenario);
        }
    }
    for (int extent = 1; extent <= 3; ++extent) {  // frames so short that the handshakes of two of them meet
        Scenario scenario = small_scenario(extent, extent);
        scenario.links.layer = LinkLayer::kTmds;
        scenario.frames = 3;
        scenario.renderers.push_back(
            renderer_of({noise_image(7, kWidth, 2)}, {segment_row({extent, extent})}));
        if (extent == 3) scenario.renderers[0].frames[0].table[0].sdy = 2;
        check_scenario(scenario);
        runs.emplace_back("machine_" + std::to_string(runs.size()), scenario);
    }
    for (std::int64_t cycles = 2'000; cycles < 2'400;
         cycles += 20) {  // ended by the watchdog, at many moments
        Scenario scenario = two_links();
        scenario.watchdog_cycles = cycles;
        scenario.frames = 2;
        runs.emplace_back("machine_" + std::to_string(runs.size()), scenario);
    }
    REQUIRE(run_to_end(runs));
    for (const LevelRuns& run : runs) check_levels(run);
}

TEST_CASE(
    "characters on the links shift a machine by the clocks of encoder and decoder and change nothing else",
    "[system][tmds]") {
    Scenario pixels = two_links();
    pixels.links.layer = LinkLayer::kPixel;
    MachineRuns runs;
    runs.push_back(std::make_unique<MachineRun>("pixels", pixels));
    runs.push_back(std::make_unique<MachineRun>("characters", two_links()));
    REQUIRE(run_to_end(runs));
    for (const auto& run : runs) check_run(*run);
    const FrameRecord& before = runs[0]->report().frames[0];
    const FrameRecord& after = runs[1]->report().frames[0];
    constexpr int kLinkClocks = 7;  // of the renderers' links, whose clock is that of the core
    CHECK(after.start_cycle == before.start_cycle + kLinkClocks);
    CHECK(after.end_cycle == before.end_cycle + kLinkClocks);
    CHECK(after.latency_cycles == before.latency_cycles);  // counted from the decoder's end of the link
    // The displays run from reset on. They swap at the start of a frame of theirs, and show it those clocks later.
    CHECK(after.swap_cycle == before.swap_cycle);
    CHECK(runs[1]->report().core_cycles == runs[0]->report().core_cycles + kLinkClocks);
    for (int frame = 0; frame < kFrames; ++frame) {
        CHECK(differing_pixels(runs[1]->picture(frame, 1), *runs[0]->picture(frame, 1)) == 0);
    }
}

TEST_CASE("only a machine whose links carry characters has encoders and decoders, two blocks a link",
          "[system][tmds]") {
    Scenario pixels = two_links();
    pixels.links.layer = LinkLayer::kPixel;
    const MachineRun plain("plain", pixels);
    const MachineRun coded("coded", two_links());
    CHECK(plain.machine().matching_blocks({"tmds_*"}) == 0);
    CHECK(coded.machine().matching_blocks({"tmds_*"}) == 2 * (2 + 1));
    CHECK(coded.machine().matching_blocks({"tmds_encoder_in_*", "tmds_decoder_out_1"}) == 3);
    const MachineRun disturbed(
        "disturbed", with_faults(two_links(), {flip_at(FrameKind::kColour, TmdsChannel::kRed, 7, 3, 1)}));
    CHECK(disturbed.machine().matching_blocks({"tmds_fault_2"}) == 1);
    CHECK(disturbed.machine().matching_blocks({"tmds_*"}) == 7);
}

TEST_CASE("characters are found again after a reset, and on a link whose clock drifts", "[system][tmds]") {
    MachineRuns runs;
    for (const std::int64_t from : {900, 4'321, 9'000}) {
        Scenario scenario = two_links();
        Fault reset;
        reset.kind = FaultKind::kReset;
        reset.from_cycle = from;
        reset.cycles = 5;
        runs.push_back(
            std::make_unique<MachineRun>("reset_" + std::to_string(from), with_fault(scenario, reset)));
    }
    for (const int ppm : {-90'000, 90'000}) {
        Fault drift;
        drift.kind = FaultKind::kDrift;
        drift.renderer = 1;
        drift.pair = 1;
        drift.ppm = ppm;
        Scenario scenario = two_links(Pacing::kFreeRunning);
        scenario.clocks = {90.0, 100.0, 33.3};
        runs.push_back(std::make_unique<MachineRun>("drift_" + std::to_string(runs.size()),
                                                    with_fault(scenario, drift)));
    }
    REQUIRE(run_to_end(runs));
    for (const auto& run : runs) {
        INFO(run->machine().name());
        REQUIRE(run->report().frames.size() == kFrames);
        check_pictures(*run);
        CHECK(run->report().renderers[0].total_rejected_frames() == 0);
    }
}

// ---- flipped bits ----

/// The byte of a channel's character in the active line `line` of the faulty frame at `x`, with `bits` of it flipped:
/// by the flow charts of DVI, from the line's beginning on. Returns which bits of the byte are wrong.
std::uint32_t wrong_bits(const Scenario& scenario, FrameKind frame, TmdsChannel channel, int line, int x,
                         std::uint32_t bits) {
    const LinkFrame link = link_frame(scenario, 1, kPair, frame);
    const auto data = [&](int column) {
        if (line == 0) return link.control[static_cast<std::size_t>(column)];
        const Pixel pixel = link.image->pixels().at(column, line - 1);
        return frame == FrameKind::kColour
                   ? std::uint32_t{pixel.r()} << 16U | std::uint32_t{pixel.g()} << 8U | pixel.b()
                   : std::uint32_t{pixel.a()} << 16U | pixel.z();
    };
    TmdsFlowChart chart;
    const unsigned shift = 8 * static_cast<unsigned>(channel);
    for (int column = 0; column <= x; ++column) chart.encode(data(column) >> shift & 0xFFU);
    const auto received = static_cast<TmdsCharacter>(chart.character() ^ bits);
    return (tmds_byte(received) ^ (data(x) >> shift)) & 0xFFU;
}

TEST_CASE("fault tmds_bits in an image pixel: the pair is shown with that byte wrong, as with pixel_bits",
          "[system][tmds][faults]") {
    const std::uint64_t seed = random_seed(92);
    INFO("seed " << seed);
    Random random(seed);
    MachineRuns runs;
    std::vector<Scenario> flipped;
    for (int i = 0; i < 24; ++i) {
        const FrameKind frame = i % 2 == 0 ? FrameKind::kColour : FrameKind::kDepth;
        const auto channel = static_cast<TmdsChannel>(i % 3);
        const int x = random.between(0, kWidth - 1);
        const int y = random.between(0, kHeight - 1);
        const auto bits =
            static_cast<std::uint32_t>(i < 20 ? 1U << unsigned(i % 10) : random.between(1, 0x3FF));
        const Scenario scenario = two_links(i < 12 ? Pacing::kLockstep : Pacing::kFreeRunning);
        Fault same;
        same.kind = FaultKind::kPixelBits;
        same.renderer = 1;
        same.pair = kPair;
        same.frame = frame;
        same.x = x;
        same.y = y;
        same.bits = wrong_bits(scenario, frame, channel, 1 + y, x, bits)
                    << (8 * static_cast<unsigned>(channel));
        if (same.bits == 0) continue;  // a character's two upper bits may undo each other
        runs.push_back(std::make_unique<MachineRun>(
            "characters_" + std::to_string(i),
            with_faults(scenario, {flip_at(frame, channel, kImageLine + y, x, bits)})));
        runs.push_back(
            std::make_unique<MachineRun>("pixels_" + std::to_string(i), with_faults(scenario, {same})));
        flipped.push_back(runs.back()->scenario());
    }
    REQUIRE(runs.size() > 40);
    REQUIRE(run_to_end(runs));
    int wrong_pictures = 0;
    for (std::size_t i = 0; i < flipped.size(); ++i) {
        const MachineRun& characters = *runs[2 * i];
        INFO(characters.machine().name());
        // Of pictures alone: the functional level has the bits of the second machine in its pictures, not of the first.
        std::vector<std::string> differences = report_differences(characters, *runs[2 * i + 1]);
        differences.erase(std::remove_if(differences.begin(), differences.end(),
                                         [](const std::string& line) {
                                             return line.find("wrong_pixels") != std::string::npos;
                                         }),
                          differences.end());
        INFO(first_lines(differences));
        CHECK(differences.empty());
        CHECK(characters.report().renderers[1].injected_faults == 1);
        CHECK(characters.report().renderers[1].total_rejected_frames() == 0);
        for (int frame = 0; frame < kFrames; ++frame) {
            const ColourImage right = reference(flipped[i], characters, frame);
            CHECK(differing_pixels(characters.picture(frame, 1), right) == 0);
            wrong_pictures += differing_pixels(characters.picture(frame, 1),
                                               reference(characters.scenario(), characters, frame)) > 0
                                  ? 1
                                  : 0;
        }
    }
    CHECK(wrong_pictures > 0);
}

TEST_CASE("fault tmds_bits in the control scanline: rejected by its cause, as a control_byte is",
          "[system][tmds][faults]") {
    MachineRuns runs;
    for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
        // Bytes of MBUF, of the version, of the content, and one after it: three bytes a pixel, red first.
        for (const int byte : {0, 2, 4, 5, 14, 3 * kWidth - 1}) {
            const Scenario scenario = two_links();
            const auto channel = static_cast<TmdsChannel>(2 - byte % 3);
            const std::uint32_t bits = 0x003;
            Fault same;
            same.kind = FaultKind::kControlByte;
            same.renderer = 1;
            same.pair = kPair;
            same.frame = frame;
            same.byte = byte;
            same.bits = wrong_bits(scenario, frame, channel, 0, byte / 3, bits);
            REQUIRE(same.bits != 0);
            const std::string name = std::string(to_string(frame)) + "_" + std::to_string(byte);
            runs.push_back(std::make_unique<MachineRun>(
                "characters_" + name,
                with_faults(scenario, {flip_at(frame, channel, kFirstActiveLine, byte / 3, bits)})));
            runs.push_back(std::make_unique<MachineRun>("bytes_" + name, with_faults(scenario, {same})));
        }
    }
    REQUIRE(run_to_end(runs));
    int rejections = 0;
    for (std::size_t i = 0; i < runs.size(); i += 2) {
        INFO(runs[i]->machine().name());
        std::vector<std::string> differences = report_differences(*runs[i], *runs[i + 1]);
        differences.erase(std::remove_if(differences.begin(), differences.end(),
                                         [](const std::string& line) {
                                             return line.find("wrong_pixels") != std::string::npos;
                                         }),
                          differences.end());
        INFO(first_lines(differences));
        CHECK(differences.empty());
        const bool lost = runs[i]->report().renderers[1].total_rejected_frames() > 0;
        rejections += lost ? 1 : 0;
        CHECK(pairs_shown(*runs[i]) ==
              (lost ? std::vector<int>{0, 0, 2, 3, 4} : std::vector<int>{0, 1, 2, 3, 4}));
    }
    CHECK(rejections >= 8);
}

TEST_CASE("fault tmds_bits in blanking: nothing happens unless blue gets another control character",
          "[system][tmds][faults]") {
    MachineRuns runs;
    runs.push_back(std::make_unique<MachineRun>("healthy", two_links()));
    for (int channel = 0; channel < 3; ++channel) {
        for (const int line : {0, kFirstActiveLine, kImageLine + 2, kImageLine + kHeight}) {
            for (const int clock : {kWidth, kWidth + 20, kLineClocks - 1}) {
                runs.push_back(std::make_unique<MachineRun>(
                    "flip_" + std::to_string(runs.size()),
                    with_faults(two_links(), {flip_at(FrameKind::kDepth, static_cast<TmdsChannel>(channel),
                                                      line, clock, 0x101)})));
            }
        }
    }
    REQUIRE(run_to_end(runs));
    for (std::size_t i = 1; i < runs.size(); ++i) {
        INFO(runs[i]->machine().name());
        CHECK(runs[i]->report().renderers[1].injected_faults == 1);
        CHECK(runs[i]->report().renderers[1].total_rejected_frames() == 0);
        CHECK(pairs_shown(*runs[i]) == std::vector<int>{0, 1, 2, 3, 4});
        CHECK(runs[i]->report().core_cycles == runs[0]->report().core_cycles);
        for (int frame = 0; frame < kFrames; ++frame) {
            CHECK(differing_pixels(runs[i]->picture(frame, 1), *runs[0]->picture(frame, 1)) == 0);
        }
    }
}

TEST_CASE("fault tmds_bits that makes a VSYNC of blanking: the frame is rejected, and the next pair is shown",
          "[system][tmds][faults]") {
    // Control character 00 into 10, between two lines of the image.
    constexpr std::uint32_t kIntoVsync = 0b1101010100 ^ 0b0101010100;
    MachineRuns runs;
    for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
        runs.push_back(std::make_unique<MachineRun>(
            to_string(frame), with_faults(two_links(), {flip_at(frame, TmdsChannel::kBlue, kImageLine + 2,
                                                                kWidth + 60, kIntoVsync)})));
    }
    REQUIRE(run_to_end(runs));
    for (const auto& run : runs) {
        INFO(run->machine().name());
        CHECK(rejected(*run, RejectCause::kGeometry) >= 1);
        CHECK(pairs_shown(*run) == std::vector<int>{0, 0, 2, 3, 4});
        check_pictures(*run);
    }
}

// ---- slips and skew ----

TEST_CASE("fault tmds_slip in an image line: its rest is wrong in one channel, all other lines are right",
          "[system][tmds][faults]") {
    MachineRuns runs;
    for (int channel = 0; channel < 3; ++channel) {
        for (const int bits : {1, 4, 9}) {
            Fault slip = fault_at(FaultKind::kTmdsSlip, FrameKind::kColour, static_cast<TmdsChannel>(channel),
                                  kImageLine + 4, 7);
            slip.late_bits = bits;
            runs.push_back(
                std::make_unique<MachineRun>("slip_" + std::to_string(channel) + "_" + std::to_string(bits),
                                             with_faults(two_links(), {slip})));
        }
    }
    REQUIRE(run_to_end(runs));
    for (const auto& run : runs) {
        INFO(run->machine().name());
        CHECK(run->report().renderers[1].total_rejected_frames() == 0);
        CHECK(run->report().renderers[1].injected_faults == 1);
        CHECK(pairs_shown(*run) == std::vector<int>{0, 1, 2, 3, 4});
        for (int frame = 0; frame < kFrames; ++frame) {
            const ColourImage right = reference(run->scenario(), *run, frame);
            const ColourImage& shown = *run->picture(frame, 1);
            const bool faulty = frame == static_cast<int>(kPair);
            CHECK((differing_pixels(&shown, right) > 0) == faulty);
            CHECK(differs_only_in(shown, right, faulty ? 4 : 1, faulty ? 4 : 0));
            if (faulty) CHECK(shown.at(6, kHeight + 4) == right.at(6, kHeight + 4));
        }
    }
}

TEST_CASE("fault tmds_slip in a control scanline: the frame is rejected once, and the next pair is shown",
          "[system][tmds][faults]") {
    MachineRuns runs;
    for (int channel = 0; channel < 3; ++channel) {
        for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
            Fault slip =
                fault_at(FaultKind::kTmdsSlip, frame, static_cast<TmdsChannel>(channel), kFirstActiveLine, 2);
            slip.late_bits = 5;
            runs.push_back(std::make_unique<MachineRun>(
                std::string("slip_") + std::to_string(channel) + "_" + to_string(frame),
                with_faults(two_links(), {slip})));
        }
    }
    REQUIRE(run_to_end(runs));
    for (const auto& run : runs) {
        INFO(run->machine().name());
        CHECK(run->report().renderers[1].total_rejected_frames() == 1);
        CHECK(rejected(*run, RejectCause::kGeometry) == 0);
        CHECK(pairs_shown(*run) == std::vector<int>{0, 0, 2, 3, 4});
        check_pictures(*run);
    }
}

TEST_CASE("fault tmds_skew in an image line: it and the next line may be wrong, all others are right",
          "[system][tmds][faults]") {
    MachineRuns runs;
    for (int channel = 0; channel < 3; ++channel) {
        for (int characters = 1; characters <= 4; ++characters) {
            Fault skew = fault_at(FaultKind::kTmdsSkew, FrameKind::kColour, static_cast<TmdsChannel>(channel),
                                  kImageLine + 3, 5);
            skew.late_characters = characters;
            // Back in step later on.
            Fault in_step = fault_at(FaultKind::kTmdsSkew, FrameKind::kDepth,
                                     static_cast<TmdsChannel>(channel), kImageLine + kHeight + 4, 50);
            in_step.pair = kPair + 1;
            runs.push_back(std::make_unique<MachineRun>(
                "skew_" + std::to_string(channel) + "_" + std::to_string(characters),
                with_faults(two_links(), {skew, in_step})));
        }
    }
    REQUIRE(run_to_end(runs));
    for (const auto& run : runs) {
        INFO(run->machine().name());
        const std::vector<int> pairs = pairs_shown(*run);
        // The second change is in a vertical sync. The next frame's first lines, its control scanline among them, show
        // the new skew: it is rejected, and its pair is lost.
        CHECK(pairs == std::vector<int>{0, 1, 2, 2, 4});
        CHECK(run->report().renderers[1].total_rejected_frames() == 1);
        CHECK(run->report().renderers[1].injected_faults == 2);
        for (int frame = 0; frame < kFrames; ++frame) {
            const ColourImage right = reference(run->scenario(), *run, frame);
            const ColourImage& shown = *run->picture(frame, 1);
            const bool faulty = pairs[static_cast<std::size_t>(frame)] == static_cast<int>(kPair);
            CHECK((differing_pixels(&shown, right) > 0) == faulty);
            CHECK(differs_only_in(shown, right, faulty ? 3 : 1, faulty ? 4 : 0));
        }
    }
}

// ---- anything, anywhere ----

TEST_CASE("one disturbance of a link anywhere in a pair: two pairs later every picture is right again",
          "[system][tmds][faults]") {
    const std::uint64_t seed = random_seed(93);
    INFO("seed " << seed);
    Random random(seed);
    MachineRuns runs;
    for (int i = 0; i < 48; ++i) {
        const FaultKind kind = i % 3 == 0   ? FaultKind::kTmdsBits
                               : i % 3 == 1 ? FaultKind::kTmdsSlip
                                            : FaultKind::kTmdsSkew;
        Fault fault = fault_at(kind, random.one_in(2) ? FrameKind::kColour : FrameKind::kDepth,
                               static_cast<TmdsChannel>(random.between(0, 2)),
                               random.between(0, kHeight + 15), random.between(0, kLineClocks - 1));
        if (kind == FaultKind::kTmdsBits) fault.bits = static_cast<std::uint32_t>(random.between(1, 0x3FF));
        if (kind == FaultKind::kTmdsSlip) fault.late_bits = random.between(1, 9);
        if (kind == FaultKind::kTmdsSkew) fault.late_characters = random.between(1, 4);
        Scenario scenario = two_links(i % 4 == 0 ? Pacing::kFreeRunning : Pacing::kLockstep);
        if (i % 5 == 0) scenario.clocks = {120.0, 70.0, 100.0};
        runs.push_back(
            std::make_unique<MachineRun>("fault_" + std::to_string(i), with_faults(scenario, {fault})));
    }
    REQUIRE(run_to_end(runs));
    for (const auto& run : runs) {
        INFO(describe(run->scenario()));
        const std::vector<int> pairs = pairs_shown(*run);
        const bool lockstep = run->scenario().pacing == Pacing::kLockstep;
        for (int frame = 0; frame < kFrames; ++frame) {
            const int pair = pairs[static_cast<std::size_t>(frame)];
            if (lockstep && frame >= static_cast<int>(kPair) + 2) CHECK(pair == frame);
            if (pair == static_cast<int>(kPair)) continue;
            CHECK(differing_pixels(run->picture(frame, 1), reference(run->scenario(), *run, frame)) == 0);
        }
        for (const auto& renderer : run->report().renderers) {
            CHECK(renderer.total_rejected_frames() <= 2);
        }
        CHECK(run->report().renderers[0].total_rejected_frames() == 0);
    }
}

TEST_CASE("fault tmds_noise: whole pairs are shown, wrong pixels and rejections end with it",
          "[system][tmds][faults]") {
    const std::uint64_t seed = random_seed(94);
    INFO("seed " << seed);
    // Two pairs of frames of 25 lines of 100 clocks, after the sync that a link comes up with.
    constexpr std::int64_t kPairClocks = 2 * 25 * 100;
    MachineRuns runs;
    for (int i = 0; i < 12; ++i) {
        Fault noise;
        noise.kind = FaultKind::kTmdsNoise;
        noise.renderer = 1;
        noise.per_billion = i % 4 == 0 ? 10'000 : i % 4 == 1 ? 100'000 : i % 4 == 2 ? 3'000'000 : 300'000'000;
        noise.seed = seed + static_cast<std::uint64_t>(i);
        noise.from_cycle = 800;
        noise.cycles = 2 * kPairClocks;
        Fault other_link = noise;  // does not begin before the end
        other_link.renderer = 0;
        other_link.from_cycle = 1'000'000'000;
        Scenario scenario = two_links(i < 6 ? Pacing::kLockstep : Pacing::kFreeRunning);
        scenario.frames = 8;
        if (i % 3 == 0) scenario.depth_format = DepthFormat::kZ24;
        runs.push_back(std::make_unique<MachineRun>("noise_" + std::to_string(i),
                                                    with_faults(scenario, {noise, other_link})));
    }
    REQUIRE(run_to_end(runs));
    std::int64_t rejections = 0;
    int wrong_pictures = 0;
    for (const auto& run : runs) {
        INFO(run->machine().name());
        rejections += run->report().renderers[1].total_rejected_frames();
        CHECK(run->report().renderers[1].injected_faults > 0);
        CHECK(run->report().renderers[0].injected_faults == 0);
        CHECK(run->report().renderers[0].total_rejected_frames() == 0);
        CHECK(run->report().renderers[1].bus.pixels_sent > 0);
        for (int frame = 0; frame < 8; ++frame) {
            const bool differs =
                differing_pixels(run->picture(frame, 1), reference(run->scenario(), *run, frame)) > 0;
            wrong_pictures += differs ? 1 : 0;
        }
        // The last pairs have come without noise.
        CHECK(pairs_shown(*run).back() >= 3);
        CHECK(differing_pixels(run->picture(7, 1), reference(run->scenario(), *run, 7)) == 0);
    }
    CHECK(rejections > 0);
    CHECK(wrong_pictures > 0);
}

TEST_CASE("random machines with noise on a link: what is shown is what was received (seeds 94001 on)",
          "[system][tmds][random]") {
    // The monitors compare every pixel after the decoder, and the pairs that frames are made of.
    const std::uint64_t first = random_seed(94'001);
    MachineRuns runs;
    for (std::uint64_t seed = first; seed < first + 10; ++seed) {
        Scenario scenario = random_scenario(seed);
        scenario.links.layer = LinkLayer::kTmds;
        for (int r = 0; r < static_cast<int>(scenario.renderers.size()); r += 2) {
            Fault noise;
            noise.kind = FaultKind::kTmdsNoise;
            noise.renderer = r;
            noise.per_billion = 20'000;
            noise.seed = seed;
            scenario.faults.push_back(noise);
        }
        check_scenario(scenario);
        runs.push_back(std::make_unique<MachineRun>("machine_" + std::to_string(seed), scenario));
    }
    REQUIRE(run_to_end(runs));
    for (const auto& run : runs) {
        INFO(describe(run->scenario()));
        CHECK(run->machine().watchdog_findings().empty());
        CHECK(run->report().frames.size() == static_cast<std::size_t>(run->scenario().frames));
        CHECK(run->monitors().scoreboard().pictures() ==
              std::int64_t{run->scenario().frames} * run->scenario().displays.count());
    }
}

}  // namespace
}  // namespace metabuffer::test::tmds_test
