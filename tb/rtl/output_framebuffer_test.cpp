#include "rtl/output_framebuffer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "dvi_waveform.h"
#include "expected_report.h"
#include "monitors/dvi_monitor.h"
#include "support/colour_tables.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::output_framebuffer_test {
namespace {

using rtl::DviLink;
using rtl::OutputFramebuffer;
using rtl::PipePixel;

constexpr int kWidth = 4;
constexpr int kHeight = 3;
constexpr int kPixels = kWidth * kHeight;
constexpr int kLine = line_clocks(kWidth);
constexpr int kDviFrame = frame_clocks(kWidth, kHeight);
/// The DVI clock at which the frame of the given number begins: one vertical sync comes first.
constexpr int dvi_frame_start(int number) { return kSyncLines * kLine + number * kDviFrame; }

enum class Swaplock { kOwnFramedone, kDriven };

/// An output framebuffer between a pipeline that the test plays and a DVI link that it records. The link's timing is
/// watched by its monitor.
struct OutputBench {
    Scenario scenario;
    ClockDomain& core;
    ClockDomain& dvi;
    sc_core::sc_signal<bool> startframe;
    sc_core::sc_signal<PipePixel> pipe;
    sc_core::sc_signal<bool> column_stall;
    sc_core::sc_signal<bool> swaplock;
    sc_core::sc_signal<bool> pipeready;
    sc_core::sc_signal<bool> framedone;
    sc_core::sc_signal<bool> framebad;
    sc_core::sc_signal<bool> swapskip;  ///< unused with Swaplock::kOwnFramedone
    sc_core::sc_signal<DviLink> link;
    OutputFramebuffer framebuffer;
    monitors::ViolationLog violations;
    monitors::DviMonitor monitor;
    const Recording<bool>& pipereadies;
    const Recording<bool>& framedones;
    const Recording<bool>& framebads;
    const Recording<DviLink>& links;

    OutputBench(ClockedTestbench& bench, const std::string& name, Scenario with, ClockDomain& dvi_domain,
                Swaplock swaplock_from = Swaplock::kOwnFramedone)
        : scenario(std::move(with)),
          core(bench.core),
          dvi(dvi_domain),
          framebuffer(name.c_str(), scenario, 1),
          monitor((name + "_monitor").c_str(), monitored_link(), violations),
          pipereadies(bench.core.record(pipeready)),
          framedones(bench.core.record(framedone)),
          framebads(bench.core.record(framebad)),
          links(dvi_domain.record(link)) {
        framebuffer.clk_i(bench.core.clk);
        framebuffer.reset_i(bench.reset);
        framebuffer.dvi_clk_i(dvi_domain.clk);
        framebuffer.startframe_i(startframe);
        framebuffer.pipe_i(pipe);
        framebuffer.column_stall_i(column_stall);
        framebuffer.pipeready_o(pipeready);
        framebuffer.framedone_o(framedone);
        framebuffer.framebad_o(framebad);
        if (swaplock_from == Swaplock::kOwnFramedone) {
            framebuffer.swaplock_i(framedone);  // a single display
            framebuffer.swapskip_i(framebad);
        } else {
            framebuffer.swaplock_i(swaplock);
            framebuffer.swapskip_i(swapskip);
        }
        framebuffer.link_o(link);
        monitor.clk_i(dvi_domain.clk);
        monitor.reset_i(bench.reset);
        monitor.link_i(link);
        bench.trace(framebuffer);
    }

    monitors::DviMonitor::Link monitored_link() const {
        const DviTiming timing = scenario.displays.timing();
        return {monitors::DviMonitor::Kind::kOutput, timing, "link", "dvi_out",
                [] { return monitors::DviMonitor::Frame{}; }};
    }

    /// STARTFRAME at edge `clock`, the raster's pixels at the edges after it. In stalled clocks the pipeline's pixel
    /// stands still, as its registers would hold it.
    void send_frame(int clock, const std::vector<Pixel>& raster, const std::vector<int>& stalled = {},
                    const std::vector<int>& lost = {}) {
        const auto is_stalled = [&stalled](int at) {
            return std::find(stalled.begin(), stalled.end(), at) != stalled.end();
        };
        for (const int at : stalled) core.pulse(column_stall, at);
        core.drive(startframe, clock, true);
        while (is_stalled(clock)) ++clock;
        core.drive(startframe, ++clock, false);
        for (std::size_t i = 0; i < raster.size(); ++i) {
            const bool is_lost = std::find(lost.begin(), lost.end(), static_cast<int>(i)) != lost.end();
            core.drive(pipe, clock, PipePixel{raster[i], true, is_lost});
            while (is_stalled(clock)) ++clock;
            ++clock;
        }
        core.drive(pipe, clock, PipePixel{});
    }
};

Scenario output_scenario(int supersample = 1, StarvationMode mode = StarvationMode::kGlitch) {
    Scenario scenario = small_scenario(kWidth, kHeight);
    scenario.displays.supersample = supersample;
    scenario.composer.on_starvation = mode;
    return scenario;
}

std::vector<Pixel> raster(std::uint64_t seed, int pixels = kPixels) {
    return noise_image(seed, pixels, 1).values;
}

LinkLines shown(const std::vector<Pixel>& pixels) {
    LinkLines lines(kHeight);
    for (std::size_t i = 0; i < pixels.size(); ++i) lines[i / kWidth].push_back(pixels[i].rgb());
    return lines;
}
LinkLines black() { return LinkLines(kHeight, std::vector<std::uint32_t>(kWidth, 0)); }

/// What the link must show from DVI clock 0 on: one vertical sync, then these pictures.
Waveform display_wave(const std::vector<LinkLines>& pictures) {
    Waveform wave;
    append_blank_lines(wave, kWidth, kSyncLines, true);
    for (const LinkLines& picture : pictures) append_frame(wave, kWidth, picture);
    return wave;
}

void check_wave(const Recording<DviLink>& links, const Waveform& wanted) {
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const auto clock = static_cast<int>(i);
        INFO("DVI clock " << clock << ": " << links.at(clock) << " for " << wanted[i]);
        REQUIRE(links.at(clock) == wanted[i]);
    }
}

TEST_CASE("output framebuffer: in reset all is low, PIPEREADY rises at the first clock after it") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core);
    bench.run_through(20);
    CHECK_FALSE(dut.pipereadies.at(-1));
    CHECK(dut.pipereadies.high() == clock_range(0, 21));
    CHECK_FALSE(dut.framedones.at(-1));
    CHECK(dut.framedones.high().empty());
    CHECK(dut.links.at(-1) == DviLink{});
}

TEST_CASE("output framebuffer: timing: last raster pixel read FRAMEDONE written at that edge") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core, Swaplock::kDriven);
    const int start = 30;
    dut.send_frame(start, raster(31));
    bench.run_through(start + kPixels + 200);
    CHECK(dut.pipereadies.falls() == std::vector<int>{start});
    CHECK(dut.pipereadies.high().back() == start - 1);
    // Pixel 0 is sampled at start + 1, the last one at start + kPixels.
    CHECK(dut.framedones.rises() == std::vector<int>{start + kPixels});
    CHECK(dut.framedones.falls().empty());  // SWAPLOCK has never come
}

TEST_CASE("output framebuffer: timing: STARTFRAME read to raster pixel 0 read") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core);
    const int start = 10;
    const auto pixels = raster(32);
    dut.send_frame(start, pixels);
    // Before and after the frame the pipeline shows valid pixels that do not belong to it.
    bench.core.drive(dut.pipe, start, PipePixel{Pixel(0x123456U), true});
    bench.core.drive(dut.pipe, start + kPixels + 1, PipePixel{Pixel(0x654321U), true});
    bench.run_through(dvi_frame_start(1));
    check_wave(dut.links, display_wave({shown(pixels)}));
}

TEST_CASE("output framebuffer: timing: blanking a line a frame") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core);
    bench.run_through(dvi_frame_start(3));
    check_wave(dut.links, display_wave({black(), black(), black()}));
    CHECK(dut.framebuffer.front_frame() == -1);
}

TEST_CASE(
    "output framebuffer: timing: SWAPLOCK to swap registers of the DVI clock then the next DVI frames first "
    "clock") {
    ClockedTestbench bench;
    OutputBench in_time(bench, "in_time", output_scenario(), bench.core, Swaplock::kDriven);
    OutputBench late(bench, "late", output_scenario(), bench.core, Swaplock::kDriven);
    const auto pixels = raster(33);
    in_time.send_frame(10, pixels);
    late.send_frame(10, pixels);
    // Two registers: what edge n samples is seen at edge n + 1.
    const int frame_1 = dvi_frame_start(1);
    bench.core.drive(in_time.swaplock, frame_1 - 1, true);
    bench.core.drive(late.swaplock, frame_1, true);
    bench.run_through(dvi_frame_start(3));
    check_wave(in_time.links, display_wave({black(), shown(pixels), shown(pixels)}));
    check_wave(late.links, display_wave({black(), black(), shown(pixels)}));
    // The swap comes back through two registers: the edge after it captures it, the next one sees it.
    CHECK(in_time.framedones.falls() == std::vector<int>{frame_1 + 2});
    CHECK(late.framedones.falls() == std::vector<int>{dvi_frame_start(2) + 2});
    CHECK(in_time.pipereadies.rises() == std::vector<int>{0, frame_1 + 2});
    CHECK(late.pipereadies.rises() == std::vector<int>{0, dvi_frame_start(2) + 2});
}

TEST_CASE("output framebuffer: without SWAPLOCK a whole frame waits, however many DVI frames go by") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core, Swaplock::kDriven);
    dut.send_frame(10, raster(34));
    bench.run_through(dvi_frame_start(4));
    CHECK(dut.framedones.falls().empty());
    CHECK(dut.pipereadies.falls() == std::vector<int>{10});
    CHECK(dut.pipereadies.rises() == std::vector<int>{0});
    check_wave(dut.links, display_wave({black(), black(), black(), black()}));
}

TEST_CASE("output framebuffer: one bank is shown, and again and again, while the other is filled and waits") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core);
    const std::vector<std::vector<Pixel>> frames = {raster(35), raster(36), raster(37)};
    dut.send_frame(10, frames[0]);
    // Shown from DVI frame 0 on. The next one comes in at once, the third only while DVI frame 2 is shown.
    const int swap_0 = dvi_frame_start(0);
    dut.send_frame(swap_0 + 3, frames[1]);
    dut.send_frame(dvi_frame_start(2) + 7, frames[2]);
    bench.run_through(dvi_frame_start(5));
    CHECK(dut.framedones.rises() ==
          std::vector<int>{10 + kPixels, swap_0 + 3 + kPixels, dvi_frame_start(2) + 7 + kPixels});
    CHECK(dut.framedones.falls() ==
          std::vector<int>{swap_0 + 2, dvi_frame_start(1) + 2, dvi_frame_start(3) + 2});
    check_wave(dut.links, display_wave({shown(frames[0]), shown(frames[1]), shown(frames[1]),
                                        shown(frames[2]), shown(frames[2])}));
    CHECK(dut.framebuffer.front_frame() == 2);
}

// ---- averaging ----

/// Each channel of each block: the sum plus half the block's size, divided by the block's size.
LinkLines averaged(const std::vector<Pixel>& pixels, int s) {
    LinkLines lines(kHeight, std::vector<std::uint32_t>(kWidth));
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            int red = 0;
            int green = 0;
            int blue = 0;
            for (int j = 0; j < s; ++j) {
                for (int i = 0; i < s; ++i) {
                    const Pixel pixel =
                        pixels[static_cast<std::size_t>((y * s + j) * kWidth * s + x * s + i)];
                    red += pixel.r();
                    green += pixel.g();
                    blue += pixel.b();
                }
            }
            const int block = s * s;
            const auto mean = [block](int sum) {
                return static_cast<std::uint32_t>((sum + block / 2) / block);
            };
            lines[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] =
                (mean(red) << 16) | (mean(green) << 8) | mean(blue);
        }
    }
    return lines;
}

TEST_CASE("output framebuffer: averages each block of 2 x 2 and 4 x 4, again in every frame") {
    ClockedTestbench bench;
    OutputBench two(bench, "two", output_scenario(2), bench.core);
    OutputBench four(bench, "four", output_scenario(4), bench.core);
    for (OutputBench* dut : {&two, &four}) {
        const int s = dut == &two ? 2 : 4;
        dut->send_frame(10, raster(40, kPixels * s * s));
        dut->send_frame(dvi_frame_start(0) + 3, raster(41, kPixels * s * s));
    }
    bench.run_through(dvi_frame_start(2));
    for (OutputBench* dut : {&two, &four}) {
        const int s = dut == &two ? 2 : 4;
        INFO("supersample " << s);
        const int raster_pixels = kPixels * s * s;
        CHECK(dut->framedones.rises() ==
              std::vector<int>{10 + raster_pixels, dvi_frame_start(0) + 3 + raster_pixels});
        check_wave(dut->links, display_wave({averaged(raster(40, raster_pixels), s),
                                             averaged(raster(41, raster_pixels), s)}));
    }
}

// ---- colour correction ----

LinkLines corrected_lines(LinkLines lines, const ColourTable& table) {
    for (std::vector<std::uint32_t>& line : lines) {
        ColourImage picture(static_cast<int>(line.size()), 1);
        picture.values = line;
        line = naive_correction(table, picture).values;
    }
    return lines;
}

TEST_CASE(
    "output framebuffer: its own table corrects what is averaged, at the same clocks, and black stays before "
    "the first swap") {
    ClockedTestbench bench;
    Random random(81);
    DisplayCorrection own;
    own.display = 1;
    own.lut = std::make_shared<const ColourTable>(random_colour_table(random));
    DisplayCorrection another = own;
    another.display = 2;
    another.lut = std::make_shared<const ColourTable>(random_colour_table(random));
    Scenario with_own = output_scenario();
    with_own.displays.columns = 2;
    with_own.displays.correction = {another, own};
    Scenario averaging = output_scenario(2);
    averaging.displays.correction = {own};
    Scenario with_another = with_own;
    with_another.displays.correction = {another};
    OutputBench plain(bench, "plain", output_scenario(), bench.core);
    OutputBench corrected(bench, "corrected", with_own, bench.core);
    OutputBench averaged_first(bench, "averaged_first", averaging, bench.core);
    OutputBench not_its_own(bench, "not_its_own", with_another, bench.core);
    const int start = dvi_frame_start(0) + 3;
    const int second = dvi_frame_start(1) + 3;
    const auto pixels = raster(82);
    const auto blocks = raster(83, 4 * kPixels);
    for (OutputBench* dut : {&plain, &corrected, &not_its_own}) {
        dut->send_frame(start, pixels);
        dut->send_frame(second, raster(84));
    }
    averaged_first.send_frame(start, blocks);
    bench.run_through(dvi_frame_start(3));
    for (const OutputBench* dut : {&corrected, &not_its_own}) {
        CHECK(dut->framedones.rises() == plain.framedones.rises());
        CHECK(dut->framedones.falls() == plain.framedones.falls());
        CHECK(dut->pipereadies.rises() == plain.pipereadies.rises());
    }
    const LinkLines of_second = shown(raster(84));
    check_wave(plain.links, display_wave({black(), shown(pixels), of_second}));
    check_wave(not_its_own.links, display_wave({black(), shown(pixels), of_second}));
    check_wave(corrected.links, display_wave({black(), corrected_lines(shown(pixels), *own.lut),
                                              corrected_lines(of_second, *own.lut)}));
    check_wave(averaged_first.links, display_wave({black(), corrected_lines(averaged(blocks, 2), *own.lut)}));
}

// ---- stall ----

TEST_CASE(
    "output framebuffer: while COLUMNSTALL is high no pixel is received, and the frame ends that much "
    "later") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(1, StarvationMode::kStall), bench.core);
    const int start = 20;
    const auto pixels = raster(42);
    // At the first pixel, three in a row, one in the middle, and at the last pixel.
    const std::vector<int> stalled = {start + 1, start + 5, start + 6,
                                      start + 7, start + 9, start + kPixels + 5};
    dut.send_frame(start, pixels, stalled);
    bench.run_through(dvi_frame_start(1));
    CHECK(dut.framedones.rises() == std::vector<int>{start + kPixels + 6});
    CHECK(dut.framebuffer.stalled_cycles() == 6);
    check_wave(dut.links, display_wave({shown(pixels)}));
}

TEST_CASE("output framebuffer: a STARTFRAME held by COLUMNSTALL counts when the column moves on") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(1, StarvationMode::kStall), bench.core);
    const int start = 20;
    const auto pixels = raster(43);
    dut.send_frame(start, pixels, {start, start + 1});
    bench.run_through(dvi_frame_start(1));
    CHECK(dut.pipereadies.falls() == std::vector<int>{start + 2});
    CHECK(dut.framedones.rises() == std::vector<int>{start + 2 + kPixels});
    check_wave(dut.links, display_wave({shown(pixels)}));
}

TEST_CASE(
    "output framebuffer: every clock that the column stands still is counted, a frame under way or not") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(1, StarvationMode::kStall), bench.core);
    bench.core.drive(dut.column_stall, 100, true);
    bench.core.drive(dut.column_stall, 117, false);
    bench.core.pulse(dut.column_stall, 300);
    bench.run_through(400);
    CHECK(dut.framebuffer.stalled_cycles() == 17 + 1);
}

// ---- frames of lost pixels ----

TEST_CASE(
    "output framebuffer: timing: first pixel marked as lost read FRAMEBAD written at that edge at the latest "
    "with FRAMEDONE") {
    ClockedTestbench bench;
    OutputBench early(bench, "early", output_scenario(), bench.core);
    OutputBench last(bench, "last", output_scenario(), bench.core);
    const int start = 10;
    early.send_frame(start, raster(70), {}, {4, 5});
    last.send_frame(start, raster(71), {}, {kPixels - 1});
    bench.run_through(dvi_frame_start(2));
    const int swap = dvi_frame_start(0);
    CHECK(early.framebads.high() == clock_range(start + 1 + 4, swap + 2));
    // At the latest with FRAMEDONE.
    CHECK(last.framebads.high() == clock_range(start + kPixels, swap + 2));
    CHECK(last.framedones.high() == last.framebads.high());
}

TEST_CASE("output framebuffer: with SWAPSKIP the picture stays and the frame's bank is free again") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core);
    const std::vector<std::vector<Pixel>> frames = {raster(72), raster(73), raster(74), raster(75),
                                                    raster(76)};
    // Frames 0, 2 and 3 have lost pixels: nothing to show yet, then twice the picture of frame 1.
    const std::set<int> bad = {0, 2, 3};
    for (int frame = 0; frame < 5; ++frame) {
        const int clock = frame == 0 ? 10 : dvi_frame_start(frame - 1) + 3;
        dut.send_frame(clock, frames[static_cast<std::size_t>(frame)], {},
                       bad.count(frame) != 0 ? std::vector<int>{frame} : std::vector<int>{});
    }
    bench.run_through(dvi_frame_start(6));
    check_wave(dut.links, display_wave({black(), shown(frames[1]), shown(frames[1]), shown(frames[1]),
                                        shown(frames[4]), shown(frames[4])}));
    CHECK(dut.framedones.falls() == std::vector<int>{dvi_frame_start(0) + 2, dvi_frame_start(1) + 2,
                                                     dvi_frame_start(2) + 2, dvi_frame_start(3) + 2,
                                                     dvi_frame_start(4) + 2});
    CHECK(dut.framebuffer.front_frame() == 4);
    CHECK(dut.framebuffer.kept_frames() == 3);
}

TEST_CASE("output framebuffer: SWAPSKIP of another display keeps a good frame off this display") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core, Swaplock::kDriven);
    const auto first = raster(77);
    const auto second = raster(78);
    const auto third = raster(79);
    dut.send_frame(10, first);
    dut.send_frame(dvi_frame_start(0) + 3, second);
    dut.send_frame(dvi_frame_start(1) + 3, third);
    for (int frame = 0; frame < 3; ++frame) {
        const int done = (frame == 0 ? 10 : dvi_frame_start(frame - 1) + 3) + kPixels;
        const int swap_back = dvi_frame_start(frame) + 3;
        bench.core.drive(dut.swaplock, done + 1, true);
        bench.core.drive(dut.swaplock, swap_back, false);
        if (frame != 1) continue;
        bench.core.drive(dut.swapskip, done + 1, true);
        bench.core.drive(dut.swapskip, swap_back, false);
    }
    bench.run_through(dvi_frame_start(4));
    check_wave(dut.links, display_wave({shown(first), shown(first), shown(third), shown(third)}));
    CHECK(dut.framebads.high().empty());
    CHECK(dut.framebuffer.kept_frames() == 1);
    CHECK(dut.framebuffer.front_frame() == 2);
}

TEST_CASE(
    "output framebuffer: timing: SWAPSKIP is read at the edge that sees SWAPLOCK without registers of its "
    "own") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core, Swaplock::kDriven);
    const auto pixels = raster(80);
    dut.send_frame(10, pixels);
    // Both rise for the last edge that can cause the swap. They are seen one edge later, at the frame's first clock.
    const int frame_1 = dvi_frame_start(1);
    bench.core.drive(dut.swaplock, frame_1 - 1, true);
    bench.core.drive(dut.swapskip, frame_1 - 1, true);
    bench.core.drive(dut.swaplock, frame_1 + 3, false);
    bench.core.drive(dut.swapskip, frame_1 + 3, false);
    bench.run_through(dvi_frame_start(3));
    check_wave(dut.links, display_wave({black(), black(), black()}));
    CHECK(dut.framebuffer.kept_frames() == 1);
    CHECK(dut.pipereadies.rises() == std::vector<int>{0, frame_1 + 2});
}

// ---- two clocks ----

/// The pipeline of a test that sends frame after frame as soon as PIPEREADY is high, `gap` clocks later.
struct EagerPipeline {
    /// Frames of odd number lose a pixel if `lossy`.
    EagerPipeline(OutputBench& dut, int frames, int gap, bool lossy = false) {
        dut.core.each_clock([this, &dut, frames, gap, lossy](int) {
            if (position_ < 0) {
                dut.pipe.write(PipePixel{});
                ready_for_ = dut.pipeready.read() ? ready_for_ + 1 : 0;
                if (ready_for_ > gap && frame_ + 1 < frames) {
                    ready_for_ = 0;
                    ++frame_;
                    position_ = 0;
                    dut.startframe.write(true);
                }
                return;
            }
            dut.startframe.write(false);
            const auto pixels = raster(50 + static_cast<std::uint64_t>(frame_));
            const bool lost = lossy && frame_ % 2 == 1 && position_ == kPixels - 1;
            dut.pipe.write(PipePixel{pixels[static_cast<std::size_t>(position_)], true, lost});
            position_ = position_ + 1 == kPixels ? -1 : position_ + 1;
        });
    }

  private:
    int frame_ = -1;
    int position_ = -1;
    int ready_for_ = 0;
};

void check_clock_ratio(std::int64_t dvi_period_picoseconds, int gap) {
    constexpr int kFrames = 4;
    constexpr int kDviFrames = kFrames + 2;
    ClockedTestbench bench;
    ClockDomain& dvi = bench.add_clock("dvi", dvi_period_picoseconds);
    OutputBench dut(bench, "dut", output_scenario(), dvi);
    EagerPipeline pipeline(dut, kFrames, gap);
    const std::int64_t dvi_clocks = dvi_frame_start(kDviFrames) + 4;
    bench.run_through(
        static_cast<int>(dvi_clocks * dvi_period_picoseconds / ClockedTestbench::kCorePeriodPicoseconds));

    const std::vector<int> done = dut.framedones.rises();
    const std::vector<int> free = dut.framedones.falls();
    REQUIRE(done.size() == kFrames);
    REQUIRE(free.size() == kFrames);
    std::vector<LinkLines> pictures;
    int next_dvi_frame = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
        // The first DVI frame at whose first clock SWAPLOCK's rise has been seen.
        const int seen = seen_at(bench.core, done[static_cast<std::size_t>(frame)], dvi);
        while (dvi_frame_start(next_dvi_frame) < seen) {
            pictures.push_back(pictures.empty() ? black() : pictures.back());
            ++next_dvi_frame;
        }
        pictures.push_back(shown(raster(50 + static_cast<std::uint64_t>(frame))));
        INFO("frame " << frame << ", done at core clock " << done[static_cast<std::size_t>(frame)]
                      << ", seen at DVI clock " << seen << ", shown from DVI frame " << next_dvi_frame);
        CHECK(free[static_cast<std::size_t>(frame)] ==
              seen_at(dvi, dvi_frame_start(next_dvi_frame), bench.core));
        ++next_dvi_frame;
    }
    while (static_cast<int>(pictures.size()) < kDviFrames) pictures.push_back(pictures.back());
    pictures.resize(kDviFrames);
    check_wave(dut.links, display_wave(pictures));
}

/// Sends frame after frame, every other one with lost pixels: only the good ones are shown, in their order.
void check_lossy_clock_ratio(std::int64_t dvi_period_picoseconds, int gap) {
    constexpr int kFrames = 5;
    constexpr int kDviFrames = kFrames + 3;
    ClockedTestbench bench;
    ClockDomain& dvi = bench.add_clock("dvi", dvi_period_picoseconds);
    OutputBench dut(bench, "dut", output_scenario(), dvi);
    EagerPipeline pipeline(dut, kFrames, gap, true);
    const std::int64_t dvi_clocks = dvi_frame_start(kDviFrames) + 4;
    bench.run_through(
        static_cast<int>(dvi_clocks * dvi_period_picoseconds / ClockedTestbench::kCorePeriodPicoseconds));
    const std::vector<int> done = dut.framedones.rises();
    REQUIRE(done.size() == kFrames);
    std::vector<LinkLines> pictures;
    LinkLines on_display = black();
    int next_dvi_frame = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
        const int seen = seen_at(bench.core, done[static_cast<std::size_t>(frame)], dvi);
        while (dvi_frame_start(next_dvi_frame) < seen) {
            pictures.push_back(on_display);
            ++next_dvi_frame;
        }
        if (frame % 2 == 0) on_display = shown(raster(50 + static_cast<std::uint64_t>(frame)));
        pictures.push_back(on_display);
        ++next_dvi_frame;
    }
    while (static_cast<int>(pictures.size()) < kDviFrames) pictures.push_back(pictures.back());
    pictures.resize(kDviFrames);
    check_wave(dut.links, display_wave(pictures));
    CHECK(dut.framebuffer.kept_frames() == 2);
    CHECK(dut.framebuffer.front_frame() == kFrames - 1);
    for (const std::size_t frame : {1, 3}) {
        CHECK(dut.framebads.at(done[frame]));
        CHECK(dut.framebads.rises()[frame / 2] <= done[frame]);
    }
    CHECK(dut.framebads.falls() == std::vector<int>{dut.framedones.falls()[1], dut.framedones.falls()[3]});
}

TEST_CASE("output framebuffer: frames of lost pixels with a faster DVI clock") {
    check_lossy_clock_ratio(7'300, 2);
}
TEST_CASE("output framebuffer: frames of lost pixels with a slower DVI clock") {
    check_lossy_clock_ratio(23'700, 5);
}
TEST_CASE("output framebuffer: frames of lost pixels with a DVI clock of nearly the core's period") {
    check_lossy_clock_ratio(10'010, 1);
}
TEST_CASE("output framebuffer: frames of lost pixels with a DVI clock slower than a frame") {
    check_lossy_clock_ratio(500'000, 0);
}

TEST_CASE(
    "output framebuffer: timing: swap to FRAMEDONE and FRAMEBAD low and PIPEREADY high registers of the core "
    "clock") {
    check_clock_ratio(7'300, 2);
}
TEST_CASE("output framebuffer: a slower DVI clock, each crossing at its two registers' clock") {
    check_clock_ratio(23'700, 5);
}
TEST_CASE("output framebuffer: a DVI clock of nearly the core's period, each crossing at its clock") {
    check_clock_ratio(10'010, 1);
}

TEST_CASE(
    "output framebuffer: a DVI clock so slow that a whole frame fits one of its clocks misses no swap") {
    check_clock_ratio(500'000, 0);
}

// ---- what must not happen ----

TEST_CASE("output framebuffer: a bubble in the pipeline is reported") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core);
    ExpectedReport report("/metabuffer/output_framebuffer/bubble");
    const int start = 10;
    dut.send_frame(start, raster(60));
    bench.core.drive(dut.pipe, start + 4, PipePixel{});
    bench.run_through(start + 3);
    CHECK(report.count() == 0);
    bench.run_through(start + 4);
    CHECK(report.count() == 1);
}

TEST_CASE("output framebuffer: a reset in the middle of a frame starts everything again") {
    ClockedTestbench bench;
    OutputBench dut(bench, "dut", output_scenario(), bench.core);
    const int restart = dvi_frame_start(1) + 5;
    dut.send_frame(10, raster(61));
    dut.send_frame(restart - 5, raster(62));
    bench.core.pulse(bench.reset, restart);
    // The pixels of the frame that was cut still come down the pipeline and must be ignored. The first DVI
    // frame is black again, whatever the banks hold.
    const int start = restart + 1 + dvi_frame_start(0) + 20;
    dut.send_frame(start, raster(63));
    bench.run_through(restart + 1 + dvi_frame_start(2));
    CHECK_FALSE(dut.pipereadies.at(restart));
    CHECK(dut.pipereadies.at(restart + 1));
    CHECK_FALSE(dut.framedones.at(restart));
    CHECK(dut.framedones.at(start + kPixels));
    const Waveform wanted = display_wave({black(), shown(raster(63))});
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const int clock = restart + 1 + static_cast<int>(i);
        INFO("clock " << clock);
        REQUIRE(dut.links.at(clock) == wanted[i]);
    }
}

}  // namespace
}  // namespace metabuffer::test::output_framebuffer_test
