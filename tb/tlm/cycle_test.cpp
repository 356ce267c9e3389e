#include "tlm/cycle.h"

#include <catch2/catch.hpp>
#include <cstdint>

namespace metabuffer::test {
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

}  // namespace
}  // namespace metabuffer::test
