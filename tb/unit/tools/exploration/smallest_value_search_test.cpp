#include "tools/exploration/smallest_value_search.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>
#include <set>

using metabuffer::exploration::SearchDescription;
using metabuffer::exploration::SmallestValueSearch;

namespace {

SearchDescription range(std::int64_t from, std::int64_t to, int checks = 16) {
    SearchDescription description;
    description.key = "composer.buffer_pixels";
    description.from = from;
    description.to = to;
    description.checks = checks;
    return description;
}

/// What a value misses, in short.
std::string missed(std::int64_t value) { return "misses " + std::to_string(value); }

/// Runs a search against a goal. Returns the values that it tried.
std::set<std::int64_t> run(SmallestValueSearch& search, const std::function<bool(std::int64_t)>& meets) {
    std::set<std::int64_t> looked_at;
    while (!search.finished()) {
        const std::vector<std::int64_t> values = search.wanted();
        REQUIRE_FALSE(values.empty());
        // The last first: answers come in any order.
        for (auto value = values.rbegin(); value != values.rend(); ++value) {
            const bool is_new = looked_at.insert(*value).second;
            REQUIRE(is_new);
            search.take(*value, meets(*value));
        }
    }
    return looked_at;
}

}  // namespace

TEST_CASE("smallest value search: finds any threshold of a monotonic goal in logarithmically many runs") {
    const auto seed = std::random_device{}();
    INFO("seed " << seed);
    std::mt19937_64 random(seed);
    for (int trial = 0; trial < 2000; ++trial) {
        const std::int64_t from = std::uniform_int_distribution<std::int64_t>(0, 100)(random);
        const std::int64_t to = from + (std::int64_t{1} << std::uniform_int_distribution<int>(0, 24)(random));
        const std::int64_t threshold = std::uniform_int_distribution<std::int64_t>(from, to)(random);
        CAPTURE(from, to, threshold);
        SmallestValueSearch search(range(from, to));
        const auto looked_at = run(search, [threshold](std::int64_t value) { return value >= threshold; });
        CHECK(search.smallest() == threshold);
        CHECK(search.monotonic());
        CHECK(search.note(missed).empty());
        CHECK(*looked_at.begin() >= from);
        CHECK(*looked_at.rbegin() <= to);
        CHECK(static_cast<double>(looked_at.size()) <= 2.0 * std::log2(static_cast<double>(to)) + 20.0);
    }
}

TEST_CASE("smallest value search: a goal that no value meets ends at the end of the range") {
    SmallestValueSearch search(range(3, 1000));
    run(search, [](std::int64_t) { return false; });
    CHECK_FALSE(search.smallest());
    CHECK(search.largest_seen() == 1000);
    CHECK(search.monotonic());
}

TEST_CASE("smallest value search: candidates are the only values tried") {
    SearchDescription description = range(0, 0);
    description.candidates = {16, 32, 64, 128, 256, 512};
    SmallestValueSearch search(description);
    const auto looked_at = run(search, [](std::int64_t value) { return value >= 100; });
    CHECK(search.smallest() == 128);
    for (const std::int64_t value : looked_at) {
        CAPTURE(value);
        CHECK(std::find(description.candidates.begin(), description.candidates.end(), value) !=
              description.candidates.end());
    }
}

TEST_CASE(
    "smallest value search: a miss above the value is reported, with the value from which on all meet the "
    "goal") {
    // 50 meets it, 52 and 53 do not.
    SmallestValueSearch search(range(1, 1 << 20));
    run(search, [](std::int64_t value) { return value >= 50 && value != 52 && value != 53; });
    CHECK(search.smallest() == 50);
    CHECK_FALSE(search.monotonic());
    CHECK(
        search.note(missed) ==
        "not monotonic: 50 meets the goal, 52, 53 do not (52: misses 52); from 54 on every value tried does");
}

TEST_CASE("smallest value search: a value below that meets the goal becomes the answer and is reported") {
    // Halving from 64 finds 50; the checks just below it find the island from 44 to 46.
    SmallestValueSearch search(range(1, 1 << 20));
    run(search, [](std::int64_t value) { return value >= 50 || (value >= 44 && value <= 46); });
    CHECK(search.smallest() == 44);
    CHECK_FALSE(search.monotonic());
    CHECK(search.note(missed).find("44 meets the goal") != std::string::npos);
    CHECK(search.note(missed).find("from 50 on every value tried does") != std::string::npos);
}

TEST_CASE("smallest value search: with as many checks as values no value below is left untried") {
    const auto seed = std::random_device{}();
    INFO("seed " << seed);
    std::mt19937_64 random(seed);
    for (int trial = 0; trial < 300; ++trial) {
        std::vector<bool> meets(201);
        for (std::size_t value = 0; value < meets.size(); ++value) meets[value] = random() % 5 == 0;
        meets.back() = true;
        SmallestValueSearch search(range(0, 200, 1000));
        run(search, [&meets](std::int64_t value) { return meets[static_cast<std::size_t>(value)]; });
        const auto first = std::find(meets.begin(), meets.end(), true) - meets.begin();
        CHECK(search.smallest() == first);
        CHECK(search.exhaustive());
    }
}

TEST_CASE("smallest value search: its answer was tried and no smaller value tried meets the goal") {
    const auto seed = std::random_device{}();
    INFO("seed " << seed);
    std::mt19937_64 random(seed);
    for (int trial = 0; trial < 500; ++trial) {
        // A threshold with noise around it, as schedules make it.
        const std::int64_t threshold = std::uniform_int_distribution<std::int64_t>(1, 2000)(random);
        const std::uint64_t salt = random();
        const auto meets = [&](std::int64_t value) {
            const bool is_noisy = std::abs(value - threshold) < 20 &&
                                  std::hash<std::uint64_t>{}(
                                      static_cast<std::uint64_t>(value) * 0x9E37'79B9'7F4A'7C15U ^ salt) %
                                          7 ==
                                      0;
            return is_noisy ? value < threshold : value >= threshold;
        };
        SmallestValueSearch search(range(1, 1 << 16));
        const auto looked_at = run(search, meets);
        REQUIRE(search.smallest());
        CHECK(meets(*search.smallest()));
        bool agrees = true;
        for (const std::int64_t value : looked_at) {
            if (value < *search.smallest()) CHECK_FALSE(meets(value));
            agrees = agrees && meets(value) == (value >= *search.smallest());
        }
        CHECK(search.monotonic() == agrees);
        CHECK(search.note(missed).empty() == agrees);
    }
}

TEST_CASE("smallest value search: a goal that holds in a window only is found between the doubled values") {
    // No power of two meets it, and the largest value does not.
    SmallestValueSearch search(range(1, 4096));
    run(search, [](std::int64_t value) { return value >= 2100 && value < 4000; });
    CHECK(search.smallest() == 2100);
    CHECK_FALSE(search.monotonic());
}

TEST_CASE("smallest value search: with enough checks every value has been tried before a goal is unmet") {
    SmallestValueSearch search(range(-20, 40, 100));
    const auto looked_at = run(search, [](std::int64_t) { return false; });
    CHECK(looked_at.size() == 61);
    CHECK(search.exhaustive());
    SmallestValueSearch short_search(range(-20, 4000, 4));
    run(short_search, [](std::int64_t) { return false; });
    CHECK_FALSE(short_search.exhaustive());
}
