#include "tlm/cycle.h"

#include <catch2/catch.hpp>
#include <cstdint>

#include "socket_bench.h"

namespace metabuffer::test::cycle_test {
namespace {

TEST_CASE(
    "clock domain: a time has an edge at or before it and one at or after it, the same if it is an edge's") {
    constexpr std::int64_t kPeriod = 7;
    const tlm::ClockDomain clock(kPeriod);
    for (std::int64_t edge = 0; edge < 5; ++edge) {
        const std::int64_t time = clock.picoseconds_of(edge);
        CHECK(time == edge * kPeriod);
        CHECK(clock.edge_at(time) == edge);
        CHECK(clock.edge_from(time) == edge);
        for (std::int64_t behind = 1; behind < kPeriod; ++behind) {
            CHECK(clock.edge_at(time + behind) == edge);
            CHECK(clock.edge_from(time + behind) == edge + 1);
        }
    }
}

TEST_CASE(
    "clock domain: a level from another domain is captured by the edge after its change and seen by the "
    "next") {
    const tlm::ClockDomain clock(7);
    CHECK(clock.edge_seeing(0) == 2);
    CHECK(clock.edge_seeing(6) == 2);
    CHECK(clock.edge_seeing(7) == 3);
}

TEST_CASE("clock domain: to wait for a clock that has passed is an error of the model") {
    const tlm::ClockDomain clock(7);
    sc_core::sc_start(sc_core::sc_time::from_value(14));
    CHECK(clock.until(2) == sc_core::SC_ZERO_TIME);
    CHECK(clock.until(3) == sc_core::sc_time::from_value(7));
    CHECK(report_of([&clock] { clock.until(1); }) == "/metabuffer/tlm/past");
}

}  // namespace
}  // namespace metabuffer::test::cycle_test
