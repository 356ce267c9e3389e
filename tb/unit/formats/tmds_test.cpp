#include "formats/tmds.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "support/random_seed.h"
#include "support/tmds_flow_chart.h"

namespace metabuffer::test {
namespace {

int transitions(TmdsCharacter character) {
    int count = 0;
    for (unsigned i = 0; i < 9; ++i) count += (character >> i & 1U) != (character >> (i + 1) & 1U) ? 1 : 0;
    return count;
}

int ones_less_zeros(TmdsCharacter character) {
    int difference = 0;
    for (unsigned i = 0; i < 10; ++i) difference += (character >> i & 1U) != 0 ? 1 : -1;
    return difference;
}

/// Every disparity that characters can lead to, from 0.
std::set<int> reachable_disparities() {
    std::set<int> reached{0};
    std::vector<int> open{0};
    while (!open.empty()) {
        const int cnt = open.back();
        open.pop_back();
        for (unsigned d = 0; d < 256; ++d) {
            TmdsFlowChart chart;
            chart.cnt = cnt;
            chart.encode(d);
            if (reached.insert(chart.cnt).second) open.push_back(chart.cnt);
        }
    }
    return reached;
}

std::set<TmdsCharacter> data_characters() {
    std::set<TmdsCharacter> characters;
    for (const int disparity : reachable_disparities()) {
        for (unsigned d = 0; d < 256; ++d) {
            characters.insert(encode_tmds(static_cast<std::uint8_t>(d), disparity).character);
        }
    }
    return characters;
}

TEST_CASE("tmds: every character is that of DVI's flow chart, at every disparity, to and fro") {
    const std::set<int> disparities = reachable_disparities();
    CHECK(*disparities.begin() == -kMostTmdsDisparity);
    CHECK(*disparities.rbegin() == kMostTmdsDisparity);
    for (const int disparity : disparities) {
        for (unsigned d = 0; d < 256; ++d) {
            TmdsFlowChart chart;
            chart.cnt = disparity;
            chart.encode(d);
            const TmdsEncoded encoded = encode_tmds(static_cast<std::uint8_t>(d), disparity);
            INFO("byte " << d << " at disparity " << disparity << ", by the chart " << chart.q_out);
            CHECK(encoded.character == chart.character());
            CHECK(encoded.disparity == chart.cnt);
            CHECK(encoded.disparity - disparity == ones_less_zeros(encoded.character));
        }
    }
    for (const int disparity : reachable_disparities()) {
        for (unsigned d = 0; d < 256; ++d) {
            CHECK(decode_tmds(encode_tmds(static_cast<std::uint8_t>(d), disparity).character) == d);
        }
    }
    for (TmdsCharacter character = 0; character <= kTmdsCharacterMask; ++character) {
        INFO("character " << character);
        CHECK(decode_tmds(character) == tmds_byte(character));
    }
    for (const TmdsCharacter character : data_characters()) CHECK(transitions(character) <= 5);
    for (const TmdsCharacter character : kTmdsControl) CHECK(transitions(character) >= 7);
}

TEST_CASE("tmds: the four control characters are those of DVI, by C1 and C0, and no others are") {
    const std::map<std::string, TmdsCharacter> wanted{
        {"00", 0b1101010100}, {"01", 0b0010101011}, {"10", 0b0101010100}, {"11", 0b1010101011}};
    for (const auto& [bits, character] : wanted) {
        const bool c1 = bits[0] == '1';
        const bool c0 = bits[1] == '1';
        CHECK(tmds_control(c0, c1) == character);
        CHECK(tmds_control_bits(character) == (c1 ? 2U : 0U) + (c0 ? 1U : 0U));
    }
    int controls = 0;
    for (TmdsCharacter character = 0; character <= kTmdsCharacterMask; ++character) {
        controls += is_tmds_control(character) ? 1 : 0;
    }
    CHECK(controls == 4);
}

TEST_CASE("tmds: the disparity of a long random run of bytes stays within its bound, and balances") {
    const std::uint64_t seed = random_seed(41);
    INFO("seed " << seed);
    Random random(seed);
    constexpr int kCharacters = 1'000'000;  // ten million bits
    int disparity = 0;
    int lowest = 0;
    int highest = 0;
    for (int i = 0; i < kCharacters; ++i) {
        const int before = disparity;
        disparity = encode_tmds(static_cast<std::uint8_t>(random.bits()), disparity).disparity;
        lowest = std::min(lowest, disparity);
        highest = std::max(highest, disparity);
        REQUIRE(before * (disparity - before) <= 0);
    }
    CHECK(lowest >= -kMostTmdsDisparity);
    CHECK(highest <= kMostTmdsDisparity);
}

TEST_CASE("tmds: a random gigabit keeps to the bound of the disparity and comes out as it went in",
          "[slow]") {
    const std::uint64_t seed = random_seed(42);
    INFO("seed " << seed);
    Random random(seed);
    constexpr int kWords = 12'500'000;  // of eight bytes: 100 million characters
    int disparity = 0;
    std::int64_t wrong = 0;
    int farthest = 0;
    for (int i = 0; i < kWords; ++i) {
        std::uint64_t bytes = random.bits();
        for (int byte = 0; byte < 8; ++byte, bytes >>= 8U) {
            const auto data = static_cast<std::uint8_t>(bytes);
            const TmdsEncoded encoded = encode_tmds(data, disparity);
            wrong += decode_tmds(encoded.character) != data ? 1 : 0;
            disparity = encoded.disparity;
            farthest = std::max(farthest, std::abs(disparity));
        }
    }
    CHECK(wrong == 0);
    CHECK(farthest == kMostTmdsDisparity);
}

// ---- alignment ----

TEST_CASE("tmds: a character is found at each phase of two words") {
    const std::uint64_t seed = random_seed(43);
    INFO("seed " << seed);
    Random random(seed);
    std::vector<TmdsCharacter> characters;
    for (int i = 0; i < 50; ++i) {
        characters.push_back(static_cast<TmdsCharacter>(random.bits() & kTmdsCharacterMask));
    }
    for (unsigned phase = 0; phase < 10; ++phase) {
        const std::vector<TmdsCharacter> words = late_words(characters, phase);
        for (std::size_t i = 0; i + 1 < words.size(); ++i) {
            INFO("phase " << phase << ", character " << i);
            CHECK(tmds_character(words[i], words[i + 1], phase) == characters[i]);
        }
    }
}

TEST_CASE(
    "tmds: a pause never looks like one when it is cut elsewhere, pixels for one character at the most") {
    const std::set<TmdsCharacter> data = data_characters();
    for (const TmdsCharacter control : kTmdsControl) {
        for (unsigned phase = 1; phase < 10; ++phase) {
            CHECK_FALSE(is_tmds_control(tmds_character(control, control, phase)));
        }
    }
    for (unsigned phase = 1; phase < 10; ++phase) {
        // Characters that end one look-alike and begin another would make two in a row.
        std::set<TmdsCharacter> ends;
        std::set<TmdsCharacter> begins;
        for (const TmdsCharacter first : data) {
            for (const TmdsCharacter second : data) {
                if (!is_tmds_control(tmds_character(first, second, phase))) continue;
                begins.insert(first);
                ends.insert(second);
            }
        }
        for (const TmdsCharacter end : ends) {
            INFO("phase " << phase << ", character " << end);
            CHECK(begins.count(end) == 0);
        }
    }
}

/// How many words it takes until the alignment has found this phase; nothing if it does not.
std::optional<int> words_until(TmdsAlignment& alignment, const std::vector<TmdsCharacter>& words,
                               unsigned phase) {
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
        alignment.step(words[i], words[i + 1]);
        if (alignment.found && alignment.phase == phase) return static_cast<int>(i) + 1;
    }
    return std::nullopt;
}

TEST_CASE("tmds: the beginning of characters is found in a pause, from every phase to every other") {
    for (const TmdsCharacter control : kTmdsControl) {
        for (unsigned before = 0; before < 10; ++before) {
            for (unsigned phase = 0; phase < 10; ++phase) {
                TmdsAlignment alignment;
                const std::vector<TmdsCharacter> pause(40, control);
                INFO("control character " << control << ", from phase " << before << " to " << phase);
                REQUIRE(words_until(alignment, late_words(pause, before), before));
                const std::optional<int> words = words_until(alignment, late_words(pause, phase), phase);
                REQUIRE(words);
                // Every other phase is tried once, and the first word is still of the phase before.
                CHECK(*words <= 1 + 9 + kTmdsAlignmentRun);
            }
        }
    }
}

TEST_CASE("tmds: lines of pixels never move the beginning of characters, wherever words are cut") {
    const std::uint64_t seed = random_seed(44);
    INFO("seed " << seed);
    Random random(seed);
    for (unsigned phase = 0; phase < 10; ++phase) {
        std::vector<TmdsCharacter> characters;
        for (int line = 0; line < 40; ++line) {
            const bool vsync = line % 8 == 0;
            characters.insert(characters.end(), 20, tmds_control(false, vsync));
            characters.insert(characters.end(), 12, tmds_control(true, vsync));
            characters.insert(characters.end(), 20, tmds_control(false, vsync));
            int disparity = 0;
            // Some lines repeat a byte or two, whose characters come in short cycles.
            const std::uint64_t bytes = random.bits();
            const unsigned different = line % 3 == 0 ? 8 : static_cast<unsigned>(line % 3);
            for (unsigned x = 0; x < 200; ++x) {
                const std::uint64_t byte = different == 8 ? random.bits() : bytes >> (8 * (x % different));
                const TmdsEncoded encoded = encode_tmds(static_cast<std::uint8_t>(byte), disparity);
                disparity = encoded.disparity;
                characters.push_back(encoded.character);
            }
        }
        TmdsAlignment alignment;
        const std::vector<TmdsCharacter> words = late_words(characters, phase);
        for (std::size_t i = 0; i + 1 < words.size(); ++i) {
            alignment.step(words[i], words[i + 1]);
            INFO("phase " << phase << ", word " << i);
            if (alignment.found) REQUIRE(alignment.phase == phase);
        }
        CHECK(alignment.found);
    }
}

// ---- skew ----

TEST_CASE("tmds: the skew of every combination of channels is measured when the last line has begun") {
    for (unsigned blue = 0; blue <= 4; ++blue) {
        for (unsigned green = 0; green <= 4; ++green) {
            for (unsigned red = 0; red <= 4; ++red) {
                const auto starts = [](unsigned ago) { return static_cast<std::uint8_t>(1U << ago); };
                const std::optional<TmdsSkew> skew = tmds_skew({starts(blue), starts(green), starts(red)});
                INFO("begun " << blue << ", " << green << " and " << red << " ago");
                const bool old_enough = std::max({blue, green, red}) == 4;
                REQUIRE(skew.has_value() == old_enough);
                if (!skew) continue;
                CHECK((*skew)[0] == 4 - blue);
                CHECK((*skew)[1] == 4 - green);
                CHECK((*skew)[2] == 4 - red);
            }
        }
    }
    CHECK_FALSE(tmds_skew({0, 0, 0}));
    CHECK_FALSE(tmds_skew({16, 0, 0}));
    CHECK_FALSE(tmds_skew({16, 8, 0}));
    CHECK_FALSE(tmds_skew({0, 16, 16}));
    CHECK(tmds_skew({16, 8, 1}));
}

TEST_CASE("tmds disturbance: flipped bits of any channel count") {
    CHECK_FALSE(TmdsDisturbance{}.flips_any());
    for (std::size_t channel = 0; channel < kTmdsChannels; ++channel) {
        TmdsDisturbance disturbance;
        disturbance.late_bits.fill(3);
        CHECK_FALSE(disturbance.flips_any());
        disturbance.flips.at(channel) = 1U << 9U;
        CHECK(disturbance.flips_any());
    }
}

}  // namespace
}  // namespace metabuffer::test
