#include "rtl/dvi_output.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "dvi_waveform.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

namespace metabuffer::test::dvi_output_test {
namespace {

using rtl::DisplayRead;
using rtl::DviLink;
using rtl::DviOutput;
using Clocks = std::vector<int>;
using Colours = std::vector<std::uint32_t>;

/// A display's timing between its memory, whose two banks the test fills, and its link.
struct DviBench {
    int width, height;
    ClockDomain& dvi;
    sc_core::sc_signal<bool> swaplock, swapskip, swapped, skipped, reads;
    sc_core::sc_signal<DisplayRead> read;
    sc_core::sc_signal<std::uint32_t> data;
    sc_core::sc_signal<DviLink> link;
    DviOutput dut;
    const Recording<bool>& swaps;
    const Recording<bool>& skips;
    const Recording<bool>& reading;
    const Recording<DisplayRead>& asked;
    const Recording<DviLink>& links;
    std::array<Colours, 2> banks;

    DviBench(ClockedTestbench& bench, ClockDomain& domain, int display_width = 4, int display_height = 3,
             const std::string& name = "dvi_output")
        : width(display_width),
          height(display_height),
          dvi(domain),
          dut(name.c_str(), small_scenario(width, height)),
          swaps(dvi.record(swapped)),
          skips(dvi.record(skipped)),
          reading(dvi.record(reads)),
          asked(dvi.record(read)),
          links(dvi.record(link)) {
        dut.clk_i(dvi.clk);
        dut.reset_i(bench.reset);
        dut.swaplock_i(swaplock);
        dut.swapskip_i(swapskip);
        dut.swapped_o(swapped);
        dut.skipped_o(skipped);
        dut.reads_o(reads);
        dut.read_o(read);
        dut.data_i(data);
        dut.link_o(link);
        bench.trace(dut);
        for (std::size_t bank = 0; bank < 2; ++bank)
            fill(bank == 1, static_cast<std::uint32_t>(0x10000 + bank));
        dvi.each_clock([this](int) {
            // What an edge reads stands after it. Edge n - 1 has read what stood at read_o after edge n - 2.
            data.write(word_);
            if (reads.read()) word_ = banks[read.read().bank ? 1 : 0].at(read.read().address);
        });
    }
    /// A picture that differs from all others.
    void fill(bool bank, std::uint32_t tag) {
        Colours& picture = banks[bank ? 1 : 0];
        picture.clear();
        for (int i = 0; i < width * height; ++i) {
            picture.push_back((tag * 0x1003 + static_cast<std::uint32_t>(i) * 0x20105 + 1) & 0xFFFFFF);
        }
    }
    int line() const { return line_clocks(width); }
    /// The edge at which the frame of the given number begins: one vertical sync comes first.
    int frame_start(int number) const { return kSyncLines * line() + number * frame_clocks(width, height); }

    LinkLines shown(bool bank) const { return lines_of(banks[bank ? 1 : 0]); }
    LinkLines lines_of(const Colours& picture) const {
        LinkLines lines;
        for (int y = 0; y < height; ++y) {
            const auto first = picture.begin() + y * width;
            lines.emplace_back(first, first + width);
        }
        return lines;
    }
    LinkLines black() const { return lines_of(Colours(static_cast<std::size_t>(width * height), 0)); }
    /// From edge `from` on the link must show one vertical sync and then these pictures.
    void check(const std::vector<LinkLines>& pictures, int from = 0) const {
        Waveform wave;
        append_blank_lines(wave, width, kSyncLines, true);
        for (const LinkLines& picture : pictures) append_frame(wave, width, picture);
        for (std::size_t i = 0; i < wave.size(); ++i) {
            const int clock = from + static_cast<int>(i);
            INFO("clock " << clock << ": " << links.at(clock) << " for " << wave[i]);
            REQUIRE(links.at(clock) == wave[i]);
        }
    }

  private:
    std::uint32_t word_ = 0;
};

TEST_CASE(
    "dvi output: frames are black and of exact timing from reset on until the first swap, and read nothing") {
    ClockedTestbench bench;
    DviBench dut(bench, bench.core);
    bench.run_through(dut.frame_start(3));
    CHECK(dut.links.at(-1) == DviLink{});
    dut.check({dut.black(), dut.black(), dut.black()});
    CHECK(dut.reading.high().empty());
    CHECK(dut.swaps.high().empty());
    CHECK(dut.dut.front_frame() == -1);
}

TEST_CASE("dvi output: SWAPLOCK seen at a frame's first clock swaps there, a clock later it waits a frame") {
    ClockedTestbench bench;
    DviBench in_time(bench, bench.core, 4, 3, "in_time");
    DviBench late(bench, bench.core, 4, 3, "late");
    // Two registers: the edge before has captured it.
    bench.core.drive(in_time.swaplock, in_time.frame_start(1) - 1, true);
    bench.core.drive(late.swaplock, late.frame_start(1), true);
    bench.run_through(late.frame_start(3));
    CHECK(in_time.swaps.high() == clock_range(in_time.frame_start(1), in_time.frame_start(3) + 1));
    in_time.check({in_time.black(), in_time.shown(false), in_time.shown(false)});
    CHECK(late.swaps.high() == clock_range(late.frame_start(2), late.frame_start(3) + 1));
    late.check({late.black(), late.black(), late.shown(false)});
    CHECK(in_time.skips.high().empty());
    REQUIRE(in_time.dut.swaps().size() == 1);
    const std::int64_t edge = in_time.frame_start(1) + bench.core.reset_clocks();
    CHECK(in_time.dut.swaps()[0].picoseconds == edge * bench.core.period_picoseconds());
    CHECK(in_time.dut.front_frame() == 0);
}

TEST_CASE(
    "dvi output: the swap is reported until SWAPLOCK has been seen low, and only then is there another") {
    ClockedTestbench bench;
    DviBench dut(bench, bench.core);
    bench.core.drive(dut.swaplock, 5, true);
    // It stands over the start of a frame that has been swapped, and is low for a clock in the next.
    bench.core.drive(dut.swaplock, dut.frame_start(2) + 7, false);
    bench.core.drive(dut.swaplock, dut.frame_start(2) + 8, true);
    bench.run_through(dut.frame_start(5));
    CHECK(dut.swaps.rises() == Clocks{dut.frame_start(0), dut.frame_start(3)});
    CHECK(dut.swaps.falls() == Clocks{dut.frame_start(2) + 8});
    dut.check({dut.shown(false), dut.shown(false), dut.shown(false), dut.shown(true), dut.shown(true)});
    CHECK(dut.dut.front_frame() == 1);
}

TEST_CASE("dvi output: the banks are shown in turn") {
    ClockedTestbench bench;
    DviBench dut(bench, bench.core);
    for (int frame = 0; frame < 4; ++frame) {
        bench.core.drive(dut.swaplock, dut.frame_start(frame) - 100, true);
        bench.core.drive(dut.swaplock, dut.frame_start(frame) + 100, false);
    }
    bench.run_through(dut.frame_start(5));
    dut.check({dut.shown(false), dut.shown(true), dut.shown(false), dut.shown(true), dut.shown(true)});
    CHECK(dut.dut.swaps().size() == 4);
}

TEST_CASE("dvi output: with SWAPSKIP the display keeps its picture, and black before the first one") {
    ClockedTestbench bench;
    DviBench dut(bench, bench.core);
    const std::vector<bool> skip{true, false, true, true, false, false};
    for (int frame = 0; frame < 6; ++frame) {
        // The frames' end takes both low at once, and SWAPSKIP falls before SWAPLOCK is seen low.
        bench.core.drive(dut.swapskip, dut.frame_start(frame) - 100, skip[static_cast<std::size_t>(frame)]);
        bench.core.drive(dut.swaplock, dut.frame_start(frame) - 100, true);
        bench.core.drive(dut.swapskip, dut.frame_start(frame) + 100, false);
        bench.core.drive(dut.swaplock, dut.frame_start(frame) + 100, false);
    }
    bench.run_through(dut.frame_start(6));
    dut.check({dut.black(), dut.shown(false), dut.shown(false), dut.shown(false), dut.shown(true),
               dut.shown(false)});
    for (int frame = 0; frame < 6; ++frame) {
        INFO("frame " << frame);
        const int start = dut.frame_start(frame);
        for (const int clock : {start, start + 50, start + 100}) {
            CHECK(dut.swaps.at(clock));
            CHECK(dut.skips.at(clock) == skip[static_cast<std::size_t>(frame)]);
        }
        CHECK_FALSE(dut.swaps.at(start + 101));
        CHECK(dut.dut.swaps().at(static_cast<std::size_t>(frame)).kept ==
              skip[static_cast<std::size_t>(frame)]);
    }
    CHECK(dut.dut.kept_frames() == 3);
    CHECK(dut.dut.front_frame() == 5);
}

TEST_CASE("dvi output: a pixel is read two clocks before it is on the link, and nothing else is read") {
    ClockedTestbench bench;
    std::vector<std::unique_ptr<DviBench>> duts;
    for (int width = 1; width <= 3; ++width) {
        duts.push_back(std::make_unique<DviBench>(bench, bench.core, width, 4 - width,
                                                  "width_" + std::to_string(width)));
        bench.core.drive(duts.back()->swaplock, 5, true);
    }
    bench.run_through(duts.back()->frame_start(2) + frame_clocks(3, 3));
    for (const auto& dut : duts) {
        INFO(dut->width << " pixels wide");
        dut->check({dut->shown(false), dut->shown(false)});
        const int end = dut->frame_start(2);
        Clocks read, due;
        for (const int clock : dut->reading.high()) {
            if (clock + 2 < end) read.push_back(clock + 2);
        }
        for (int clock = 0; clock < end; ++clock) {
            if (dut->links.at(clock).de) due.push_back(clock);
        }
        CHECK(read == due);
        for (std::size_t i = 0; i < read.size(); ++i) {
            const auto address =
                static_cast<std::uint32_t>(i) % static_cast<std::uint32_t>(dut->width * dut->height);
            CHECK(dut->asked.at(read[i] - 2) == DisplayRead{false, address});
        }
    }
}

TEST_CASE("dvi output: reset in a frame leaves what power-up leaves") {
    ClockedTestbench bench;
    DviBench dut(bench, bench.core);
    bench.core.drive(dut.swaplock, 5, true);
    // In an active line of the second frame, with another swap to come.
    const int reset = dut.frame_start(1) + (kBackLines + 1) * dut.line() + 2;
    bench.core.drive(dut.swaplock, reset - 300, false);
    bench.core.drive(dut.swaplock, reset - 280, true);
    bench.core.drive(dut.swapskip, reset - 280, true);
    bench.core.drive(dut.swaplock, reset, false);
    bench.core.drive(dut.swapskip, reset, false);
    // While the swap is still reported.
    DviBench reporting(bench, bench.core, 4, 3, "reporting");
    bench.core.drive(reporting.swaplock, 5, true);
    bench.core.drive(reporting.swaplock, reset, false);
    bench.core.drive(bench.reset, reset, true);
    bench.core.drive(bench.reset, reset + 5, false);
    const int again = reset + 5;
    bench.core.drive(dut.swaplock, again + dut.frame_start(1) - 50, true);
    bench.run_through(again + dut.frame_start(3));
    CHECK(reporting.swaps.falls() == Clocks{reset});
    reporting.check({dut.black(), dut.black(), dut.black()}, again);
    CHECK(dut.links.at(reset - 1).de);
    CHECK(dut.links.at(reset) == DviLink{});
    CHECK(dut.reading.at(reset - 1));
    CHECK_FALSE(dut.reading.at(reset));
    CHECK(dut.asked.at(reset) == DisplayRead{});
    CHECK_FALSE(dut.swaps.at(reset));
    CHECK(dut.skips.at(reset - 1));
    CHECK_FALSE(dut.skips.at(reset));
    dut.check({dut.black(), dut.shown(false), dut.shown(false)}, again);
    CHECK(dut.dut.swaps().size() == 1);
    CHECK(dut.dut.front_frame() == 0);
}

TEST_CASE(
    "dvi output: SWAPLOCK of a core clock of any ratio swaps at the first frame that begins once it is "
    "seen") {
    ClockedTestbench bench;
    std::vector<std::unique_ptr<DviBench>> duts;
    for (const std::int64_t period : {3'344, 10'016, 16'656}) {
        const std::string name = "dvi_" + std::to_string(period);
        duts.push_back(
            std::make_unique<DviBench>(bench, bench.add_clock(name.c_str(), period), 1, 1, name + "_output"));
    }
    bench.run_through(0);
    std::vector<int> due;
    for (const auto& dut : duts) {
        const ClockDomain& dvi = dut->dvi;
        // About where the third frame begins: some see it in time and some do not.
        const std::int64_t begins = (dut->frame_start(3) + dvi.reset_clocks()) * dvi.period_picoseconds();
        const std::int64_t core_period = bench.core.period_picoseconds();
        const auto edge = static_cast<int>(begins / core_period) - bench.core.reset_clocks();
        bench.core.drive(dut->swaplock, edge, true);
        // It changes half a core clock before that edge.
        const std::int64_t time = (edge + bench.core.reset_clocks()) * core_period - core_period / 2;
        const auto seen = static_cast<int>(time / dvi.period_picoseconds()) + 2 - dvi.reset_clocks();
        due.push_back(dut->frame_start(seen <= dut->frame_start(3) ? 3 : 4));
    }
    bench.run_through(50'000);
    int waited = 0;
    for (std::size_t i = 0; i < duts.size(); ++i) {
        CHECK(duts[i]->swaps.rises() == Clocks{due[i]});
        waited += due[i] == duts[i]->frame_start(4) ? 1 : 0;
    }
    CHECK(waited > 0);
    CHECK(waited < 3);
}

TEST_CASE("dvi output: through random swaps and skips each frame shows the last good picture") {
    const auto seed = random_seed(2213);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    constexpr int kFrames = 40;
    ClockedTestbench bench;
    DviBench dut(bench, bench.core, random.between(1, 4), random.between(1, 3));
    std::vector<LinkLines> pictures;  // as each frame must show them
    LinkLines shown = dut.black();
    bool back = false, swaplock = false, skip = false, swapped = false, pending = false;
    bool seen = false, captured = false;
    int next_frame = 0;
    bench.core.each_clock([&](int clock) {
        if (swaplock ? swapped && random.one_in(300) : !swapped && random.one_in(300)) {
            swaplock = !swaplock;
            skip = swaplock && random.one_in(3);
            dut.swaplock.write(swaplock);
            dut.swapskip.write(skip);
            if (swaplock) dut.fill(back, static_cast<std::uint32_t>(clock));
        }
        seen = captured;
        captured = swaplock;
        if (!seen) swapped = false;
        pending = pending || (seen && !swapped);
        if (clock != dut.frame_start(next_frame)) return;
        ++next_frame;
        if (pending) {
            pending = false;
            swapped = true;
            if (!skip) {
                shown = dut.shown(back);
                back = !back;
            }
        }
        pictures.push_back(shown);
    });
    bench.run_through(dut.frame_start(kFrames));
    pictures.resize(kFrames);
    dut.check(pictures);
    CHECK(dut.dut.swaps().size() > 3);
}

}  // namespace
}  // namespace metabuffer::test::dvi_output_test
