#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/tmds.h"

/// The characters of DVI 1.0 as its flow charts make them, bit by bit and with its names, and the stream of bits that
/// they are on a wire. Written apart from the model.
namespace metabuffer::test {

struct TmdsFlowChart {
    int cnt = 0;        ///< Cnt(t-1), then Cnt(t)
    std::string q_out;  ///< q_out[0] first

    void encode(unsigned d) {
        int ones = 0;
        for (unsigned i = 0; i < 8; ++i) ones += bit(d, i);
        // First stage: q_m, by XNOR or by XOR.
        std::vector<int> q_m{bit(d, 0)};
        if (ones > 4 || (ones == 4 && bit(d, 0) == 0)) {
            for (unsigned i = 1; i < 8; ++i) q_m.push_back(q_m[i - 1] == bit(d, i) ? 1 : 0);
            q_m.push_back(0);
        } else {
            for (unsigned i = 1; i < 8; ++i) q_m.push_back(q_m[i - 1] == bit(d, i) ? 0 : 1);
            q_m.push_back(1);
        }
        // Second stage: q_out.
        const auto n1 = static_cast<int>(std::count(q_m.begin(), q_m.begin() + 8, 1));
        const int n0 = 8 - n1;
        if (cnt == 0 || n1 == n0) {
            put(q_m, q_m[8] == 0, q_m[8] == 0);
            cnt += q_m[8] == 0 ? n0 - n1 : n1 - n0;
        } else if ((cnt > 0 && n1 > n0) || (cnt < 0 && n0 > n1)) {
            put(q_m, true, true);
            cnt += 2 * q_m[8] + n0 - n1;
        } else {
            put(q_m, false, false);
            cnt += -2 * (1 - q_m[8]) + n1 - n0;
        }
    }

    TmdsCharacter character() const {
        unsigned value = 0;
        for (unsigned i = 0; i < 10; ++i) value |= (q_out[i] == '1' ? 1U : 0U) << i;
        return static_cast<TmdsCharacter>(value);
    }

  private:
    static int bit(unsigned value, unsigned i) { return static_cast<int>(value >> i & 1U); }
    void put(const std::vector<int>& q_m, bool q_out_9, bool inverted) {
        q_out.clear();
        for (std::size_t i = 0; i < 8; ++i) q_out += (q_m[i] == 1) != inverted ? '1' : '0';
        q_out += q_m[8] == 1 ? '1' : '0';
        q_out += q_out_9 ? '1' : '0';
    }
};

/// The byte of a character, by the decoder's flow chart.
inline unsigned tmds_byte(TmdsCharacter character) {
    const auto bit = [character](unsigned i) { return (character >> i & 1U) != 0; };
    std::vector<bool> d;
    for (unsigned i = 0; i < 8; ++i) d.push_back(bit(9) ? !bit(i) : bit(i));
    unsigned q = d[0] ? 1 : 0;
    for (unsigned i = 1; i < 8; ++i) {
        const bool value = bit(8) ? d[i] != d[i - 1] : d[i] == d[i - 1];
        q |= (value ? 1U : 0U) << i;
    }
    return q;
}

/// A stream of characters as words of ten bits, where each character comes `late_bits` after a word's beginning. What
/// comes before the first character is 0.
inline std::vector<TmdsCharacter> late_words(const std::vector<TmdsCharacter>& characters,
                                             unsigned late_bits) {
    std::string bits(late_bits, '0');
    for (const TmdsCharacter character : characters) {
        for (unsigned i = 0; i < 10; ++i) bits += (character >> i & 1U) != 0 ? '1' : '0';
    }
    std::vector<TmdsCharacter> words;
    for (std::size_t start = 0; start + 10 <= bits.size(); start += 10) {
        unsigned word = 0;
        for (unsigned i = 0; i < 10; ++i) word |= (bits[start + i] == '1' ? 1U : 0U) << i;
        words.push_back(static_cast<TmdsCharacter>(word));
    }
    return words;
}

}  // namespace metabuffer::test
