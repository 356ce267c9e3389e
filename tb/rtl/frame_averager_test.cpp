#include "rtl/frame_averager.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "expected_report.h"
#include "support/colour_tables.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::frame_averager_test {
namespace {

using rtl::DisplayWrite;
using rtl::FrameAverager;
using rtl::PipePixel;
using Clocks = std::vector<int>;

constexpr int kWidth = 4;
constexpr int kHeight = 3;
constexpr int kPixels = kWidth * kHeight;

Scenario averager_scenario(int supersample = 1, StarvationMode mode = StarvationMode::kGlitch) {
    Scenario scenario = small_scenario(kWidth, kHeight);
    scenario.displays.supersample = supersample;
    scenario.composer.on_starvation = mode;
    return scenario;
}

std::vector<Pixel> raster(std::uint64_t seed, int pixels = kPixels) {
    return noise_image(seed, pixels, 1).values;
}

/// The display's pixels of a raster: the mean of each block, halves up.
std::vector<std::uint32_t> means(const std::vector<Pixel>& pixels, int supersample) {
    std::vector<std::uint32_t> colours;
    const int raster_width = kWidth * supersample;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            std::array<int, 3> sums{};
            for (int i = 0; i < supersample * supersample; ++i) {
                const int column = x * supersample + i % supersample;
                const int row = y * supersample + i / supersample;
                const Pixel& pixel = pixels[static_cast<std::size_t>(row * raster_width + column)];
                sums[0] += pixel.r();
                sums[1] += pixel.g();
                sums[2] += pixel.b();
            }
            std::uint32_t colour = 0;
            for (const int sum : sums) {
                const double mean = static_cast<double>(sum) / (supersample * supersample);
                colour = colour * 256 + static_cast<std::uint32_t>(mean + 0.5);
            }
            colours.push_back(colour);
        }
    }
    return colours;
}

/// A frame averager between a pipeline, a memory's write port and a display's timing, all played by the test.
struct AveragerBench {
    ClockDomain& core;
    sc_core::sc_signal<bool> startframe, column_stall, pipeready, framedone, framebad, writes, swapped,
        skipped;
    sc_core::sc_signal<PipePixel> pipe;
    sc_core::sc_signal<DisplayWrite> write;
    FrameAverager dut;
    const Recording<bool>& pipereadies;
    const Recording<bool>& framedones;
    const Recording<bool>& framebads;
    const Recording<bool>& writing;
    const Recording<DisplayWrite>& written;

    explicit AveragerBench(ClockedTestbench& bench, const Scenario& scenario = averager_scenario(),
                           const std::string& name = "output_framebuffer", int display = 1)
        : core(bench.core),
          dut(name.c_str(), scenario, display),
          pipereadies(core.record(pipeready)),
          framedones(core.record(framedone)),
          framebads(core.record(framebad)),
          writing(core.record(writes)),
          written(core.record(write)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.startframe_i(startframe);
        dut.pipe_i(pipe);
        dut.column_stall_i(column_stall);
        dut.pipeready_o(pipeready);
        dut.framedone_o(framedone);
        dut.framebad_o(framebad);
        dut.writes_o(writes);
        dut.write_o(write);
        dut.swapped_i(swapped);
        dut.skipped_i(skipped);
        bench.trace(dut);
    }

    /// STARTFRAME at edge `clock`, the raster's pixels at the edges after it. In stalled clocks the pipeline stands
    /// still, as its registers would.
    void send_frame(int clock, const std::vector<Pixel>& pixels, const std::set<int>& stalled = {},
                    const std::set<int>& lost = {}) {
        for (const int at : stalled) core.pulse(column_stall, at);
        core.drive(startframe, clock, true);
        while (stalled.count(clock) != 0) ++clock;
        core.drive(startframe, ++clock, false);
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            core.drive(pipe, clock, PipePixel{pixels[i], true, lost.count(static_cast<int>(i)) != 0});
            while (stalled.count(clock) != 0) ++clock;
            ++clock;
        }
        core.drive(pipe, clock, PipePixel{});
    }
    /// The swap is reported from edge `first` to edge `last`.
    void swap(int first, int last, bool skip = false) {
        core.drive(skipped, first, skip);
        core.drive(swapped, first, true);
        core.drive(swapped, last + 1, false);
    }
    /// The clocks that leave a pixel at write_o.
    Clocks write_clocks() const { return writing.high(); }
    /// What stands there in them, from `from` on.
    std::vector<DisplayWrite> all_written(int from = 0) const {
        std::vector<DisplayWrite> pixels;
        for (const int clock : write_clocks()) {
            if (clock >= from) pixels.push_back(written.at(clock));
        }
        return pixels;
    }
};

std::vector<DisplayWrite> frame_in_bank(bool bank, const std::vector<std::uint32_t>& colours) {
    std::vector<DisplayWrite> pixels;
    for (std::size_t i = 0; i < colours.size(); ++i) {
        pixels.push_back({bank, static_cast<std::uint32_t>(i), colours[i]});
    }
    return pixels;
}

TEST_CASE("frame averager: in reset all is low, PIPEREADY rises at the first clock after it") {
    ClockedTestbench bench;
    AveragerBench dut(bench);
    bench.run_through(20);
    CHECK_FALSE(dut.pipereadies.at(-1));
    CHECK(dut.pipereadies.high() == clock_range(0, 21));
    CHECK(dut.framedones.high().empty());
    CHECK(dut.framebads.high().empty());
    CHECK(dut.writing.high().empty());
}

TEST_CASE(
    "frame averager: from the clock after STARTFRAME on each edge's pixel stands at the memory after it") {
    ClockedTestbench bench;
    AveragerBench dut(bench);
    const int start = 30;
    const auto pixels = raster(1);
    dut.send_frame(start, pixels);
    // Before and after the frame the pipeline shows valid pixels that do not belong to it.
    bench.core.drive(dut.pipe, start, PipePixel{Pixel(0x123456U), true, true});
    bench.core.drive(dut.pipe, start + kPixels + 1, PipePixel{Pixel(0x654321U), true, true});
    bench.run_through(start + kPixels + 100);
    CHECK(dut.pipereadies.falls() == Clocks{start});
    CHECK(dut.write_clocks() == clock_range(start + 1, start + kPixels + 1));
    CHECK(dut.all_written() == frame_in_bank(false, means(pixels, 1)));
    CHECK(dut.framedones.rises() == Clocks{start + kPixels});
    CHECK(dut.framedones.falls().empty());  // the swap has never come
    CHECK(dut.framebads.high().empty());
    CHECK(dut.pipereadies.high().back() == start - 1);
    CHECK(dut.dut.pixels_taken() == kPixels);
}

TEST_CASE(
    "frame averager: of supersampled pixels the mean of each block, halves up, stands after its last pixel") {
    ClockedTestbench bench;
    AveragerBench two(bench, averager_scenario(2), "two");
    AveragerBench four(bench, averager_scenario(4), "four");
    const int start = 10;
    auto of_two = raster(2, 4 * kPixels);
    of_two[0] = Pixel(1, 0, 0, 0, 0);  // the first block's red is 1.5, its green 1.25, its blue 0.75
    of_two[1] = Pixel(2, 5, 0, 0, 0);
    of_two[2 * kWidth] = Pixel(3, 0, 3, 0, 0);
    of_two[2 * kWidth + 1] = Pixel(0, 0, 0, 0, 0);
    const auto of_four = raster(3, 16 * kPixels);
    two.send_frame(start, of_two);
    four.send_frame(start, of_four);
    bench.run_through(start + 16 * kPixels + 10);
    CHECK(two.all_written() == frame_in_bank(false, means(of_two, 2)));
    CHECK(two.all_written().front().colour == 0x020101);
    CHECK(four.all_written() == frame_in_bank(false, means(of_four, 4)));
    Clocks ends;
    for (int i = 0; i < kPixels; ++i) {
        ends.push_back(start + 1 + (2 * (i / kWidth) + 1) * 2 * kWidth + 2 * (i % kWidth) + 1);
    }
    CHECK(two.write_clocks() == ends);
    CHECK(two.framedones.rises() == Clocks{start + 4 * kPixels});
    CHECK(four.framedones.rises() == Clocks{start + 16 * kPixels});
}

TEST_CASE(
    "frame averager: the swap is seen behind two registers, and the next frame goes into the other bank") {
    ClockedTestbench bench;
    AveragerBench dut(bench);
    const std::array<std::vector<Pixel>, 3> frames{raster(4), raster(5), raster(6)};
    for (int i = 0; i < 3; ++i) {
        dut.send_frame(100 * i + 10, frames[static_cast<std::size_t>(i)]);
        dut.swap(100 * i + 50, 100 * i + 60);
    }
    bench.run_through(300);
    CHECK(dut.framedones.falls() == Clocks{51, 151, 251});
    CHECK(dut.pipereadies.rises() == Clocks{0, 51, 151, 251});
    std::vector<DisplayWrite> due;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto frame = frame_in_bank(i == 1, means(frames[i], 1));
        due.insert(due.end(), frame.begin(), frame.end());
    }
    CHECK(dut.all_written() == due);
}

TEST_CASE("frame averager: a frame that is not shown leaves its bank to the next one") {
    ClockedTestbench bench;
    AveragerBench dut(bench);
    dut.send_frame(10, raster(7));
    dut.swap(50, 60, true);
    dut.send_frame(110, raster(8));
    dut.swap(150, 160);
    dut.send_frame(210, raster(9));
    bench.run_through(250);
    CHECK(dut.framedones.falls() == Clocks{51, 151});
    CHECK(dut.pipereadies.rises() == Clocks{0, 51, 151});
    CHECK(dut.all_written(100) == [] {
        auto due = frame_in_bank(false, means(raster(8), 1));
        const auto next = frame_in_bank(true, means(raster(9), 1));
        due.insert(due.end(), next.begin(), next.end());
        return due;
    }());
}

TEST_CASE("frame averager: it says which frame it waits for, and in a frame at which raster position") {
    ClockedTestbench bench;
    AveragerBench dut(bench);
    dut.send_frame(10, raster(7));
    dut.swap(50, 60);
    dut.send_frame(110, raster(8));
    const auto waits_after = [&](int clock) {
        bench.run_through(clock);
        return dut.dut.waiting_for();
    };
    CHECK(waits_after(9) == "waits for STARTFRAME of frame 0");
    CHECK(waits_after(10) == "waits for raster pixel 0 of frame 0");
    CHECK(waits_after(13) == "waits for raster pixel 3 of frame 0");
    CHECK(waits_after(30) == "waits for SWAPLOCK to show frame 0");
    CHECK(waits_after(70) == "waits for STARTFRAME of frame 1");
    CHECK(waits_after(112) == "waits for raster pixel 2 of frame 1");
    CHECK(waits_after(130) == "waits for SWAPLOCK to show frame 1");
}

TEST_CASE("frame averager: FRAMEDONE does not rise again before the swap before has been seen to end") {
    ClockedTestbench bench;
    AveragerBench dut(bench);
    dut.send_frame(10, raster(10));
    dut.swap(40, 99);
    dut.send_frame(50, raster(11));  // whole after edge 62
    bench.run_through(140);
    CHECK(dut.framedones.rises() == Clocks{10 + kPixels, 101});
    CHECK(dut.framedones.falls() == Clocks{41});
    CHECK(dut.pipereadies.falls() == Clocks{10, 50});
    CHECK(dut.pipereadies.high().back() == 49);
}

TEST_CASE(
    "frame averager: FRAMEBAD rises with the first lost pixel, at any position, and falls with the swap") {
    ClockedTestbench bench;
    AveragerBench dut(bench);
    const int last = kPixels - 1;
    dut.send_frame(10, raster(12), {}, {0, 3});
    dut.swap(50, 60, true);
    dut.send_frame(110, raster(13), {}, {last});
    dut.swap(150, 160, true);
    dut.send_frame(210, raster(14));
    bench.run_through(250);
    CHECK(dut.framebads.rises() == Clocks{11, 110 + kPixels});
    CHECK(dut.framebads.falls() == Clocks{51, 151});
    CHECK(dut.framedones.rises() == Clocks{10 + kPixels, 110 + kPixels, 210 + kPixels});
    CHECK(dut.all_written().size() == 3 * kPixels);  // lost pixels are written like others
}

TEST_CASE("frame averager: its own display's table corrects what is averaged, at the same clocks") {
    ClockedTestbench bench;
    Random random(81);
    Scenario scenario = averager_scenario(2);
    scenario.displays.columns = 3;
    for (const int display : {1, 2}) {
        DisplayCorrection correction;
        correction.display = display;
        correction.lut = std::make_shared<const ColourTable>(random_colour_table(random));
        scenario.displays.correction.push_back(correction);
    }
    const auto pixels = raster(15, 4 * kPixels);
    std::vector<std::unique_ptr<AveragerBench>> duts;
    for (int display = 1; display <= 3; ++display) {
        duts.push_back(
            std::make_unique<AveragerBench>(bench, scenario, "display_" + std::to_string(display), display));
        duts.back()->send_frame(10, pixels);
    }
    bench.run_through(10 + 4 * kPixels + 5);
    ColourImage picture(kWidth, kHeight);
    picture.values = means(pixels, 2);
    for (std::size_t i = 0; i < 2; ++i) {
        const ColourImage shown = naive_correction(*scenario.displays.correction[i].lut, picture);
        CHECK(duts[i]->all_written() == frame_in_bank(false, shown.values));
        CHECK(duts[i]->write_clocks() == duts[2]->write_clocks());
    }
    CHECK(duts[2]->all_written() == frame_in_bank(false, picture.values));
}

TEST_CASE(
    "frame averager: edges with COLUMNSTALL high do not count, STARTFRAME's and the last pixel's among "
    "them") {
    ClockedTestbench bench;
    AveragerBench stall(bench, averager_scenario(1, StarvationMode::kStall), "stall");
    AveragerBench glitch(bench, averager_scenario(), "glitch");
    const std::set<int> stalled{15, 20, 21, 23, 27, 28, 36};  // the first wakes the block
    const auto pixels = raster(16);
    stall.send_frame(20, pixels, stalled);
    glitch.send_frame(20, pixels);
    for (const int clock : stalled) bench.core.pulse(glitch.column_stall, clock);
    bench.run_through(60);
    // STARTFRAME is seen at edge 22.
    CHECK(stall.write_clocks() == Clocks{24, 25, 26, 29, 30, 31, 32, 33, 34, 35, 37, 38});
    CHECK(stall.all_written() == frame_in_bank(false, means(pixels, 1)));
    CHECK(stall.pipereadies.falls() == Clocks{22});
    CHECK(stall.framedones.rises() == Clocks{38});
    CHECK(stall.dut.stalled_cycles() == 7);
    // Nothing ever raises it there, so it is not read.
    CHECK(glitch.write_clocks() == clock_range(21, 21 + kPixels));
    CHECK(glitch.dut.stalled_cycles() == 0);
}

TEST_CASE("frame averager: a swap is seen while COLUMNSTALL is high") {
    ClockedTestbench bench;
    AveragerBench dut(bench, averager_scenario(1, StarvationMode::kStall));
    dut.send_frame(10, raster(17));
    for (int clock = 40; clock < 60; ++clock) bench.core.pulse(dut.column_stall, clock);
    dut.swap(50, 70);
    bench.run_through(80);
    CHECK(dut.framedones.falls() == Clocks{51});
    CHECK(dut.pipereadies.rises() == Clocks{0, 51});
}

TEST_CASE("frame averager: no pixel at a raster position is reported, and the position waits") {
    ExpectedReport report("/metabuffer/output_framebuffer/bubble");
    ClockedTestbench bench;
    AveragerBench dut(bench);
    auto pixels = raster(18);
    dut.send_frame(10, pixels);
    bench.core.drive(dut.pipe, 14, PipePixel{pixels[3], false});
    bench.core.drive(dut.pipe, 11 + kPixels, PipePixel{Pixel(0x123456U), true});
    bench.run_through(40);
    CHECK(report.count() == 1);
    pixels.erase(pixels.begin() + 3);
    pixels.push_back(Pixel(0x123456U));
    CHECK(dut.all_written() == frame_in_bank(false, means(pixels, 1)));
    CHECK(dut.framedones.rises() == Clocks{11 + kPixels});
}

TEST_CASE("frame averager: reset in a frame leaves what power-up leaves") {
    ClockedTestbench bench;
    AveragerBench dut(bench, averager_scenario(2));
    dut.send_frame(10, raster(19, 4 * kPixels));
    dut.swap(80, 85);
    const int first = 100;  // goes into the second bank and is broken off in a block
    auto broken = raster(20, 4 * kPixels);
    broken.resize(2 * 2 * kWidth - 2);
    dut.send_frame(first, broken, {}, {2});
    const int reset = first + 1 + static_cast<int>(broken.size());
    bench.core.drive(bench.reset, reset, true);
    bench.core.drive(bench.reset, reset + 3, false);
    const auto pixels = raster(21, 4 * kPixels);
    dut.send_frame(reset + 20, pixels);
    // It has seen a swap's report when reset comes again, which falls only after it.
    const int again = reset + 150;
    dut.swap(again - 5, again + 1);
    bench.core.drive(bench.reset, again, true);
    bench.core.drive(bench.reset, again + 2, false);
    dut.send_frame(again + 20, pixels);
    bench.run_through(again + 100);
    CHECK(dut.framebads.high() == clock_range(first + 3, reset));
    CHECK(dut.writing.at(reset - 1));
    CHECK(dut.written.at(reset) == DisplayWrite{});
    CHECK(dut.pipereadies.rises() == Clocks{0, 81, reset + 3, again - 4, again + 2});
    CHECK(dut.framedones.rises() ==
          Clocks{10 + 4 * kPixels, reset + 20 + 4 * kPixels, again + 20 + 4 * kPixels});
    const auto due = frame_in_bank(false, means(pixels, 2));
    const auto all = dut.all_written(reset);
    REQUIRE(all.size() == 2 * due.size());
    for (std::size_t i = 0; i < all.size(); ++i) CHECK(all[i] == due[i % due.size()]);
}

TEST_CASE("frame averager: a reset wakes a block that sleeps with its back bank full") {
    ClockedTestbench bench;
    AveragerBench dut(bench);
    dut.send_frame(10, raster(22));
    const int reset = 10 + kPixels + 50;
    bench.core.drive(bench.reset, reset, true);
    bench.core.drive(bench.reset, reset + 3, false);
    dut.send_frame(reset + 20, raster(23));
    bench.run_through(reset + 40 + kPixels);
    CHECK(dut.pipereadies.rises() == Clocks{0, reset + 3});
    CHECK(dut.framedones.rises() == Clocks{10 + kPixels, reset + 20 + kPixels});
}

TEST_CASE("frame averager: a swap of a DVI clock of any ratio is seen at the second core edge after it") {
    ClockedTestbench bench;
    std::vector<std::unique_ptr<AveragerBench>> duts;
    std::vector<ClockDomain*> clocks;
    for (const std::int64_t period : {1'600, 9'984, 10'016, 133'328}) {
        const std::string name = "dvi_" + std::to_string(period);
        clocks.push_back(&bench.add_clock(name.c_str(), period));
        duts.push_back(std::make_unique<AveragerBench>(bench, averager_scenario(), name + "_framebuffer"));
        duts.back()->send_frame(2, raster(22));
    }
    bench.run_through(40);
    std::vector<Clocks> due;
    for (std::size_t i = 0; i < duts.size(); ++i) {
        const ClockDomain& dvi = *clocks[i];
        const int edge = dvi.clock() + 2;
        clocks[i]->drive(duts[i]->swapped, edge, true);
        // It changes half a period before that edge.
        const std::int64_t time =
            (edge + dvi.reset_clocks()) * dvi.period_picoseconds() - dvi.period_picoseconds() / 2;
        const auto captured = static_cast<int>(time / bench.core.period_picoseconds()) + 1;
        due.push_back({captured - bench.core.reset_clocks() + 1});
    }
    bench.run_through(100);
    for (std::size_t i = 0; i < duts.size(); ++i) CHECK(duts[i]->framedones.falls() == due[i]);
}

TEST_CASE("frame averager: through random frames, stalls and swaps every output is due at its clock") {
    const auto seed = random_seed(2211);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    constexpr int kClocks = 4000;
    const int supersample = random.one_in(2) ? 1 : 2;
    const auto raster_pixels = static_cast<std::size_t>(kPixels * supersample * supersample);
    ClockedTestbench bench;
    AveragerBench dut(bench, averager_scenario(supersample, StarvationMode::kStall));
    // What the wires must be after each edge.
    struct Due {
        bool pipeready = true, framedone = false, framebad = false, writes = false;
        DisplayWrite write;
    };
    std::vector<Due> all_due;
    Due due;
    std::vector<Pixel> frame;  // received so far
    bool receiving = false, whole = false, bank = false;
    bool swapped = false, swapped_before = false, swapped_twice_before = false, skip = false;
    bool stands = false, startframe = false;
    PipePixel pixel;
    for (int clock = 0; clock < kClocks; ++clock) {
        // What the edge samples. A pipeline that stands still has its pixel and STARTFRAME again.
        if (!stands) {
            startframe = !receiving && !startframe && due.pipeready && random.one_in(15);
            pixel = {noise_pixel(random), receiving || random.one_in(2), random.one_in(100)};
        }
        stands = random.one_in(6);
        if (swapped ? !due.framedone && random.one_in(9) : due.framedone && random.one_in(20)) {
            swapped = !swapped;
            if (swapped) skip = due.framebad || random.one_in(4);
        }
        dut.core.drive(dut.startframe, clock, startframe);
        dut.core.drive(dut.pipe, clock, pixel);
        dut.core.drive(dut.column_stall, clock, stands);
        dut.core.drive(dut.swapped, clock, swapped);
        dut.core.drive(dut.skipped, clock, skip);
        // What that leaves.
        if (swapped_before && !swapped_twice_before) {
            whole = due.framebad = false;
            bank = bank != !skip;
        }
        due.writes = false;
        if (!stands && receiving) {
            frame.push_back(pixel.pixel);
            due.framebad = due.framebad || pixel.lost;
            const int position = static_cast<int>(frame.size()) - 1;
            const int x = position % (kWidth * supersample);
            const int y = position / (kWidth * supersample);
            due.writes = x % supersample == supersample - 1 && y % supersample == supersample - 1;
            if (due.writes) {
                const int address = y / supersample * kWidth + x / supersample;
                std::vector<Pixel> known = frame;
                known.resize(raster_pixels);
                due.write = {bank, static_cast<std::uint32_t>(address),
                             means(known, supersample)[static_cast<std::size_t>(address)]};
            }
            receiving = frame.size() < raster_pixels;
            whole = !receiving;
        } else if (!stands && startframe) {
            receiving = true;
            frame.clear();
        }
        due.framedone = whole && !swapped_before;
        due.pipeready = !receiving && !whole;
        swapped_twice_before = swapped_before;
        swapped_before = swapped;
        all_due.push_back(due);
    }
    bench.run_through(kClocks);
    for (int clock = 0; clock < kClocks; ++clock) {
        INFO("clock " << clock);
        const Due& wanted = all_due[static_cast<std::size_t>(clock)];
        REQUIRE(dut.pipereadies.at(clock) == wanted.pipeready);
        REQUIRE(dut.framedones.at(clock) == wanted.framedone);
        REQUIRE(dut.framebads.at(clock) == wanted.framebad);
        REQUIRE(dut.writing.at(clock) == wanted.writes);
        if (wanted.writes) REQUIRE(dut.written.at(clock) == wanted.write);
    }
}

}  // namespace
}  // namespace metabuffer::test::frame_averager_test
