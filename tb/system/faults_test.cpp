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
    run_to_end(tlm_runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        INFO(describe(runs[i]->scenario()));
        const std::vector<std::string> differences = level_differences(*runs[i], *tlm_runs[i]);
        INFO(first_lines(differences));
        CHECK(differences.empty());
    }
}

using RejectedFrames = std::array<std::int64_t, kRejectCauseCount>;

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

/// The fault, whether its pair is lost, and as what it is counted at the link.
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

/// How many bytes of the control scanline of the faulty renderer's pair have content.
int content_bytes(const Scenario& scenario, std::uint32_t pair, FrameKind frame) {
    const Renderer& renderer = scenario.renderers[kFaultyRenderer];
    return static_cast<int>(control_scanline_bytes(control_content(scenario, renderer, pair, frame)));
}

/// A line of the table: what a fault of a kind does. refine fills in what else the kind needs.
struct KindOfFault {
    FaultKind kind;
    bool loses_pair;
    std::optional<RejectCause> cause;
    void (*refine)(Fault& fault) = [](Fault& /*fault*/) {};
};

bool is_last(const Fault& fault) { return fault.pair == kFrames - 1; }

/// In the table of a colour frame, in the payload of a depth frame.
void change_content(Fault& fault) {
    const int step = fault.frame == FrameKind::kColour ? 7 : 1;
    fault.byte = 16 + step * static_cast<int>(fault.pair);
    fault.bits = 0x40;
}

void change_behind_content(Fault& fault) {
    const int first = content_bytes(two_renderers(kFrames), fault.pair, fault.frame);
    const int last = kImageWidth * kLinkBytesPerPixel - 1;
    REQUIRE(first <= last);
    fault.byte = fault.pair == 0 ? first : last;
    fault.bits = 0xFF;
}

void change_pixel(Fault& fault) {
    fault.x = 9;
    fault.y = 4;
    fault.bits = fault.frame == FrameKind::kColour ? 0x8001FFU : 0x8000FFU;
}

/// Colour and depth frame of the first pair, of one in the middle and of the last; then free-running.
void check_kinds(const std::vector<KindOfFault>& kinds) {
    std::vector<Row> rows;
    MachineRuns runs;
    const auto add = [&](const KindOfFault& of, FrameKind frame, std::uint32_t pair, Pacing pacing) {
        Row& row = rows.emplace_back(Row{make_fault(of.kind, frame, pair), of.loses_pair, of.cause});
        of.refine(row.fault);
        Scenario scenario = with_fault(row.fault);
        scenario.pacing = pacing;
        if (pacing == Pacing::kFreeRunning) scenario.frames = 8 * kFrames;
        runs.push_back(
            std::make_unique<MachineRun>("machine_" + std::to_string(runs.size() + 1), std::move(scenario)));
    };
    for (const KindOfFault& kind : kinds) {
        for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
            for (const std::uint32_t pair : {0U, 1U, kFrames - 1U}) add(kind, frame, pair, Pacing::kLockstep);
            add(kind, frame, 1, Pacing::kFreeRunning);
        }
    }
    run_traced(runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const Fault& fault = rows[i].fault;
        INFO("fault " << to_string(fault.kind) << " in the " << to_string(fault.frame) << " frame of pair "
                      << fault.pair << ", " << to_string(runs[i]->scenario().pacing));
        if (runs[i]->scenario().pacing == Pacing::kLockstep) {
            check_lockstep(*runs[i], rows[i]);
        } else {
            check_free_running(*runs[i], rows[i]);
        }
    }
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

TEST_CASE("faults of a control scanline or a pixel: what is counted and shown", "[system][faults]") {
    check_kinds({{FaultKind::kMagic, true, RejectCause::kMagic},
                 {FaultKind::kOtherPair, true, RejectCause::kPair},
                 {FaultKind::kControlByte, true, RejectCause::kCrc, change_content},
                 {FaultKind::kControlByte, false, std::nullopt, change_behind_content},
                 {FaultKind::kPixelBits, false, std::nullopt, change_pixel}});
}

TEST_CASE("faults of the frames that are sent: what is counted and shown", "[system][faults]") {
    check_kinds({{FaultKind::kMissing, true, RejectCause::kPair},
                 {FaultKind::kRepeated, false, RejectCause::kPair},
                 // The last pair keeps nothing but its control scanline.
                 {FaultKind::kShortFrame, true, RejectCause::kGeometry,
                  [](Fault& fault) {
                      fault.lines = is_last(fault) ? kImageHeight : 1 + static_cast<int>(fault.pair);
                  }},
                 {FaultKind::kLongFrame, true, RejectCause::kGeometry, [](Fault& fault) {
                      fault.lines = fault.pair == 1 ? kImageHeight : 1 + static_cast<int>(fault.pair);
                  }}});
}

TEST_CASE("more faults of frames: what is counted and shown", "[system][faults][repeat]") {
    check_kinds({{FaultKind::kVersion, true, RejectCause::kVersion},
                 {FaultKind::kKind, true, RejectCause::kKind},
                 {FaultKind::kCrc, true, RejectCause::kCrc},
                 {FaultKind::kNumber, true, RejectCause::kPair},
                 {FaultKind::kShortLine, true, RejectCause::kGeometry},
                 {FaultKind::kLongLine, true, RejectCause::kGeometry}});
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

TEST_CASE("a silence longer than the timeout costs its pair, wherever it is", "[system][faults]") {
    struct Case {
        std::uint32_t pair;
        int before;  ///< the pair that is shown instead
    };
    const std::vector<Case> cases{{0, -1}, {1, 0}, {kFrames - 1, kFrames - 2}};
    MachineRuns runs;
    for (const Case& one : cases) {
        for (const FrameKind frame : {FrameKind::kColour, FrameKind::kDepth}) {
            runs.push_back(std::make_unique<MachineRun>("machine_" + std::to_string(runs.size()),
                                                        with_fault(FaultKind::kDelay, frame, one.pair, 3)));
        }
    }
    run_traced(runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const Case& one = cases[i / 2];
        INFO("pair " << one.pair << ", " << (i % 2 == 0 ? "colour" : "depth"));
        check_machine(*runs[i]);
        const std::vector<int> pairs = pairs_of(*runs[i], 0);
        CHECK(pairs[one.pair] == one.before);
        CHECK(pairs.back() >= 2);
        CHECK(pairs_of(*runs[i], 1) == std::vector<int>{0, 1, 2, 3});
        CHECK(faulty(*runs[i]).rejected_frames == RejectedFrames{});
        CHECK(faulty(*runs[i]).repeated_frames >= 1);
        if (one.pair == kFrames - 1) CHECK(faulty(*runs[i]).repeated_frames == 1);
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
