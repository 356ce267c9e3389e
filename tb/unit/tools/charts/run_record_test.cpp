#include "tools/charts/run_record.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "packed_text.h"
#include "support/random_seed.h"
#include "support/scenarios.h"
#include "tools/charts/run_pictures.h"

using namespace metabuffer;
using namespace metabuffer::test;
using charts::ClockBins;
using charts::LevelBins;
using charts::NumberLog;
using charts::RunRecord;
using tlm::BusSpan;

namespace {

/// Two renderers and one display, without images: what a record asks of a scenario.
Scenario two_renderers() {
    Scenario scenario = small_scenario(8, 8);
    scenario.renderers.resize(2);
    return scenario;
}

/// What a page would unpack.
std::string unpacked(const charts::Json& text) { return inflated(from_base64(text.get<std::string>())); }

}  // namespace

TEST_CASE("run record: numbers are bytes of seven bits, signed ones numbered outwards from zero",
          "[charts]") {
    NumberLog log;
    log.add(0);
    log.add(127);
    log.add(128);
    log.add(300);
    CHECK(log.bytes() == std::string("\x00\x7F\x80\x01\xAC\x02", 6));
    NumberLog large;
    large.add(~std::uint64_t{0});
    CHECK(large.bytes() == std::string("\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\xFF\x01"));
    log = NumberLog();
    for (const std::int64_t number : {0, -1, 1, -2, 2, 63, -64, 64}) log.add_signed(number);
    CHECK(log.bytes() == std::string("\x00\x01\x02\x03\x04\x7E\x7F\x80\x01", 9));
}

TEST_CASE("run record: bins keep every clock of a bus however wide they become", "[charts]") {
    const std::uint64_t seed = random_seed(1);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    ClockBins bins;
    std::vector<int> uses;  // by clock, -1: idle
    std::int64_t cycle = 0;
    for (int n = 0; n < 4000; ++n) {
        cycle += random.between(0, 9);
        const CycleSpan span{cycle, cycle + random.between(0, 40)};
        const int use = random.between(0, static_cast<int>(charts::kBusUses) - 1);
        bins.add(static_cast<std::size_t>(use), span);
        uses.resize(static_cast<std::size_t>(span.last + 1), -1);
        for (std::int64_t c = span.first; c <= span.last; ++c) uses[static_cast<std::size_t>(c)] = use;
        cycle = span.last + 1;
    }
    REQUIRE(bins.width_cycles() > 1);
    REQUIRE(bins.bins().size() <= ClockBins::kMost);
    std::vector<std::array<std::int64_t, charts::kBusUses>> expected(bins.bins().size());
    for (std::size_t c = 0; c < uses.size(); ++c) {
        if (uses[c] >= 0) {
            ++expected[c / static_cast<std::size_t>(bins.width_cycles())][static_cast<std::size_t>(uses[c])];
        }
    }
    CHECK(bins.bins() == expected);
}

TEST_CASE("run record: bins of a buffer hold every level between two points", "[charts]") {
    const std::uint64_t seed = random_seed(2);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    LevelBins bins;
    std::vector<std::pair<std::int64_t, int>> points;
    std::int64_t cycle = 0;
    for (int n = 0; n < 1500; ++n) {
        cycle += random.between(1, 12);
        points.emplace_back(cycle, random.between(0, 500));
        bins.add(cycle, points.back().second);
    }
    REQUIRE(bins.width_cycles() > 1);
    REQUIRE(bins.bins().size() <= ClockBins::kMost);
    for (std::size_t n = 1; n < points.size(); ++n) {
        const auto [from, begin] = points[n - 1];
        const auto [to, end] = points[n];
        for (std::int64_t c = from; c <= to; ++c) {
            const auto level = begin + static_cast<int>((end - begin) * (c - from) / (to - from));
            const auto& [least, most] = bins.bins()[static_cast<std::size_t>(c / bins.width_cycles())];
            CHECK(least <= level);
            CHECK(level <= most);
        }
    }
    const auto highest = std::max_element(points.begin(), points.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
    int most = 0;
    for (const auto& bin : bins.bins()) most = std::max(most, bin.second);
    CHECK(most == highest->second);
}

TEST_CASE("run record: spans stand as kind, gap, clocks and what belongs to the kind", "[charts]") {
    RunRecord record(two_renderers());
    record.bus(1, {BusUse::kPoll, {4, 9}});
    record.bus(1, {BusUse::kTable, {10, 12}, 3});
    record.bus(1, {BusUse::kBusy, {13, 44}, 3, 2, 0, 32, 1});
    record.bus(1, {BusUse::kPageMiss, {45, 50}, 3, 2, 0, 0, 0, 77});
    record.bus(2, {BusUse::kLost, {1, 1}});
    const charts::Json json = record.json();
    const auto use = [](BusUse kind) { return static_cast<char>(kind); };
    CHECK(unpacked(json["buses"][0]["spans"]) == std::string{use(BusUse::kPoll), 8, 6, use(BusUse::kTable), 0,
                                                             3, 3, use(BusUse::kBusy), 0, 32, 2, 32, 1,
                                                             use(BusUse::kPageMiss), 0, 6, 2});
    CHECK(json["buses"][0]["count"] == 4);
    CHECK(unpacked(json["buses"][1]["spans"]) == std::string{use(BusUse::kLost), 2, 1});
    CHECK_FALSE(json["buses"][0].contains("bins"));
}

TEST_CASE("run record: beyond the limit spans and levels are counted and stand in bins", "[charts]") {
    charts::RecordLimits limits;
    limits.bus_spans = 2;
    limits.level_points = 1;
    limits.starved_runs = 1;
    limits.stalls = 1;
    limits.link_frames = 1;
    RunRecord record(two_renderers(), limits);
    for (int n = 0; n < 3; ++n) {
        record.bus(1 + n % 2, {BusUse::kPoll, {10 * n, 10 * n + 3}});
        record.buffer_level(1, 1, 10 * n, 5 * n);
        record.starved(2, 1, {0, n, 1, 2});
        record.column_stall(1, 0, {10 * n, 10 * n});
        record.link_frame(1, {});
    }
    const charts::Json json = record.json();
    CHECK(json["buses"][0]["count"] == 1);
    CHECK(json["buses"][0]["left_out"] == 1);
    CHECK(json["buses"][0]["known_cycles"] == 4);
    CHECK(json["buses"][1]["left_out"] == 0);
    const std::string bins = unpacked(json["buses"][0]["bins"]);
    std::int64_t polled = 0;
    for (std::size_t n = static_cast<std::size_t>(BusUse::kPoll); n < bins.size(); n += charts::kBusUses) {
        polled += bins[n];
    }
    CHECK(polled == 8);
    CHECK(json["levels"][0]["left_out"] == 2);
    CHECK(unpacked(json["levels"][0]["bins"]).back() == 10);
    CHECK(json["starved"]["counts"] == charts::Json({0, 1}));
    CHECK(json["starved"]["left_out"] == 2);
    CHECK(json["stalls"][0]["left_out"] == 2);
    CHECK(json["links"][0]["frames"].size() == 1);
    CHECK(json["links"][0]["left_out"] == 2);
}

TEST_CASE("run pictures: beyond the limit every second frame goes, and the first one stays", "[charts]") {
    const Scenario scenario = small_scenario(32, 32);
    Random random(3);
    const std::vector<int> pairs;
    const auto take = [&](charts::ShownPictures& pictures, int frames) {
        for (int frame = 0; frame < frames; ++frame) {
            ColourImage noise(32, 32);
            for (std::uint32_t& pixel : noise.values)
                pixel = static_cast<std::uint32_t>(random.bits()) & kColourMask;
            pictures.take({frame, 1, noise, pairs});
        }
    };
    charts::ShownPictures all(scenario, std::size_t{1} << 20U);
    take(all, 8);
    CHECK(all.stride() == 1);
    CHECK(all.has(7));

    charts::ShownPictures some(scenario, 10'000);  // a picture of noise has more than its 3,072 bytes
    take(some, 9);
    CHECK(some.stride() == 4);
    CHECK(some.bytes() <= 10'000);
    for (int frame = 0; frame < 9; ++frame) CHECK(some.has(frame) == (frame % 4 == 0));

    charts::ShownPictures one(scenario, 0);
    take(one, 5);
    CHECK(one.has(0));
    CHECK_FALSE(one.has(4));
}

TEST_CASE("run pictures: their bytes are those of the different pictures that are kept", "[charts]") {
    Scenario scenario = small_scenario(16, 16);
    scenario.displays.columns = 2;
    Random random(4);
    const std::vector<int> pairs;
    charts::ShownPictures shown(scenario, 8'000);  // some thirteen pictures of noise
    ColourImage picture(16, 16);
    const auto take = [&](int frame, int display, bool is_new) {
        if (is_new) {
            for (std::uint32_t& pixel : picture.values)
                pixel = static_cast<std::uint32_t>(random.bits()) & kColourMask;
        }
        shown.take({frame, display, picture, pairs});
        charts::PagePictures pictures;
        shown.json(pictures);
        std::size_t bytes = 0;
        for (const auto& file : pictures.files()) bytes += file->size();
        CHECK(shown.bytes() == bytes);
    };
    for (int frame = 0; frame < 24; ++frame) {
        for (const int display : {1, 2}) take(frame, display, frame % 3 != 1);
    }
    CHECK(shown.stride() > 1);
    // After a reset frames count from 0 again.
    for (int frame = 0; frame < 8; ++frame) take(frame, 1, frame % 3 != 1);
}

TEST_CASE("run pictures: a picture that stays is in the page once", "[charts]") {
    const Scenario scenario = small_scenario(8, 8);
    charts::ShownPictures shown(scenario, std::size_t{1} << 20U);
    const std::vector<int> pairs;
    for (int frame = 0; frame < 3; ++frame) {
        shown.take({frame, 1, ColourImage(8, 8, frame == 2 ? 0xFF0000U : 0x00FF00U), pairs});
    }
    charts::PagePictures pictures;
    const charts::Json json = shown.json(pictures);
    CHECK(pictures.files().size() == 2);
    CHECK(json[0]["pictures"] == json[1]["pictures"]);
    CHECK(json[0]["pictures"] != json[2]["pictures"]);
}
