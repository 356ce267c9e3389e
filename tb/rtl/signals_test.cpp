#include "rtl/signals.h"

#include <catch2/catch.hpp>

#include "support/random_seed.h"
#include "support/scenarios.h"

namespace metabuffer::test {
namespace {

using rtl::BusBeat;

TEST_CASE("signals: a table row crosses the bus in two words and comes out as it went in") {
    const std::uint64_t seed = random_seed(7);
    INFO("seed " << seed);
    Random random(seed);
    for (int i = 0; i < 100; ++i) {
        ViewportRow row;
        row.dcomp = static_cast<std::uint16_t>(random.bits());
        row.sx = static_cast<std::uint16_t>(random.bits());
        row.sy = static_cast<std::uint16_t>(random.bits());
        row.sdx = static_cast<std::uint16_t>(random.bits());
        row.sdy = static_cast<std::uint16_t>(random.bits());
        row.dx = static_cast<std::int16_t>(random.bits());
        row.dy = static_cast<std::int16_t>(random.bits());
        row.dmultiple = static_cast<std::uint16_t>(random.bits());
        const auto frame = static_cast<std::uint8_t>(255 - i);
        const BusBeat beat =
            BusBeat::table_row(frame, 1000U + static_cast<std::uint32_t>(i), row, i % 2 == 0);
        CHECK(beat.kind == BusBeat::Kind::kTableRow);
        CHECK(beat.count == 2);
        CHECK(beat.destination == row.dcomp);
        CHECK(beat.last == (i % 2 == 0));
        CHECK(beat.frame == frame);
        CHECK(beat.first == 1000U + static_cast<std::uint32_t>(i));
        CHECK(beat.row() == row);
    }
}

TEST_CASE("signals: a frame's start carries no word and tells whether a table follows") {
    for (const bool last : {false, true}) {
        const BusBeat beat = BusBeat::frame_start(200, last);
        CHECK(beat.kind == BusBeat::Kind::kFrameStart);
        CHECK(beat.count == 0);
        CHECK(beat.frame == 200);
        CHECK(beat.last == last);
    }
}

}  // namespace
}  // namespace metabuffer::test
