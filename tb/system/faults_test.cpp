#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "functional/functional_compositor.h"
#include "host/errors.h"
#include "machine_checks.h"
#include "machine_run.h"
#include "random_scenario.h"
#include "scenario/fault_keys.h"
#include "scenario/link_program.h"
#include "scenario/names.h"
#include "scenario/scenario_loader.h"
#include "support/images.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "support/trace_switch.h"
#include "tlm_run.h"

namespace metabuffer::test::faults_test {

namespace {

constexpr int kFrames = 4;
constexpr int kImageWidth = 24;
constexpr int kImageHeight = 10;
constexpr int kFaultyRenderer = 0;  // index
/// Every kind of fault that costs its pair, and a silence longer than the timeout.
constexpr FaultKind kFaultKinds[] = {FaultKind::kMagic,    FaultKind::kVersion,    FaultKind::kKind,
                                     FaultKind::kCrc,      FaultKind::kNumber,     FaultKind::kShortLine,
                                     FaultKind::kLongLine, FaultKind::kShortFrame, FaultKind::kLongFrame,
                                     FaultKind::kMissing,  FaultKind::kDelay,      FaultKind::kOtherPair};

/// Two displays, and two renderers whose pairs each have their own image, so that a picture made of parts of two pairs
/// cannot pass for a good one. The bus is wide: nothing starves.
Scenario two_renderers(int different_pairs) {
    Random random(2026);
    Scenario scenario = small_scenario(14, 12, 2);
    scenario.name = "faults";
    scenario.memory.words_per_cycle = 4;
    scenario.bus.width_bits = 256;
    scenario.frames = kFrames;
    for (int r = 0; r < 2; ++r) {
        std::vector<PixelImage> images;
        std::vector<Viewport> viewports;
        for (int pair = 0; pair < different_pairs; ++pair) {
            images.push_back(opaque_noise_image(random, kImageWidth, kImageHeight));
            viewports.push_back(Viewport{2 + (pair + r) % 3, 1 + pair % 2, 1});
        }
        add_renderer(scenario, renderer_of(images, viewports, scenario.displays.wall()));
    }
    check_scenario(scenario);
    return scenario;
}

Scenario with_fault(const Fault& fault) { return test::with_fault(two_renderers(kFrames), fault); }

Fault make_fault(FaultKind kind, FrameKind frame, std::uint32_t pair) {
    Fault fault;
    fault.renderer = kFaultyRenderer;
    fault.kind = kind;
    fault.frame = frame;
    fault.pair = pair;
    return fault;
}

Scenario with_fault(FaultKind kind, FrameKind frame, std::uint32_t pair, int delay_pairs) {
    Fault fault = make_fault(kind, frame, pair);
    fault.delay_pairs = kind == FaultKind::kDelay ? delay_pairs : 0;
    return with_fault(fault);
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

/// The cause under which the decoder counts a fault; none if no frame itself is faulty.
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
        case FaultKind::kOtherPair:
        case FaultKind::kRepeated:
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

/// What holds for a machine with a fault as for any other: whole pictures of whole pairs, on every display. The other
/// renderer goes on in step.
void check_machine(const MachineRun& run) {
    const Fault& fault = run.scenario().faults.at(0);
    INFO("fault " << to_string(fault.kind) << " in the " << to_string(fault.frame) << " frame of pair "
                  << fault.pair);
    check_run(run);
    CHECK(run.report().total_starved_pixels() == 0);
    const RendererCounters& other = run.report().renderers[1 - kFaultyRenderer];
    CHECK(other.rejected_frames == RejectedFrames{});
}

// ---- the table of docs/faults.md, row by row ----

/// What a row of the table says: the fault, whether its pair is lost, and as what it is counted at the link.
struct Row {
    Fault fault;
    bool loses_pair = true;
    std::optional<RejectCause> cause;
};

std::vector<int> expected_pairs(const Row& row) {
    std::vector<int> pairs{0, 1, 2, 3};
    const auto pair = static_cast<int>(row.fault.pair);
    if (row.loses_pair) pairs[row.fault.pair] = pair - 1;
    return pairs;
}

/// Nothing shows that a frame is missing if none came before it or none comes after it.
bool may_go_unnoticed(const Fault& fault) {
    if (fault.kind != FaultKind::kMissing) return false;
    return fault.frame == FrameKind::kColour ? fault.pair == 0 : fault.pair == kFrames - 1;
}

/// In lockstep: the fault's pair is lost or not, as the row says, and no other; the last good one stays.
void check_lockstep(const MachineRun& run, const Row& row) {
    RejectedFrames rejected{};
    if (row.cause) rejected[static_cast<std::size_t>(*row.cause)] = 1;
    check_machine(run);
    CHECK(pairs_of(run, 0) == expected_pairs(row));
    CHECK(pairs_of(run, 1) == std::vector<int>{0, 1, 2, 3});
    CHECK(faulty(run).repeated_frames == (row.loses_pair ? 1 : 0));
    CHECK(faulty(run).dropped_frames == 0);
    CHECK(faulty(run).injected_faults == 1);
    CHECK(run.report().renderers[1].injected_faults == 0);
    if (may_go_unnoticed(row.fault)) rejected = RejectedFrames{};
    CHECK(faulty(run).rejected_frames == rejected);
}

/// The first pair after `pair` that is shown.
int next_pair_shown(const MachineRun& run, int pair) {
    const std::vector<int> pairs = pairs_of(run, 0);
    const auto next = std::find_if(pairs.begin(), pairs.end(), [pair](int shown) { return shown > pair; });
    REQUIRE(next != pairs.end());
    return *next;
}

/// Free-running: a lost pair is never shown, and a newer one is within two good pairs.
void check_free_running(const MachineRun& run, const Row& row) {
    check_machine(run);
    const auto lost = static_cast<int>(row.fault.pair);
    for (const int pair : pairs_of(run, 0)) {
        if (row.loses_pair) CHECK(pair != lost);
    }
    CHECK(faulty(run).injected_faults == 1);
    CHECK(next_pair_shown(run, lost) <= lost + 2);
}

/// Colour and depth frame of the first pair, of one in the middle and of the last; then free-running.
/// `refine` fills in what else the kind needs.
template <typename Refine>
void check_row(FaultKind kind, const Row& row, Refine refine) {
    std::vector<Row> rows;
    MachineRuns runs;
    const auto add = [&](FrameKind frame, std::uint32_t pair, Pacing pacing) {
        Row& one = rows.emplace_back(row);
        one.fault = make_fault(kind, frame, pair);
        refine(one);
        Scenario scenario = with_fault(one.fault);
        scenario.pacing = pacing;
        if (pacing == Pacing::kFreeRunning) scenario.frames = 8 * kFrames;
        runs.push_back(
            std::make_unique<MachineRun>("machine_" + std::to_string(runs.size() + 1), std::move(scenario)));
    };
    for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
        for (const std::uint32_t pair : {0U, 1U, kFrames - 1U}) add(frame, pair, Pacing::kLockstep);
        add(frame, 1, Pacing::kFreeRunning);
    }
    run_traced(runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO("fault " << to_string(kind) << " in the " << to_string(rows[i].fault.frame) << " frame of pair "
                      << rows[i].fault.pair << ", " << to_string(runs[i]->scenario().pacing));
        if (runs[i]->scenario().pacing == Pacing::kLockstep) {
            check_lockstep(*runs[i], rows[i]);
        } else {
            check_free_running(*runs[i], rows[i]);
        }
    }
}

void check_row(FaultKind kind) {
    check_row(kind, {{}, true, cause_of(kind)}, [](Row& /*row*/) {});
}

/// How many bytes of the control scanline of the faulty renderer's pair have content.
int content_bytes(const Scenario& scenario, std::uint32_t pair, FrameKind frame) {
    const Renderer& renderer = scenario.renderers[kFaultyRenderer];
    return static_cast<int>(control_scanline_bytes(control_content(scenario, renderer, pair, frame)));
}

/// Eight bad pairs for each byte of the control scanline, one for each bit, then a good one. Images of one line make
/// short pairs.
Scenario with_every_bit_flipped(FrameKind frame, int bits, int width) {
    Scenario scenario = small_scenario(4, 1);
    scenario.name = "bytes";
    scenario.clocks.dvi_in_mhz = 200.0;
    const ViewportTable table{{1, 0, 0, 4, 1, 0, 0, 1}, {7, 1, 0, 4, 1, 0, 0, 1}, {9, 2, 0, 4, 1, 0, 0, 1}};
    scenario.renderers.push_back(renderer_of({noise_image(7, width, 1)}, table));
    std::uint32_t pair = 0;
    for (int byte = 0; byte < width * kLinkBytesPerPixel; ++byte, ++pair) {
        for (int bit = 0; bit < bits; ++bit, ++pair) {
            Fault fault = make_fault(FaultKind::kControlByte, frame, pair);
            fault.byte = byte;
            fault.bits = 1U << bit;
            scenario.faults.push_back(fault);
        }
    }
    scenario.frames = static_cast<int>(pair);
    check_scenario(scenario);
    return scenario;
}

void check_every_bit(FrameKind frame) {
    constexpr int kBits = 8;
    constexpr int kWidth = 24;
    MachineRuns runs;
    runs.push_back(std::make_unique<MachineRun>("machine", with_every_bit_flipped(frame, kBits, kWidth)));
    run_traced(runs);
    const MachineRun& run = *runs[0];
    const int content = content_bytes(run.scenario(), 0, frame);
    // A colour frame has three rows. A depth frame has the slot table of the one valid row: a bit for each slot, in one
    // byte.
    REQUIRE(content == 16 + 2 + (frame == FrameKind::kColour ? 3 * 16 : 4 + 1));
    const std::vector<int> pairs = pairs_of(run, 0);
    int last_good = -1;
    for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
        const int byte = static_cast<int>(pair) / (kBits + 1);
        const bool is_good = byte >= content || pair % (kBits + 1) == kBits;
        if (is_good) last_good = static_cast<int>(pair);
        INFO("byte " << byte << ", pair " << pair);
        REQUIRE(pairs[pair] == last_good);
    }
    RejectedFrames rejected{};
    rejected[static_cast<std::size_t>(RejectCause::kMagic)] = std::int64_t{4} * kBits;
    rejected[static_cast<std::size_t>(RejectCause::kVersion)] = kBits;
    rejected[static_cast<std::size_t>(RejectCause::kCrc)] = std::int64_t{content - 5} * kBits;
    CHECK(faulty(run).rejected_frames == rejected);
    CHECK(faulty(run).injected_faults == std::int64_t{kWidth} * kLinkBytesPerPixel * kBits);
}

}  // namespace

TEST_CASE("fault magic: the frame is rejected and its pair replaced by the last good one",
          "[system][faults]") {
    check_row(FaultKind::kMagic);
}

TEST_CASE("fault version: the frame is rejected and its pair replaced by the last good one",
          "[system][faults][repeat]") {
    check_row(FaultKind::kVersion);
}

TEST_CASE("fault kind: the frame is rejected and its pair replaced by the last good one",
          "[system][faults][repeat]") {
    check_row(FaultKind::kKind);
}

TEST_CASE("fault crc: the frame is rejected and its pair replaced by the last good one",
          "[system][faults][repeat]") {
    check_row(FaultKind::kCrc);
}

TEST_CASE("fault number: the pair's frames do not match and it is replaced by the last good one",
          "[system][faults][repeat]") {
    check_row(FaultKind::kNumber);
}

TEST_CASE("fault other_pair: the pair's frames do not match and it is replaced by the last good one",
          "[system][faults]") {
    check_row(FaultKind::kOtherPair);
}

TEST_CASE("fault short_line: the frame is rejected and its pair replaced by the last good one",
          "[system][faults][repeat]") {
    check_row(FaultKind::kShortLine);
}

TEST_CASE("fault long_line: the frame is rejected and its pair replaced by the last good one",
          "[system][faults][repeat]") {
    check_row(FaultKind::kLongLine);
}

TEST_CASE("fault short_frame: the frame is rejected however many lines are missing", "[system][faults]") {
    // The last pair keeps nothing but its control scanline.
    check_row(FaultKind::kShortFrame, {{}, true, RejectCause::kGeometry}, [](Row& row) {
        row.fault.lines = row.fault.pair == kFrames - 1 ? kImageHeight : 1 + static_cast<int>(row.fault.pair);
    });
}

TEST_CASE("fault long_frame: the frame is rejected however many lines are too many", "[system][faults]") {
    check_row(FaultKind::kLongFrame, {{}, true, RejectCause::kGeometry}, [](Row& row) {
        row.fault.lines = row.fault.pair == 1 ? kImageHeight : 1 + static_cast<int>(row.fault.pair);
    });
}

TEST_CASE("fault missing: the pair is replaced by the last good one", "[system][faults]") {
    check_row(FaultKind::kMissing);
}

TEST_CASE("fault repeated: the second sending is counted and costs nothing", "[system][faults]") {
    check_row(FaultKind::kRepeated, {{}, false, RejectCause::kPair}, [](Row& /*row*/) {});
}

TEST_CASE("fault control_byte: a changed byte of the content costs its pair", "[system][faults]") {
    check_row(FaultKind::kControlByte, {{}, true, RejectCause::kCrc}, [](Row& row) {
        // In the table of a colour frame, in the payload of a depth frame.
        const int step = row.fault.frame == FrameKind::kColour ? 7 : 1;
        row.fault.byte = 16 + step * static_cast<int>(row.fault.pair);
        row.fault.bits = 0x40;
    });
}

TEST_CASE("fault control_byte: a changed byte behind the content changes nothing", "[system][faults]") {
    const Scenario scenario = two_renderers(kFrames);
    check_row(FaultKind::kControlByte, {{}, false, std::nullopt}, [&](Row& row) {
        const int first = content_bytes(scenario, row.fault.pair, row.fault.frame);
        const int last = kImageWidth * kLinkBytesPerPixel - 1;
        REQUIRE(first <= last);
        row.fault.byte = row.fault.pair == 0 ? first : last;
        row.fault.bits = 0xFF;
    });
}

TEST_CASE(
    "fault control_byte: every bit of every byte of a colour frame's content costs its pair and no other",
    "[system][faults]") {
    check_every_bit(FrameKind::kColour);
}

TEST_CASE(
    "fault control_byte: every bit of every byte of a depth frame's content costs its pair and no other",
    "[system][faults][repeat]") {
    check_every_bit(FrameKind::kDepth);
}

TEST_CASE("fault pixel_bits: the pair is shown with just that pixel changed", "[system][faults]") {
    constexpr int kX = 9;
    constexpr int kY = 4;
    check_row(FaultKind::kPixelBits, {{}, false, std::nullopt}, [](Row& row) {
        row.fault.x = kX;
        row.fault.y = kY;
        row.fault.bits = row.fault.frame == FrameKind::kColour ? 0x8001FFU : 0x8000FFU;
    });
}

TEST_CASE("fault pixel_bits: the picture is that of an image with the pixel so in its file",
          "[system][faults]") {
    struct Case {
        FrameKind frame;
        DepthFormat format;
        std::uint32_t bits;
        Pixel (*changed)(Pixel);
    };
    const std::vector<Case> cases{
        {FrameKind::kColour, DepthFormat::kA8Z16, 0x80'01'FF,
         [](Pixel p) {
             return Pixel(static_cast<std::uint8_t>(p.r() ^ 0x80), static_cast<std::uint8_t>(p.g() ^ 0x01),
                          static_cast<std::uint8_t>(p.b() ^ 0xFF), p.a(), p.z());
         }},
        {FrameKind::kDepth, DepthFormat::kA8Z16, 0x40'00'FF,
         [](Pixel p) {
             return Pixel(p.r(), p.g(), p.b(), static_cast<std::uint8_t>(p.a() ^ 0x40), p.z() ^ 0xFF);
         }},
        {FrameKind::kDepth, DepthFormat::kZ24, 0x80'00'01,
         [](Pixel p) { return Pixel(p.r(), p.g(), p.b(), 255, p.z() ^ 0x800001); }},
    };
    constexpr int kX = 9;
    constexpr int kY = 4;
    constexpr std::uint32_t kPair = 2;
    MachineRuns runs;
    std::vector<Scenario> wanted;
    for (const Case& one : cases) {
        Scenario scenario = two_renderers(kFrames);
        scenario.composition = Composition::kOver;  // so that alpha shows
        scenario.depth_format = one.format;
        wanted.push_back(scenario);
        std::shared_ptr<const StoredImage>& image = wanted.back().renderers[kFaultyRenderer].images[kPair];
        PixelImage changed = image->pixels();
        changed.at(kX, kY) = one.changed(changed.at(kX, kY));
        image = std::make_shared<const StoredImage>(changed);
        Fault fault = make_fault(FaultKind::kPixelBits, one.frame, kPair);
        fault.x = kX;
        fault.y = kY;
        fault.bits = one.bits;
        scenario.faults.push_back(fault);
        check_scenario(scenario);
        runs.push_back(
            std::make_unique<MachineRun>("machine_" + std::to_string(runs.size()), std::move(scenario)));
    }
    run_traced(runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO("case " << i);
        Scenario healthy = runs[i]->scenario();
        healthy.faults.clear();
        int changed_pictures = 0;
        for (int frame = 0; frame < kFrames; ++frame) {
            const auto pairs = std::vector<int>(2, frame);
            for (int display = 1; display <= 2; ++display) {
                INFO("frame " << frame << " on display " << display);
                const ColourImage expected = functional::composite_display(
                    wanted[i], functional::contributions_of(wanted[i], pairs), display);
                const ColourImage before = functional::composite_display(
                    healthy, functional::contributions_of(healthy, pairs), display);
                const ColourImage* shown = runs[i]->picture(frame, display);
                REQUIRE(shown != nullptr);
                CHECK(shown->values == expected.values);
                if (expected.values == before.values) continue;
                ++changed_pictures;
                CHECK(frame == static_cast<int>(kPair));
            }
        }
        CHECK(changed_pictures == 1);
    }
}

TEST_CASE(
    "fault delay: in lockstep frames go on without the pair and the first one after the silence has its own",
    "[system][faults][repeat]") {
    constexpr int kPair = 2;
    constexpr int kLongest = 7;
    MachineRuns runs;
    for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
        for (int delay = 1; delay <= kLongest; ++delay) {
            Scenario scenario = two_renderers(kLongest + 6);
            scenario.frames = kLongest + 6;
            Fault fault = make_fault(FaultKind::kDelay, frame, kPair);
            fault.delay_pairs = delay;
            scenario.faults.push_back(fault);
            check_scenario(scenario);
            runs.push_back(std::make_unique<MachineRun>(
                std::string(to_string(frame)) + "_" + std::to_string(delay), std::move(scenario)));
        }
    }
    run_traced(runs);
    for (const auto& run : runs) {
        const Fault& fault = run->scenario().faults[0];
        INFO(fault.delay_pairs << " pair times before the " << to_string(fault.frame) << " frame");
        check_machine(*run);
        CHECK(faulty(*run).injected_faults == 1);
        CHECK(faulty(*run).rejected_frames == RejectedFrames{});
        const std::vector<int> pairs = pairs_of(*run, 0);
        int without = 0;
        for (std::size_t frame = 0; frame < pairs.size(); ++frame) {
            INFO("frame " << frame);
            const bool gone_without = pairs[frame] != static_cast<int>(frame);
            without += gone_without ? 1 : 0;
            if (gone_without) CHECK(pairs[frame] == kPair - 1);  // the last good picture stays
            // Frames without the pair are consecutive: once it is back, each frame has its own pair.
            if (gone_without) CHECK(static_cast<int>(frame) == kPair - 1 + without);
        }
        // A frame is given up every two pair times.
        CHECK(without >= (fault.delay_pairs + 1) / 2 - 1);
        CHECK(without <= fault.delay_pairs / 2 + 1);
        CHECK((without == 0) == (fault.delay_pairs < run->scenario().link_timeout_pairs));
        CHECK(faulty(*run).repeated_frames == without);
        CHECK(faulty(*run).dropped_frames == without);  // they come all the same, too late
    }
}

TEST_CASE("fault delay: free-running the last good pair stays until the late one or the next is whole",
          "[system][faults]") {
    constexpr int kPair = 2;
    MachineRuns runs;
    for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
        for (const int delay : {1, 2, 5}) {
            Scenario scenario = two_renderers(kFrames);
            scenario.pacing = Pacing::kFreeRunning;
            scenario.frames = 60;
            Fault fault = make_fault(FaultKind::kDelay, frame, kPair);
            fault.delay_pairs = delay;
            scenario.faults.push_back(fault);
            check_scenario(scenario);
            runs.push_back(std::make_unique<MachineRun>(
                std::string(to_string(frame)) + "_" + std::to_string(delay), std::move(scenario)));
        }
    }
    run_traced(runs);
    for (const auto& run : runs) {
        const Fault& fault = run->scenario().faults[0];
        INFO(fault.delay_pairs << " pair times before the " << to_string(fault.frame) << " frame");
        check_machine(*run);
        CHECK(faulty(*run).injected_faults == 1);
        const std::vector<int> pairs = pairs_of(*run, 0);
        const auto shown = [&pairs](int pair) { return std::count(pairs.begin(), pairs.end(), pair); };
        CHECK(shown(kPair - 1) > shown(kPair + 1));
        CHECK(next_pair_shown(*run, kPair - 1) <= kPair + 1);
    }
}

TEST_CASE("level tlm refuses faults that happen clock by clock and names the level that has them",
          "[system][faults]") {
    for (const auto& kind : EnumNames<FaultKind>::kTable) {
        INFO(kind.name);
        Scenario scenario = two_renderers(kFrames);
        Fault fault;
        fault.kind = kind.value;
        scenario.faults = {fault};
        std::string error;
        try {
            const TlmRun run(kind.name, scenario);
        } catch (const InputError& refused) {
            error = refused.what();
        }
        CHECK(error == (fault_traits(kind.value).only_at_level_rtl()
                            ? std::string("faults[0].kind: ") + kind.name +
                                  " happens clock by clock, which level tlm does not know; use --level rtl"
                            : std::string()));
    }
}

TEST_CASE("several faults in one frame are one rejection and cost one pair", "[system][faults]") {
    struct Case {
        std::vector<FaultKind> kinds;
        RejectCause cause;
    };
    const std::vector<Case> cases{
        {{FaultKind::kCrc, FaultKind::kShortFrame}, RejectCause::kCrc},
        {{FaultKind::kMagic, FaultKind::kCrc, FaultKind::kKind}, RejectCause::kMagic},
        {{FaultKind::kKind, FaultKind::kLongLine}, RejectCause::kKind},
        {{FaultKind::kShortLine, FaultKind::kLongFrame}, RejectCause::kGeometry},
        {{FaultKind::kPixelBits, FaultKind::kShortLine}, RejectCause::kGeometry},
        {{FaultKind::kDelay, FaultKind::kVersion}, RejectCause::kVersion},
    };
    MachineRuns runs;
    for (const Case& one : cases) {
        for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
            Scenario scenario = two_renderers(kFrames);
            for (const FaultKind kind : one.kinds) {
                Fault fault = make_fault(kind, frame, 1);
                if (kind == FaultKind::kPixelBits) fault.bits = 1;
                if (kind == FaultKind::kDelay) fault.delay_pairs = 1;
                scenario.faults.push_back(fault);
            }
            check_scenario(scenario);
            runs.push_back(
                std::make_unique<MachineRun>("machine_" + std::to_string(runs.size()), std::move(scenario)));
        }
    }
    run_traced(runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const Case& one = cases[i / 2];
        INFO("case " << i / 2 << ", " << (i % 2 == 0 ? "colour" : "depth"));
        check_machine(*runs[i]);
        RejectedFrames rejected{};
        rejected[static_cast<std::size_t>(one.cause)] = 1;
        CHECK(faulty(*runs[i]).rejected_frames == rejected);
        CHECK(pairs_of(*runs[i], 0) == std::vector<int>{0, 0, 2, 3});
        CHECK(faulty(*runs[i]).injected_faults == static_cast<std::int64_t>(one.kinds.size()));
    }
}

TEST_CASE("a frame with faults that is sent again is rejected again", "[system][faults]") {
    MachineRuns runs;
    for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
        Scenario scenario = with_fault(make_fault(FaultKind::kCrc, frame, 1));
        scenario.faults.push_back(make_fault(FaultKind::kRepeated, frame, 1));
        check_scenario(scenario);
        runs.push_back(std::make_unique<MachineRun>(to_string(frame), std::move(scenario)));
    }
    run_traced(runs);
    for (const auto& run : runs) {
        check_machine(*run);
        RejectedFrames rejected{};
        rejected[static_cast<std::size_t>(RejectCause::kCrc)] = 2;
        CHECK(faulty(*run).rejected_frames == rejected);
        CHECK(pairs_of(*run, 0) == std::vector<int>{0, 0, 2, 3});
        CHECK(faulty(*run).injected_faults == 2);  // the fault of the frame and its second sending
    }
}

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

TEST_CASE("a renderer without a good pair yet contributes an empty table", "[system][faults][repeat]") {
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
        // A link that begins with a depth frame has not begun: the decoder waits for a colour frame.
        const bool never_noticed = fault.kind == FaultKind::kMissing && fault.frame == FrameKind::kColour;
        CHECK(faulty(*run).rejected_frames == (never_noticed ? RejectedFrames{} : one_rejection(fault.kind)));
    }
}

TEST_CASE("the last pair's fault leaves the last good pair on the displays", "[system][faults][repeat]") {
    MachineRuns runs = machines_with_faults(kFrames - 1, 3, Pacing::kLockstep);
    run_traced(runs);
    for (const auto& run : runs) {
        const Fault& fault = run->scenario().faults[0];
        INFO("fault " << to_string(fault.kind) << " in the " << to_string(fault.frame) << " frame");
        check_machine(*run);
        CHECK(pairs_of(*run, 0) == std::vector<int>{0, 1, 2, 2});
        CHECK(faulty(*run).repeated_frames == 1);
        // Nothing follows a depth frame that is not sent: only the timeout shows it.
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
            // Frames 1 and 2 are asked for as soon as the buffers have received what is before them, perhaps before
            // there is another pair. From then on many pairs pass in each frame, and each frame shows a newer one.
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

}  // namespace metabuffer::test::faults_test
