#include "monitors/scoreboard.h"

#include <catch2/catch.hpp>

#include "altered_machine.h"

namespace metabuffer::test::scoreboard_test {
using Catch::Contains;

namespace {

constexpr std::int64_t kRasterPixels = kAlteredWidth * kAlteredHeight;

/// The scoreboard, and the swap lock's monitor that shows it pictures, on the altered wires of a machine. The reference
/// may be made of another scenario.
struct Bench : AlteredMachine {
    Scenario reference;
    monitors::SwapLockMonitor swap_lock;
    monitors::Scoreboard scoreboard;
    std::int64_t edge = -1;

    explicit Bench(Scenario wanted = altered_scenario())
        : AlteredMachine(altered_scenario()),
          reference(std::move(wanted)),
          swap_lock("swap_lock_monitor", scenario(), silent_),
          scoreboard(
              "scoreboard", reference, wires(), machine.core_clk(), machine.reset(),
              [this](std::size_t renderer, int frame) { return machine.pair_of_frame(renderer, frame); },
              log) {
        silent_.on_violation([](const monitors::Violation&) {});
        swap_lock.clk_i(machine.core_clk());
        swap_lock.dvi_clk_i(machine.dvi_out_clk());
        swap_lock.reset_i(machine.reset());
        swap_lock.swaplock_i(wires().swaplock);
        swap_lock.swapskip_i(wires().swapskip);
        for (std::size_t d = 0; d < 2; ++d) {
            swap_lock.framedone_i[d](wires().framedone[d]);
            swap_lock.framebad_i[d](wires().framebad[d]);
            swap_lock.link_i[d](wires().link_out[d]);
        }
        swap_lock.on_picture([this](const auto& shown) { scoreboard.shown(shown); });
    }

    /// Changes a raster pixel of display 1 as it leaves the stages named (wire r leaves composer r).
    void alter_pixel(int frame, std::int64_t place, const std::vector<std::size_t>& stages, Pixel value) {
        altered.alter = [=, counts = std::vector<std::int64_t>(3, 0)](std::int64_t next,
                                                                      rtl::Wires& real) mutable {
            for (std::size_t r = 1; r <= 2; ++r) {
                rtl::PipePixel pixel = real.pipe[r * 2].read();
                if (!pixel.valid || counts[r]++ != frame * kRasterPixels + place) continue;
                if (std::find(stages.begin(), stages.end(), r) == stages.end()) continue;
                if (r == stages.front()) edge = next;
                pixel.pixel = value;
                wires().pipe[r * 2].write(pixel);
            }
        };
    }

  private:
    monitors::ViolationLog silent_;
};

}  // namespace

TEST_CASE("scoreboard: a right machine is found right and everything has been compared", "[monitors]") {
    Bench bench;
    bench.run();
    for (const auto& violation : bench.violations) FAIL(to_string(violation));
    CHECK(bench.scoreboard.raster_pixels() == 2 * kAlteredFrames * kRasterPixels);
    CHECK(bench.scoreboard.bus_pixels() == 2 * 2 * kAlteredFrames * kRasterPixels);
    CHECK(bench.scoreboard.pictures() == 2 * kAlteredFrames);
}

TEST_CASE("scoreboard: a wrong pixel is traced back to the composer that put it out", "[monitors]") {
    Bench bench;
    // Raster pixel 3,2 is at position 19 and shows source pixel 3,2, number 51: odd, so the comb is behind the plane.
    bench.alter_pixel(1, 2 * kAlteredWidth + 3, {2}, Pixel(1, 2, 3, 255, 4));
    bench.run();
    bench.check_first("scoreboard/pixel", "PIPE_3_1", "core", bench.edge, 1);
    const std::string& detail = bench.violations[0].detail;
    CHECK_THAT(detail, Contains("display 1, pixel 3,2 (raster 3,2) is #010203 A 255 Z 0x0004 instead of "
                                "#0a0234 A 255 Z 0x0032"));
    CHECK_THAT(detail, Contains("renderer 1 (plane) should have won with source pixel 3,2"));
    CHECK_THAT(detail, Contains("renderer 2 (comb) did"));
    CHECK_THAT(detail, Contains("composer_2_1 is the first to be wrong"));
    CHECK_THAT(detail, Contains("--trace-window cycles:" + std::to_string(bench.edge - 20) + "-"));
}

TEST_CASE("scoreboard: a mistake of an upper composer is found there", "[monitors]") {
    Bench bench;
    bench.alter_pixel(0, 2, {1, 2}, Pixel(1, 2, 3, 255, 4));
    bench.run();
    bench.check_first("scoreboard/pixel", "PIPE_2_1", "core", bench.edge, 0);
    CHECK_THAT(bench.violations[0].detail,
               Contains("renderer 2 (comb) should have won with source pixel 2,0"));
    CHECK_THAT(bench.violations[0].detail, Contains("renderer 1 (plane) did"));
    CHECK_THAT(bench.violations[0].detail, Contains("composer_1_1 is the first to be wrong"));
}

TEST_CASE("scoreboard: a machine that is right is wrong against another reference", "[monitors]") {
    Scenario other = altered_scenario();
    PixelImage image = other.renderers[0].images[2]->pixels();
    image.at(3, 2) = Pixel(9, 9, 9, 255, 50);
    other.renderers[0].images[2] = std::make_shared<const StoredImage>(image);
    Bench bench(other);
    bench.run();
    REQUIRE(bench.violations.size() == 3);  // once on the bus, once out of the pipeline, once on the display
    CHECK(bench.violations[0].rule == "scoreboard/bus");
    CHECK(bench.violations[0].signal == "BUS_1");
    CHECK(bench.violations[0].frame == 2);
    CHECK_THAT(bench.violations[0].detail,
               Contains("pixel 19 for display 1") && Contains("source pixel 3,2 of pair 2"));
    CHECK(bench.violations[1].rule == "scoreboard/pixel");
    CHECK(bench.violations[2].rule == "scoreboard/picture");
    CHECK_THAT(bench.violations[2].detail, Contains("pixel 3,2: ") && Contains("1 pixel differs") &&
                                               Contains("had left the pipeline wrong"));
}

TEST_CASE("scoreboard: colours that the output framebuffer does not correct as the scenario has it",
          "[monitors]") {
    Scenario other = altered_scenario();
    DisplayCorrection& correction = other.displays.correction.emplace_back();
    correction.display = 2;
    correction.gain[2] = 0.5;
    Bench bench(other);
    bench.run();
    REQUIRE(bench.violations.size() == kAlteredFrames);  // each picture of display 2 and nothing before it
    CHECK(bench.violations[0].rule == "scoreboard/picture");
    CHECK_THAT(bench.violations[0].detail,
               Contains("display 2, ") && Contains("the raster left the pipeline right, so it is "
                                                   "output_framebuffer_2"));
}

TEST_CASE("scoreboard: a wrong pixel on a bus", "[monitors]") {
    Bench bench;
    bench.altered.alter = [&, frames = 0](std::int64_t next, rtl::Wires& real) mutable {
        rtl::BusBeat beat = real.bus[1].read();
        frames += beat.kind == rtl::BusBeat::Kind::kFrameStart ? 1 : 0;
        const bool place =
            beat.kind == rtl::BusBeat::Kind::kPixels && beat.destination == 2 && beat.first == 11;
        if (frames != 2 || !place) return;
        bench.edge = next;
        beat.words[0] ^= 1;
        bench.wires().bus[1].write(beat);
    };
    bench.run();
    bench.check_first("scoreboard/bus", "BUS_2", "core", bench.edge, 1);
    CHECK_THAT(bench.violations[0].detail,
               Contains("pixel 11 for display 2") && Contains("source pixel 11,1 of pair 1"));
}

TEST_CASE("scoreboard: a wrong row of a table", "[monitors]") {
    Bench bench;
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        rtl::BusBeat beat = real.bus[0].read();
        if (beat.kind != rtl::BusBeat::Kind::kTableRow || bench.edge >= 0) return;
        bench.edge = next;
        ViewportRow row = beat.row();
        row.dx = 1;
        bench.wires().bus[0].write(rtl::BusBeat::table_row(beat.frame, beat.first, row, beat.last));
    };
    bench.run();
    bench.check_first("scoreboard/table", "BUS_1", "core", bench.edge, 0);
}

TEST_CASE("scoreboard: a frame made of a pair that the link has not brought", "[monitors]") {
    Bench bench;
    std::int64_t start = -1;
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        rtl::DecoderEvent event = real.event[1].read();
        if (event.pair_good && event.number == 1) {
            event.pair_good = false;
            bench.wires().event[1].write(event);
        }
        if (real.bus[1].read().kind == rtl::BusBeat::Kind::kFrameStart && bench.machine.pair_of_frame(1, 1) &&
            start < 0) {
            start = next;
        }
    };
    bench.run();
    bench.check_first("scoreboard/pair", "BUS_2", "core", start, 1);
    CHECK_THAT(bench.violations[0].detail, Contains("pair 1") && Contains("not brought whole"));
}

TEST_CASE("scoreboard: a picture that is not the raster that left the pipeline", "[monitors]") {
    Bench bench;
    LinkPosition position({kAlteredWidth, kAlteredHeight});
    bench.altered.alter = [&](std::int64_t next, rtl::Wires& real) {
        rtl::DviLink link = real.link_out[1].read();
        if (!position.step(link) || !link.de || link.data == 0) return;
        if (position.line() == 7 && position.x() == 4) {
            link.data ^= 1;
            bench.wires().link_out[1].write(link);
        }
        // The picture is judged with its last pixel.
        if (position.line() == DviTiming::kVerticalBackLines + kAlteredHeight - 1 &&
            position.x() == kAlteredWidth - 1 && bench.edge < 0) {
            bench.edge = next;
        }
    };
    bench.run();
    bench.check_first("scoreboard/picture", "DVI_OUT_2", "dvi_out", bench.edge, 0);
    CHECK_THAT(bench.violations[0].detail,
               Contains("pixel 4,1: ") && Contains("1 pixel differs") && Contains("output_framebuffer_2"));
}

TEST_CASE("scoreboard: a frame with lost pixels must not replace the picture before it", "[monitors]") {
    Bench bench;
    // The machine loses nothing, so it shows frame 1, which the wires now say it must not.
    bench.altered.alter = [&, count = std::int64_t{0}](std::int64_t, rtl::Wires& real) mutable {
        rtl::PipePixel pixel = real.pipe[4].read();
        if (!pixel.valid || count++ != kRasterPixels + 5) return;
        pixel.lost = true;
        bench.wires().pipe[4].write(pixel);
    };
    bench.run();
    REQUIRE(bench.violations.size() == 2);
    for (const auto& violation : bench.violations) {
        CHECK(violation.rule == "scoreboard/picture");
        CHECK(violation.frame == 1);
        CHECK_THAT(violation.detail, Contains("the picture before was to stay"));
    }
}

}  // namespace metabuffer::test::scoreboard_test
