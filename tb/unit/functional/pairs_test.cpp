#include <catch2/catch.hpp>
#include <vector>

#include "functional/functional_compositor.h"
#include "support/scenarios.h"

using namespace metabuffer;
using functional::contributions_of;
using functional::pairs_without_time;

namespace {

using Pairs = std::vector<std::vector<int>>;

/// Two renderers; faults are given to the second.
Scenario four_frames(const std::vector<Fault>& faults) {
    Scenario scenario;
    scenario.frames = 4;
    scenario.renderers.resize(2);
    for (Renderer& renderer : scenario.renderers) renderer.frames.emplace_back();
    scenario.faults = faults;
    return scenario;
}

Fault fault(FaultKind kind, std::uint32_t pair, FrameKind frame = FrameKind::kColour, int delay_pairs = 0) {
    return {1, pair, kind, frame, delay_pairs};
}

const Pairs kUndisturbed{{0, 0}, {1, 1}, {2, 2}, {3, 3}};

}  // namespace

TEST_CASE("a faulty pair is replaced by the last good one", "[functional][pairs]") {
    CHECK(pairs_without_time(four_frames({})) == kUndisturbed);
    CHECK(pairs_without_time(four_frames({fault(FaultKind::kCrc, 3), fault(FaultKind::kMagic, 1),
                                          fault(FaultKind::kMissing, 2, FrameKind::kDepth)})) ==
          Pairs{{0, 0}, {1, 0}, {2, 0}, {3, 0}});
    CHECK(pairs_without_time(four_frames({fault(FaultKind::kCrc, 0), fault(FaultKind::kCrc, 1)})) ==
          Pairs{{0, -1}, {1, -1}, {2, 2}, {3, 3}});
    CHECK(pairs_without_time(four_frames({fault(FaultKind::kCrc, 4)})) == kUndisturbed);
    const auto kind =
        GENERATE(FaultKind::kMagic, FaultKind::kVersion, FaultKind::kKind, FaultKind::kCrc,
                 FaultKind::kNumber, FaultKind::kShortLine, FaultKind::kLongLine, FaultKind::kShortFrame,
                 FaultKind::kLongFrame, FaultKind::kMissing, FaultKind::kOtherPair);
    const auto frame = GENERATE(FrameKind::kColour, FrameKind::kDepth);
    const auto pacing = GENERATE(Pacing::kLockstep, Pacing::kFreeRunning);
    INFO("fault kind " << static_cast<int>(kind) << ", frame " << static_cast<int>(frame));

    Scenario scenario = four_frames({fault(kind, 2, frame)});
    scenario.pacing = pacing;
    CHECK(pairs_without_time(scenario) == Pairs{{0, 0}, {1, 1}, {2, 1}, {3, 3}});

    scenario = four_frames({fault(kind, 0, frame)});
    scenario.pacing = pacing;
    CHECK(pairs_without_time(scenario) == Pairs{{0, -1}, {1, 1}, {2, 2}, {3, 3}});
}

TEST_CASE("faults that change no picture or only pixels lose no pair", "[functional][pairs]") {
    const auto kind =
        GENERATE(FaultKind::kRepeated, FaultKind::kPixelBits, FaultKind::kDrift, FaultKind::kBusreadyLow,
                 FaultKind::kPipereadyLow, FaultKind::kLostBeat, FaultKind::kRandomStalls,
                 FaultKind::kTmdsBits, FaultKind::kTmdsSlip, FaultKind::kTmdsSkew, FaultKind::kTmdsNoise);
    const auto frame = GENERATE(FrameKind::kColour, FrameKind::kDepth);
    for (const std::uint32_t pair : {0U, 2U}) {
        CHECK(pairs_without_time(four_frames({fault(kind, pair, frame)})) == kUndisturbed);
    }
}

TEST_CASE("a byte of the control scanline loses the pair if it belongs to the content",
          "[functional][pairs]") {
    constexpr int kRows = 3;
    constexpr int kContentBytes = 16 + 16 * kRows + 2;
    Fault byte = fault(FaultKind::kControlByte, 2);
    byte.bits = 1;
    for (const int index : {0, 4, 5, 8, 15, 16, kContentBytes - 1, kContentBytes}) {
        INFO("byte " << index);
        byte.byte = index;
        Scenario scenario = four_frames({byte});
        scenario.renderers[1].frames.resize(3);
        scenario.renderers[1].frames[2].table.resize(kRows);
        const bool lost = index < kContentBytes;
        CHECK(pairs_without_time(scenario) == (lost ? Pairs{{0, 0}, {1, 1}, {2, 1}, {3, 3}} : kUndisturbed));
    }
}

TEST_CASE("a delay loses the pair only beyond the link timeout, a repeated frame's time included",
          "[functional][pairs]") {
    const Pairs lost{{0, 0}, {1, 0}, {2, 2}, {3, 3}};
    Scenario scenario = four_frames({fault(FaultKind::kDelay, 1, FrameKind::kDepth, 1)});
    scenario.link_timeout_pairs = 2;
    CHECK(pairs_without_time(scenario) == kUndisturbed);
    scenario.faults.push_back(fault(FaultKind::kRepeated, 1));
    CHECK(pairs_without_time(scenario) == lost);
    scenario.faults[0].frame = FrameKind::kColour;  // the colour frame comes in time, and the pair goes on
    CHECK(pairs_without_time(scenario) == kUndisturbed);
    scenario = four_frames({fault(FaultKind::kDelay, 1, FrameKind::kColour, 1)});
    scenario.link_timeout_pairs = 2;
    CHECK(pairs_without_time(scenario) == kUndisturbed);
    scenario.link_timeout_pairs = 1;
    CHECK(pairs_without_time(scenario) == lost);

    scenario.faults = {fault(FaultKind::kDelay, 1, FrameKind::kDepth, 2)};
    scenario.link_timeout_pairs = 3;
    CHECK(pairs_without_time(scenario) == kUndisturbed);
    scenario.link_timeout_pairs = 2;
    CHECK(pairs_without_time(scenario) == lost);

    SECTION("the delays before both frames of a pair add up") {
        scenario.faults = {fault(FaultKind::kDelay, 1, FrameKind::kColour, 1),
                           fault(FaultKind::kDelay, 1, FrameKind::kDepth, 1)};
        CHECK(pairs_without_time(scenario) == lost);
        scenario.link_timeout_pairs = 3;
        CHECK(pairs_without_time(scenario) == kUndisturbed);
    }
    SECTION("a harmless delay does not excuse another fault") {
        scenario.faults = {fault(FaultKind::kDelay, 1, FrameKind::kColour, 1), fault(FaultKind::kCrc, 1)};
        CHECK(pairs_without_time(scenario) == lost);
    }
}

TEST_CASE("flipped bits are contributed in the pair's own image and in no other", "[functional][pairs]") {
    Scenario scenario = test::small_scenario(4, 4);
    const Renderer renderer = test::renderer_of({PixelImage(4, 4, Pixel(0x10, 0x20, 0x30, 0x40, 0x5060))});
    scenario.renderers = {renderer, renderer};
    const auto pixel_of = [&scenario](int pair) {
        const functional::Contribution contribution = contributions_of(scenario, {pair, pair})[1];
        CHECK(contribution.image->at(2, 2) == Pixel(0x10, 0x20, 0x30, 0x40, 0x5060));
        return contribution.image->at(1, 3);
    };
    Fault bits = fault(FaultKind::kPixelBits, 2);
    bits.x = 1;
    bits.y = 3;
    bits.bits = 0x0F'F0'01;
    scenario.faults = {bits};
    CHECK(pixel_of(2) == Pixel(0x1F, 0xD0, 0x31, 0x40, 0x5060));
    CHECK(pixel_of(1) == Pixel(0x10, 0x20, 0x30, 0x40, 0x5060));
    CHECK(contributions_of(scenario, {2, 2})[0].image == &scenario.renderers[0].images[0]->pixels());
    bits.frame = FrameKind::kDepth;
    scenario.faults = {bits};
    CHECK(pixel_of(2) == Pixel(0x10, 0x20, 0x30, 0x4F, 0xA061));
    scenario.depth_format = DepthFormat::kZ24;
    CHECK(pixel_of(2) == Pixel(0x10, 0x20, 0x30, 0x40, 0x0FA061));
    // Both frames' flips meet in one image.
    bits.frame = FrameKind::kColour;
    scenario.faults.push_back(bits);
    CHECK(pixel_of(2) == Pixel(0x1F, 0xD0, 0x31, 0x40, 0x0FA061));
}

TEST_CASE("contributions are the pair's image and the valid rows", "[functional][pairs]") {
    Scenario scenario = test::small_scenario(8, 8, 2);
    scenario.composer.buffer_pixels = 34;
    scenario.composer.ready_space_pixels = 32;

    const ViewportRow good{1, 0, 0, 4, 4, 0, 0, 1};
    const ViewportRow no_such_display{3, 0, 0, 4, 4, 0, 0, 1};
    const ViewportRow window_too_wide{2, 0, 0, 4, 4, 0, 0, 2};  // needs 4 + 32 pixels
    const ViewportRow fitting_window{2, 0, 0, 2, 4, 0, 0, 2};
    const ViewportRow other{2, 1, 1, 2, 2, 3, 3, 1};

    Renderer renderer = test::renderer_of({PixelImage(4, 4, Pixel(1)), PixelImage(4, 4, Pixel(2))});
    renderer.frames[0].image = 1;
    renderer.frames[0].table = {no_such_display, good, window_too_wide, good, fitting_window};
    renderer.frames[1].image = 0;
    renderer.frames[1].table = {other};
    scenario.renderers = {renderer, renderer, renderer};

    const auto contributions = contributions_of(scenario, {0, -1, 7});
    REQUIRE(contributions.size() == 3);
    CHECK(contributions[0].image == &scenario.renderers[0].images[1]->pixels());
    CHECK(contributions[0].rows == ViewportTable{good, fitting_window});
    CHECK(contributions[1].image == nullptr);
    CHECK(contributions[1].rows.empty());
    CHECK(contributions[2].image == &scenario.renderers[2].images[0]->pixels());  // the last entry repeats
    CHECK(contributions[2].rows == ViewportTable{other});
}

TEST_CASE("contributions are those of the newest pair that carries the number", "[functional][pairs]") {
    Scenario scenario = test::small_scenario(4, 4);
    Renderer renderer = test::renderer_of({PixelImage(4, 4, Pixel(1)), PixelImage(4, 4, Pixel(2)),
                                           PixelImage(4, 4, Pixel(3)), PixelImage(4, 4, Pixel(4))});
    const std::vector<std::uint32_t> numbers{5, 9, 5, 7};
    for (std::size_t pair = 0; pair < numbers.size(); ++pair) {
        renderer.frames[pair].controls = SentControls{{}, {}, numbers[pair], {}, {}};
    }
    scenario.renderers = {renderer};
    const auto shown = [&scenario](int number) {
        return contributions_of(scenario, {number})[0].image->at(0, 0);
    };
    CHECK(shown(9) == Pixel(2));
    CHECK(shown(5) == Pixel(3));
    CHECK(shown(7) == Pixel(4));
    CHECK(shown(1) == Pixel(2));  // no pair carries it
}
