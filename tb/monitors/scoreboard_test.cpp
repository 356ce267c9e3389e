#include "monitors/scoreboard.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "altered_machine.h"

namespace metabuffer::test::scoreboard_test {
using Catch::Contains;

namespace {

constexpr std::int64_t kRasterPixels = kAlteredWidth * kAlteredHeight;

/// The scoreboard, and the swap lock's monitor that shows it pictures, on the altered wires of a machine. The reference
/// may be made of another scenario.
struct ScoreboardBench : AlteredBench {
    Scenario reference;
    monitors::ViolationLog silent;
    monitors::SwapLockMonitor swap_lock;
    monitors::Scoreboard scoreboard;

    ScoreboardBench(const sc_core::sc_module_name& name, WatchedMachine& watched,
                    Scenario wanted = altered_scenario())
        : AlteredBench(name, watched),
          reference(std::move(wanted)),
          swap_lock("swap_lock_monitor", scenario, silent),
          scoreboard(
              "scoreboard", reference, wires, machine.core_clk(), machine.reset(),
              [this](std::size_t renderer, int frame) { return machine.pair_of_frame(renderer, frame); },
              log) {
        silent.on_violation([](const monitors::Violation&) {});
        bind_swap_lock(swap_lock);
        swap_lock.on_picture([this](const auto& shown) { scoreboard.shown(shown); });
    }
    void check_detail(std::size_t violation, const std::vector<std::string>& parts) const {
        for (const std::string& part : parts) CHECK_THAT(violations.at(violation).detail, Contains(part));
    }
};

using Change = std::function<void(ScoreboardBench&)>;

/// Changes a raster pixel of display 1 as it leaves the stages from the first one named on (wire r leaves composer r).
Change alter_pixel(int frame, std::int64_t position, std::size_t first_stage) {
    return [=](ScoreboardBench& bench) {
        bench.alter = [=, &bench, counts = std::vector<std::int64_t>(3, 0)](std::int64_t next,
                                                                            rtl::Wires& real) mutable {
            for (std::size_t r = 1; r <= 2; ++r) {
                rtl::PipePixel pixel = real.pipe[r * 2].read();
                if (!pixel.valid || counts[r]++ != frame * kRasterPixels + position || r < first_stage)
                    continue;
                if (r == first_stage) bench.edge = next;
                pixel.pixel = Pixel(1, 2, 3, 255, 4);
                bench.wires.pipe[r * 2].write(pixel);
            }
        };
    };
}

/// Checks parts of the first violation's detail.
std::function<void(const ScoreboardBench&)> says(const std::vector<std::string>& parts) {
    return [parts](const ScoreboardBench& bench) { bench.check_detail(0, parts); };
}

}  // namespace

TEST_CASE("scoreboard: its rules in a table", "[monitors]") {
    AlteredRuleTable<ScoreboardBench> rules;
    rules.of(altered_scenario());
    rules.row("a right machine, of which everything is compared", {}, {}, [](const auto& bench) {
        CHECK(bench.scoreboard.raster_pixels() == 2 * kAlteredFrames * kRasterPixels);
        CHECK(bench.scoreboard.bus_pixels() == 2 * 2 * kAlteredFrames * kRasterPixels);
        CHECK(bench.scoreboard.pictures() == 2 * kAlteredFrames);
    });
    // Raster pixel 3,2 is at position 19 and shows source pixel 3,2, number 51: odd, so the comb is behind the plane.
    rules.row("a wrong pixel is traced back to the composer that put it out",
              {{"scoreboard/pixel", "PIPE_3_1", 0, 1}}, alter_pixel(1, 2 * kAlteredWidth + 3, 2),
              [](const auto& bench) {
                  bench.check_detail(
                      0, {"display 1, pixel 3,2 (raster 3,2) is #010203 A 255 Z 0x0004 instead of "
                          "#0a0234 A 255 Z 0x0032",
                          "renderer 1 (plane) should have won with source pixel 3,2", "renderer 2 (comb) did",
                          "composer_2_1 is the first to be wrong",
                          "--trace-window cycles:" + std::to_string(bench.edge - 20) + "-"});
              });
    rules.row("a mistake of an upper composer is found there", {{"scoreboard/pixel", "PIPE_2_1", 0, 0}},
              alter_pixel(0, 2, 1),
              says({"renderer 2 (comb) should have won with source pixel 2,0", "renderer 1 (plane) did",
                    "composer_1_1 is the first to be wrong"}));
    rules.row(
        "a wrong pixel on a bus", {{"scoreboard/bus", "BUS_2", 0, 1}},
        [](auto& bench) {
            bench.alter = [&bench, frames = 0](std::int64_t next, rtl::Wires& real) mutable {
                rtl::BusBeat beat = real.bus[1].read();
                frames += beat.kind == rtl::BusBeat::Kind::kFrameStart ? 1 : 0;
                if (frames != 2 || beat.kind != rtl::BusBeat::Kind::kPixels || beat.destination != 2 ||
                    beat.first != 11)
                    return;
                bench.edge = next;
                beat.words[0] ^= 1;
                bench.wires.bus[1].write(beat);
            };
        },
        says({"pixel 11 for display 2", "source pixel 11,1 of pair 1"}));
    rules.row("a wrong row of a table", {{"scoreboard/table", "BUS_1", 0, 0}}, [](auto& bench) {
        bench.alter = [&bench](std::int64_t next, rtl::Wires& real) {
            const rtl::BusBeat beat = real.bus[0].read();
            if (beat.kind != rtl::BusBeat::Kind::kTableRow || bench.edge >= 0) return;
            bench.edge = next;
            ViewportRow row = beat.row();
            row.dx = 1;
            bench.wires.bus[0].write(rtl::BusBeat::table_row(beat.frame, beat.first, row, beat.last));
        };
    });
    rules.row(
        "a frame is made of a pair that the link has not brought", {{"scoreboard/pair", "BUS_2", 0, 1}},
        [](auto& bench) {
            bench.alter = [&bench](std::int64_t next, rtl::Wires& real) {
                rtl::DecoderEvent event = real.event[1].read();
                if (event.pair_good && event.number == 1) {
                    event.pair_good = false;
                    bench.wires.event[1].write(event);
                }
                if (real.bus[1].read().kind == rtl::BusBeat::Kind::kFrameStart &&
                    bench.machine.pair_of_frame(1, 1) && bench.edge < 0) {
                    bench.edge = next;
                }
            };
        },
        says({"pair 1", "not brought whole"}));
    rules.row(
        "a picture is not the raster that left the pipeline",
        {{"scoreboard/picture", "DVI_OUT_2", 0, 0, "dvi_out"}, kOthers},
        [](auto& bench) {
            const LinkPosition start({kAlteredWidth, kAlteredHeight});
            bench.alter = [&bench, position = start](std::int64_t next, rtl::Wires& real) mutable {
                rtl::DviLink link = real.link_out[1].read();
                if (!position.step(link) || !link.de || link.data == 0) return;
                if (position.line() == 7 && position.x() == 4) {
                    link.data ^= 1;
                    bench.wires.link_out[1].write(link);
                }
                // The picture is judged with its last pixel.
                if (position.line() == DviTiming::kVerticalBackLines + kAlteredHeight - 1 &&
                    position.x() == kAlteredWidth - 1 && bench.edge < 0) {
                    bench.edge = next;
                }
            };
        },
        says({"pixel 4,1: ", "1 pixel differs", "output_framebuffer_2"}));
    // The machine loses nothing, so it shows frame 1, which the wires now say it must not.
    rules.row(
        "a frame with lost pixels replaces the picture before it",
        {{"scoreboard/picture", "DVI_OUT_1", kAnyClock, 1, "dvi_out"},
         {"scoreboard/picture", "DVI_OUT_2", kAnyClock, 1, "dvi_out"}},
        [](auto& bench) {
            bench.alter = [&bench, count = std::int64_t{0}](std::int64_t /*next*/, rtl::Wires& real) mutable {
                rtl::PipePixel pixel = real.pipe[4].read();
                if (!pixel.valid || count++ != kRasterPixels + 5) return;
                pixel.lost = true;
                bench.wires.pipe[4].write(pixel);
            };
        },
        [](const auto& bench) {
            for (const std::size_t i : {0U, 1U}) bench.check_detail(i, {"the picture before was to stay"});
        });

    Scenario other = altered_scenario();
    PixelImage image = other.renderers[0].images[2]->pixels();
    image.at(3, 2) = Pixel(9, 9, 9, 255, 50);
    other.renderers[0].images[2] = std::make_shared<const StoredImage>(image);
    rules.of(altered_scenario(), other);
    // Once on the bus, once out of the pipeline, once on the display.
    rules.row("a pixel of the reference that the machine does not have",
              {{"scoreboard/bus", "BUS_1", kAnyClock, 2},
               {"scoreboard/pixel", "PIPE_2_1", kAnyClock, 2},
               {"scoreboard/picture", "DVI_OUT_1", kAnyClock, 2, "dvi_out"}},
              {}, [](const auto& bench) {
                  bench.check_detail(0, {"pixel 19 for display 1", "source pixel 3,2 of pair 2"});
                  bench.check_detail(2, {"pixel 3,2: ", "1 pixel differs", "had left the pipeline wrong"});
              });
    other = altered_scenario();
    DisplayCorrection& correction = other.displays.correction.emplace_back();
    correction.display = 2;
    correction.gain[2] = 0.5;
    rules.of(altered_scenario(), other);
    // Each picture of display 2 and nothing before it.
    rules.row("colours that the output framebuffer does not correct as the reference has it",
              {{"scoreboard/picture", "DVI_OUT_2", kAnyClock, 0, "dvi_out"},
               {"scoreboard/picture", "DVI_OUT_2", kAnyClock, 1, "dvi_out"},
               {"scoreboard/picture", "DVI_OUT_2", kAnyClock, 2, "dvi_out"}},
              {}, says({"display 2, ", "the raster left the pipeline right, so it is output_framebuffer_2"}));
    rules.run_and_check();
}

}  // namespace metabuffer::test::scoreboard_test
