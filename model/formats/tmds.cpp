#include "formats/tmds.h"

#include <algorithm>

namespace metabuffer {
namespace {

constexpr unsigned kDataBits = 8;
constexpr unsigned kXorBit = 1U << 8U;
constexpr unsigned kInvertedBit = 1U << 9U;
constexpr unsigned kDataMask = 0xFF;

constexpr int ones_of(unsigned bits) {
    int ones = 0;
    for (; bits != 0; bits &= bits - 1) ++ones;
    return ones;
}

constexpr int disparity_of(unsigned character) { return 2 * ones_of(character) - kTmdsCharacterBits; }

/// The byte with each bit XORed with the one before, or XNORed, whichever has fewer transitions; bit 8 says which.
constexpr std::uint16_t transition_minimized(unsigned data) {
    const int ones = ones_of(data);
    const bool use_xnor = ones > 4 || (ones == 4 && (data & 1U) == 0);
    unsigned bits = data & 1U;
    for (unsigned i = 1; i < kDataBits; ++i) {
        const unsigned bit = ((bits >> (i - 1)) ^ (data >> i) ^ (use_xnor ? 1U : 0U)) & 1U;
        bits |= bit << i;
    }
    return static_cast<std::uint16_t>(bits | (use_xnor ? 0U : kXorBit));
}

constexpr std::array<std::uint16_t, 256> minimized_bytes() {
    std::array<std::uint16_t, 256> table{};
    for (unsigned data = 0; data < table.size(); ++data) table[data] = transition_minimized(data);
    return table;
}
constexpr std::array<std::uint16_t, 256> kMinimized = minimized_bytes();

}  // namespace

TmdsEncoded encode_tmds(std::uint8_t data, int disparity) {
    const unsigned minimized = kMinimized[data];
    const int surplus = disparity_of(minimized & kDataMask) + 2;  // of the eight data bits
    const bool is_xor = (minimized & kXorBit) != 0;
    // With a balance, or a byte that has one, the two upper bits are made to cancel out.
    const bool invert = disparity == 0 || surplus == 0 ? !is_xor : (disparity > 0) == (surplus > 0);
    const unsigned character = invert ? (minimized ^ kDataMask) | kInvertedBit : minimized;
    return {static_cast<TmdsCharacter>(character), disparity + disparity_of(character)};
}

void TmdsAlignment::step(TmdsCharacter word, TmdsCharacter next_word) {
    if (!is_tmds_control(tmds_character(word, next_word, candidate))) {
        candidate = static_cast<std::uint8_t>(candidate + 1 == kTmdsCharacterBits ? 0 : candidate + 1);
        run = 0;
        return;
    }
    if (run < kTmdsAlignmentRun) ++run;
    if (run == kTmdsAlignmentRun) {
        phase = candidate;
        found = true;
    }
}

std::optional<TmdsSkew> tmds_skew(const std::array<std::uint8_t, kTmdsChannels>& line_starts) {
    constexpr unsigned kEarliest = 1U << unsigned{kMostTmdsSkew};
    const auto has_begun = [](std::uint8_t starts) { return starts != 0; };
    const auto is_earliest = [](std::uint8_t starts) { return starts == kEarliest; };
    if (!std::all_of(line_starts.begin(), line_starts.end(), has_begun) ||
        std::none_of(line_starts.begin(), line_starts.end(), is_earliest)) {
        return std::nullopt;
    }
    TmdsSkew skew{};
    for (std::size_t channel = 0; channel < kTmdsChannels; ++channel) {
        while ((unsigned{line_starts[channel]} << skew[channel] & kEarliest) == 0) ++skew[channel];
    }
    return skew;
}

}  // namespace metabuffer
