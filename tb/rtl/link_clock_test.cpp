#include "rtl/link_clock.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

namespace metabuffer::test::link_clock_test {
namespace {

using rtl::LinkClock;

constexpr std::int64_t kMillion = 1'000'000;

std::int64_t now_picoseconds() { return static_cast<std::int64_t>(sc_core::sc_time_stamp().value()); }

/// A link's clock with a deviation from the start on. It records when the clock rises and falls.
class ClockBench : public sc_core::sc_module {
  public:
    ClockBench(const sc_core::sc_module_name& name, std::int64_t period_picoseconds, int ppm)
        : sc_core::sc_module(name), ppm_("ppm", ppm), clock_("clock", period_picoseconds) {
        clock_.clock_ppm_i(ppm_);
        clock_.clk_o(clk_);
        SC_METHOD(rise);
        sensitive << clk_.posedge_event();
        dont_initialize();
        SC_METHOD(fall);
        sensitive << clk_.negedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(ClockBench);

    void set_ppm(int ppm) { ppm_.write(ppm); }

    std::vector<std::int64_t> rises_picoseconds;
    std::vector<std::int64_t> falls_picoseconds;

  private:
    void fall() { falls_picoseconds.push_back(now_picoseconds()); }
    void rise() { rises_picoseconds.push_back(now_picoseconds()); }

    sc_core::sc_signal<int> ppm_;
    sc_core::sc_signal<bool> clk_{"clk"};
    LinkClock clock_;
};

/// Edge n of a clock that is fast by so many millionths, rounded down to a picosecond.
std::vector<std::int64_t> exact_edges(std::int64_t period_picoseconds, int ppm, std::size_t count) {
    std::vector<std::int64_t> edges;
    for (std::size_t n = 0; n < count; ++n) {
        edges.push_back(static_cast<std::int64_t>(n) * period_picoseconds * kMillion / (kMillion + ppm));
    }
    return edges;
}

void check_edges(const ClockBench& bench, std::int64_t period_picoseconds, int ppm) {
    INFO(period_picoseconds << " ps, " << ppm << " ppm");
    REQUIRE(bench.rises_picoseconds.size() > 1000);
    CHECK(bench.rises_picoseconds == exact_edges(period_picoseconds, ppm, bench.rises_picoseconds.size()));
    // High for half of each period, and low for the other.
    REQUIRE(bench.falls_picoseconds.size() + 1 >= bench.rises_picoseconds.size());
    int uneven = 0;
    for (std::size_t n = 0; n + 1 < bench.rises_picoseconds.size(); ++n) {
        const std::int64_t high = bench.falls_picoseconds[n] - bench.rises_picoseconds[n];
        const std::int64_t low = bench.rises_picoseconds[n + 1] - bench.falls_picoseconds[n];
        uneven += high - low == 0 || high - low == 1 ? 0 : 1;
    }
    CHECK(uneven == 0);
}

TEST_CASE("link clock: edge n is at n periods divided by 1 + ppm / 10^6 and nothing is lost by rounding") {
    // Two periods of 4951 ps at 101 ppm are 9901 ps less a millionth of one: any error upwards would give 9901.
    ClockBench just_below("just_below", 4951, 101);
    ClockBench nominal("nominal", 10'000, 0);
    ClockBench fast("fast", 10'000, 100'000);
    ClockBench slow("slow", 6'667, -100'000);
    ClockBench crystal("crystal", 9'999, -50);
    sc_core::sc_start(sc_core::sc_time(20, sc_core::SC_US));
    check_edges(just_below, 4951, 101);
    check_edges(nominal, 10'000, 0);
    check_edges(fast, 10'000, 100'000);
    check_edges(slow, 6'667, -100'000);
    check_edges(crystal, 9'999, -50);
}

/// What a deviation leaves over in rounding is not carried into the next one.
TEST_CASE("link clock: timing: a change of its millionths to the first period of another length") {
    constexpr std::int64_t kPeriod = 9'999;
    ClockBench bench("bench", kPeriod, 101);
    std::vector<std::size_t> begins{0};  // the edges that read a deviation
    std::vector<int> deviations{101};
    for (const int next : {-50, 37, 100'000, -1, 333}) {
        sc_core::sc_start(sc_core::sc_time(3'217, sc_core::SC_NS));
        begins.push_back(bench.rises_picoseconds.size());
        deviations.push_back(next);
        bench.set_ppm(next);
    }
    sc_core::sc_start(sc_core::sc_time(3, sc_core::SC_US));
    for (std::size_t i = 0; i < begins.size(); ++i) {
        INFO(deviations[i] << " ppm");
        const bool is_last = i + 1 == begins.size();
        const std::size_t end = is_last ? bench.rises_picoseconds.size() : begins[i + 1] + 1;
        REQUIRE(end > begins[i] + 200);
        std::vector<std::int64_t> since;
        for (std::size_t n = begins[i]; n < end; ++n) {
            since.push_back(bench.rises_picoseconds[n] - bench.rises_picoseconds[begins[i]]);
        }
        CHECK(since == exact_edges(kPeriod, deviations[i], since.size()));
    }
}

}  // namespace
}  // namespace metabuffer::test::link_clock_test
