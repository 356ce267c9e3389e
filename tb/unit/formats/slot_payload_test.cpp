#include "formats/slot_payload.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "support/random_seed.h"

namespace metabuffer {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST_CASE(
    "slot payload: mark, bits of a slot, their number, the slots from the lowest bit on, and room for them") {
    CHECK(encode_slots({0, 1, 1, 0, 1}, 2) == Bytes{'S', 1, 5, 0, 0b10110});
    CHECK(encode_slots({2, 0, 1, 2, 1}, 3) == Bytes{'S', 2, 5, 0, 0b10'01'00'10, 0b01});
    CHECK(encode_slots({4, 3}, 5) == Bytes{'S', 3, 2, 0, 0b011'100});
    CHECK(encode_slots({0}, 1) == Bytes{'S', 1, 1, 0, 0});
    CHECK(encode_slots({65535, 1}, 65536) == Bytes{'S', 16, 2, 0, 0xFF, 0xFF, 1, 0});
    CHECK(encode_slots({}, 4) == Bytes{'S', 2, 0, 0});
    CHECK(encode_slots(std::vector<int>(258, 1), 2)[3] == 1);
    CHECK(slots_in_payload(0, 2) == 0);
    CHECK(slots_in_payload(4, 2) == 0);
    CHECK(slots_in_payload(5, 2) == 8);
    CHECK(slots_in_payload(5, 3) == 4);
    CHECK(slots_in_payload(5, 5) == 2);
    CHECK(slots_in_payload(5, 257) == 0);
    CHECK(slots_in_payload(6, 257) == 1);
    CHECK(slots_in_payload(1'000'000, 2) == 65535);
}

TEST_CASE("slot payload: the slots that come are those that were sent") {
    const auto seed = test::random_seed(171);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 2000; ++trial) {
        const int rows = random.one_in(10) ? random.between(1, 65536) : random.between(1, 20);
        std::vector<int> slots(static_cast<std::size_t>(random.between(0, 300)));
        for (int& slot : slots) slot = random.between(0, rows - 1);
        const Bytes payload = encode_slots(slots, static_cast<std::size_t>(rows));
        REQUIRE(decode_slots(payload) == slots);
        // Just as many fit as the payload has room for.
        const std::size_t room = slots_in_payload(payload.size(), static_cast<std::size_t>(rows));
        REQUIRE(room >= slots.size());
        REQUIRE(slots_in_payload(payload.size() - 1, static_cast<std::size_t>(rows)) <= slots.size());
    }
}

TEST_CASE("slot payload: a payload of another kind, or not as long as it says, is not a slot table") {
    const Bytes good = encode_slots({2, 0, 1, 2, 1}, 3);
    REQUIRE(decode_slots(good));
    for (std::size_t bytes = 0; bytes < good.size(); ++bytes) {
        CHECK_FALSE(decode_slots(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(bytes))));
    }
    const auto with = [&good](std::size_t slot, std::uint8_t byte) {
        Bytes changed = good;
        changed[slot] = byte;
        return decode_slots(changed);
    };
    CHECK_FALSE(with(0, 'D'));
    CHECK_FALSE(with(1, 0));
    CHECK_FALSE(with(1, 17));
    CHECK_FALSE(with(2, 3));
    CHECK_FALSE(with(3, 1));
    Bytes longer = good;
    longer.push_back(0);
    CHECK_FALSE(decode_slots(longer));
    CHECK(decode_slots({'S', 1, 0, 0}) == std::vector<int>{});
    // As long as they say, but with slots of no bit or of more than there can be.
    CHECK_FALSE(decode_slots({'S', 0, 3, 0}));
    CHECK_FALSE(decode_slots({'S', 17, 1, 0, 1, 0, 0}));
    CHECK(decode_slots({'S', 16, 1, 0, 1, 0}) == std::vector<int>{1});
}

}  // namespace
}  // namespace metabuffer
