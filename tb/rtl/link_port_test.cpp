#include "rtl/link_port.h"

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "clocked_testbench.h"
#include "scenario/derived_timing.h"
#include "support/images.h"
#include "support/scenarios.h"

// BankKeeper's unit tests check which pair is answered when. The input framebuffer's tests check what the core sees of
// it at its pins. These tests check the port's own pins, at the link's clock.
namespace metabuffer::test::link_port_test {
namespace {

using rtl::DecodedPixel;
using rtl::DecoderEvent;
using rtl::LinkPort;
using rtl::MemoryWrite;

struct LinkBench {
    Scenario scenario;
    ClockDomain& link;
    sc_core::sc_signal<DecodedPixel> pixel;
    sc_core::sc_signal<DecoderEvent> event;
    sc_core::sc_signal<bool> request;
    sc_core::sc_signal<bool> pair_request;
    sc_core::sc_signal<bool> answer;
    sc_core::sc_signal<bool> fresh;
    sc_core::sc_signal<bool> front;
    sc_core::sc_signal<MemoryWrite> write;
    std::vector<std::uint32_t> accepted;
    int dropped = 0;
    LinkPort dut;
    const Recording<bool>& pair_requests;
    const Recording<bool>& answers;
    const Recording<bool>& freshes;
    const Recording<bool>& fronts;
    const Recording<MemoryWrite>& writes;

    explicit LinkBench(ClockedTestbench& bench, DepthFormat format = DepthFormat::kA8Z16)
        : scenario(make(format)),
          link(bench.core),
          dut("link_port", scenario, scenario.renderers[0],
              {[this](std::uint32_t pair) { accepted.push_back(pair); },
               [this](int pairs) { dropped += pairs; }}),
          pair_requests(link.record(pair_request)),
          answers(link.record(answer)),
          freshes(link.record(fresh)),
          fronts(link.record(front)),
          writes(link.record(write)) {
        dut.clk_i(link.clk);
        dut.reset_i(bench.reset);
        dut.pixel_i(pixel);
        dut.event_i(event);
        dut.request_i(request);
        dut.pair_request_o(pair_request);
        dut.answer_o(answer);
        dut.fresh_o(fresh);
        dut.front_o(front);
        dut.write_o(write);
        bench.trace(dut);
    }
    static Scenario make(DepthFormat format) {
        Scenario scenario = small_scenario(64, 64, 1);
        scenario.depth_format = format;
        scenario.renderers.push_back(renderer_of({PixelImage(16, 4)}));
        return scenario;
    }
    void put_pixel(int clock, FrameKind kind, std::uint32_t address, std::uint32_t data) {
        link.drive(pixel, clock, DecodedPixel{true, kind, address, data});
        link.drive(pixel, clock + 1, DecodedPixel{});
    }
    void tell(int clock, const DecoderEvent& what) {
        link.drive(event, clock, what);
        link.drive(event, clock + 1, DecoderEvent{});
    }
    void colour_start(int clock, std::uint32_t number) {
        DecoderEvent what;
        what.colour_start = true;
        what.number = number;
        tell(clock, what);
    }
    void pair_good(int clock, std::uint32_t number) {
        DecoderEvent what;
        what.pair_good = true;
        what.number = number;
        tell(clock, what);
    }
};

TEST_CASE("link port: a pixel is written to the back device a clock later, its half of the word alone") {
    ClockedTestbench bench;
    LinkBench dut(bench);
    dut.put_pixel(3, FrameKind::kColour, 7, 0x112233U);
    dut.put_pixel(5, FrameKind::kDepth, 9, 0x44BEEFU);
    bench.run_through(8);
    CHECK_FALSE(dut.writes.at(2).enable);
    CHECK(dut.writes.at(3) == MemoryWrite{true, 1, 7, 0x112233U, 0x07});
    CHECK_FALSE(dut.writes.at(4).enable);
    CHECK(dut.writes.at(5) == MemoryWrite{true, 1, 9, 0x0000'BEEF'4400'0000U, 0xF8});
    CHECK_FALSE(dut.writes.at(6).enable);
    CHECK(dut.dut.link_pixels() == 2);
}

TEST_CASE("link port: z24 has 24 bits of Z in the depth half, and alpha 255") {
    ClockedTestbench bench;
    LinkBench dut(bench, DepthFormat::kZ24);
    dut.put_pixel(3, FrameKind::kDepth, 0, 0xABCDEFU);
    bench.run_through(5);
    CHECK(dut.writes.at(3).data == 0x00AB'CDEF'FF00'0000U);
}

TEST_CASE("link port: a question is answered three edges later with a new pair, and the devices swap") {
    ClockedTestbench bench;
    LinkBench dut(bench);
    dut.colour_start(2, 0);
    dut.pair_good(10, 0);
    dut.link.drive(dut.request, 20, true);
    dut.put_pixel(25, FrameKind::kColour, 0, 1);  // of the next pair: into what was the front device
    bench.run_through(30);
    CHECK(dut.accepted == std::vector<std::uint32_t>{0});
    CHECK(dut.pair_requests.falls() == std::vector<int>{10});
    // Edge 20 captures it, edge 21 sees it.
    CHECK(dut.answers.rises() == std::vector<int>{21});
    CHECK(dut.fronts.rises() == std::vector<int>{21});
    CHECK(dut.freshes.rises() == std::vector<int>{21});
    CHECK(dut.pair_requests.rises().back() == 21);
    CHECK(dut.writes.at(25).device == 0);
    CHECK(dut.dut.front_source().pair == 0);
}

TEST_CASE(
    "link port: the wires beside an answer stand still until the next answer, which toggles the answer wire "
    "again") {
    ClockedTestbench bench;
    LinkBench dut(bench);
    dut.colour_start(2, 0);
    dut.pair_good(10, 0);
    dut.link.drive(dut.request, 20, true);
    dut.link.drive(dut.request, 40, false);  // pair 1 is lost: the front pair again
    DecoderEvent lost;
    lost.pair_lost = true;
    lost.lost_number = 1;
    dut.tell(60, lost);
    bench.run_through(70);
    CHECK(dut.answers.rises() == std::vector<int>{21});
    CHECK(dut.answers.falls() == std::vector<int>{60});
    CHECK(dut.freshes.falls() == std::vector<int>{60});
    CHECK(dut.fronts.falls().empty());
}

TEST_CASE("link port: a reset leaves what power-up leaves, whatever was under way") {
    // The same pair and question, after power-up in the first round and after a reset in each other.
    ClockedTestbench bench;
    LinkBench dut(bench);
    constexpr int kPeriod = 60;
    constexpr int kRounds = 12;
    for (int round = 0; round < kRounds; ++round) {
        const int start = round * kPeriod;
        dut.colour_start(start + 12, 0);
        dut.put_pixel(start + 13, FrameKind::kColour, 3, 0x55);
        dut.pair_good(start + 20, 0);
        dut.link.drive(dut.request, start + 26, true);
        dut.put_pixel(start + 36, FrameKind::kColour, 4, 0x66);
        dut.put_pixel(start + 37, FrameKind::kColour, 5, 0x77);
        // At another moment each time, before the next round. The bus side is reset as well.
        bench.core.pulse(bench.reset, start + 32 + 2 * round);
        dut.link.drive(dut.request, start + 32 + 2 * round, false);
    }
    bench.run_through(kRounds * kPeriod);
    CHECK(dut.accepted.size() == kRounds);
    for (int round = 0; round < kRounds; ++round) {
        INFO("reset in round " << round);
        const int reset = round * kPeriod + 32 + 2 * round;
        CHECK_FALSE(dut.pair_requests.at(reset));
        CHECK_FALSE(dut.answers.at(reset));
        CHECK_FALSE(dut.freshes.at(reset));
        CHECK_FALSE(dut.fronts.at(reset));
        CHECK(dut.writes.at(reset) == MemoryWrite{});
    }
    for (int round = 1; round < kRounds; ++round) {
        INFO("round " << round);
        for (int clock = 8; clock < 32; ++clock) {
            INFO("clock " << clock);
            const int now = round * kPeriod + clock;
            CHECK(dut.pair_requests.at(now) == dut.pair_requests.at(clock));
            CHECK(dut.answers.at(now) == dut.answers.at(clock));
            CHECK(dut.freshes.at(now) == dut.freshes.at(clock));
            CHECK(dut.fronts.at(now) == dut.fronts.at(clock));
            CHECK(dut.writes.at(now) == dut.writes.at(clock));
        }
    }
}

TEST_CASE("link port: after a reset the wait for a pair is counted from the reset on") {
    ClockedTestbench bench;
    LinkBench dut(bench);
    const auto timeout = static_cast<int>(link_timeout_clocks(dut.scenario, dut.scenario.renderers[0]));
    const int reset = 2 * timeout;
    bench.core.pulse(bench.reset, reset);
    dut.link.drive(dut.request, reset + 5, true);
    bench.run_through(reset + timeout + 4);
    CHECK_FALSE(dut.answers.at(reset + timeout - 1));
    CHECK(dut.answers.at(reset + timeout));
}

TEST_CASE("link port: after a reset the front device holds no pair") {
    ClockedTestbench bench;
    LinkBench dut(bench);
    dut.colour_start(2, 0);
    dut.pair_good(10, 0);
    dut.link.drive(dut.request, 20, true);
    bench.run_through(24);
    REQUIRE(dut.dut.front_source().pair == 0);
    bench.core.pulse(bench.reset, 26);
    bench.run_through(30);
    CHECK(dut.dut.front_source().pair == FrameSource{}.pair);
}

}  // namespace
}  // namespace metabuffer::test::link_port_test
