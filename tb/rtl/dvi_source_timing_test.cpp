#include <catch2/catch.hpp>
#include <vector>

#include "clocked_testbench.h"
#include "rtl/dvi_source.h"
#include "support/images.h"
#include "support/scenarios.h"

namespace metabuffer::test::dvi_source_timing_test {
namespace {

using rtl::DviLink;

constexpr int kWidth = 8;
constexpr int kActiveLines = 3;
constexpr int kLine = kWidth + 8 + 32 + 40;
constexpr int kFrame = (6 + kActiveLines + 1 + 8) * kLine;
constexpr int kFirstSync = 8 * kLine;

/// A source that sends two pairs as they are asked for, from the first of these clocks on, up to the second one.
struct SourceBench {
    ClockedTestbench bench;
    Scenario scenario = two_pairs();
    sc_core::sc_signal<bool> request;
    sc_core::sc_signal<DviLink> link;
    sc_core::sc_signal<int> clock_ppm;
    sc_core::sc_signal<TmdsDisturbance> disturbance;
    rtl::DviSource source{"dvi_source", scenario, 0};
    const Recording<DviLink>& sent = bench.core.record(link);

    SourceBench(int first, int last) {
        source.clk_i(bench.core.clk);
        source.reset_i(bench.reset);
        source.pair_request_i(request);
        source.link_o(link);
        source.clock_ppm_o(clock_ppm);
        source.disturbance_o(disturbance);
        bench.core.drive(request, first, true);
        bench.run_through(last);
    }
    static Scenario two_pairs() {
        Scenario scenario =
            with_renderer(small_scenario(8, 8), renderer_of({noise_image(1, kWidth, kActiveLines - 1)}));
        scenario.frames = 2;
        return scenario;
    }
    /// The clocks at which a wire of the link changes to high or low.
    std::vector<int> changes(bool DviLink::*wire, bool to) const {
        std::vector<int> clocks;
        for (int clock = 0; clock < sent.end_clock(); ++clock) {
            if (sent.at(clock).*wire == to && sent.at(clock - 1).*wire != to) clocks.push_back(clock);
        }
        return clocks;
    }
};

TEST_CASE(
    "dvi source: timing: a pairs first clock is driven at the edge that reads the request if no pair is "
    "under way") {
    constexpr int kAsked = kFirstSync + 50;
    const SourceBench dut(kAsked, kAsked + kLine);
    constexpr int kFirstHsync = kAsked + kWidth + 8;
    CHECK_FALSE(dut.sent.at(kFirstHsync - 1).hsync);
    CHECK(dut.sent.at(kFirstHsync).hsync);
}

TEST_CASE(
    "dvi source: timing: clocks between the frames of a pair and between pairs while the request stands") {
    constexpr int kAsked = kFirstSync + 50;
    const SourceBench dut(kAsked, kAsked + 4 * kFrame);
    for (int frame = 1; frame < 4; ++frame) {
        const int first_hsync = kAsked + frame * kFrame + kWidth + 8;
        CHECK_FALSE(dut.sent.at(first_hsync - 1).hsync);
        CHECK(dut.sent.at(first_hsync).hsync);
        CHECK(dut.sent.at(kAsked + frame * kFrame - 1).vsync);
        CHECK_FALSE(dut.sent.at(kAsked + frame * kFrame).vsync);
    }
}

TEST_CASE("dvi source: timing: blanking a line a frame") {
    const SourceBench dut(0, kFirstSync + kFrame);
    std::vector<int> rises, falls, data, data_ends;
    for (int line = 0; line < kFrame / kLine; ++line) {
        const int start = kFirstSync + line * kLine;
        rises.push_back(start + kWidth + 8);
        falls.push_back(start + kWidth + 8 + 32);
        if (line < 6 || line >= 6 + kActiveLines) continue;
        data.push_back(start);
        data_ends.push_back(start + kWidth);
    }
    CHECK(dut.changes(&DviLink::hsync, true) == rises);
    CHECK(dut.changes(&DviLink::hsync, false) == falls);
    CHECK(dut.changes(&DviLink::de, true) == data);
    CHECK(dut.changes(&DviLink::de, false) == data_ends);
    CHECK(dut.changes(&DviLink::vsync, true) == std::vector<int>{0, kFirstSync + kFrame - 8 * kLine});
    CHECK(dut.changes(&DviLink::vsync, false) == std::vector<int>{kFirstSync, kFirstSync + kFrame});
}

}  // namespace
}  // namespace metabuffer::test::dvi_source_timing_test
