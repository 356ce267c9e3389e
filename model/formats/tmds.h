#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

/// The characters of a DVI link, as DVI 1.0 defines them: transition-minimized differential signalling (TMDS). A link
/// has three channels, and each carries a character of ten bits a pixel clock, bit 0 first. The paper names DVI without
/// its bits (section 4).
///
/// In active pixels a character is a byte: blue, green or red. It has at most five transitions, and the encoder keeps
/// the ones and zeros of a channel balanced. In blanking it is one of four control characters, which have seven
/// transitions or more, so a receiver finds by them where characters begin. Nothing here has a clock; docs/design.md has
/// the link's timing.
namespace metabuffer {

using TmdsCharacter = std::uint16_t;
constexpr int kTmdsCharacterBits = 10;
constexpr TmdsCharacter kTmdsCharacterMask = (1U << kTmdsCharacterBits) - 1;

/// By their number on the link. In blanking blue carries HSYNC and VSYNC.
enum class TmdsChannel : std::uint8_t { kBlue, kGreen, kRed };
constexpr std::size_t kTmdsChannels = 3;
/// In waveforms.
constexpr std::array<const char*, kTmdsChannels> kTmdsChannelNames{"BLUE", "GREEN", "RED"};

/// The most characters by which one channel of a link may come later than another.
constexpr int kMostTmdsSkew = 4;

/// Clocks of the link from a pixel at the encoder to its characters on the wire.
constexpr int kTmdsEncoderClocks = 1;
/// Clocks from the characters to the pixel: one to cut words into characters, one for the first register of the line
/// that removes skew, and the largest skew.
constexpr int kTmdsDecoderClocks = 2 + kMostTmdsSkew;
constexpr int kTmdsLinkClocks = kTmdsEncoderClocks + kTmdsDecoderClocks;

/// Bound, either way, of a channel's disparity: ones less zeros since the last control character.
constexpr int kMostTmdsDisparity = 8;

struct TmdsEncoded {
    TmdsCharacter character = 0;
    int disparity = 0;  ///< this character included
};
/// The character of a byte, after characters of that disparity.
TmdsEncoded encode_tmds(std::uint8_t data, int disparity);

/// The byte that a character stands for; any byte for a character that no encoder sends.
constexpr std::uint8_t decode_tmds(TmdsCharacter character) {
    constexpr unsigned kXorBit = 8;
    constexpr unsigned kInvertedBit = 9;
    constexpr unsigned kXnorMask = 0xFE;
    const unsigned inverted = (character >> kInvertedBit) & 1U;
    const unsigned bits = (character ^ (inverted != 0 ? 0xFFU : 0U)) & 0xFFU;
    const unsigned differences = bits ^ (bits << 1U);
    const bool is_xor = ((character >> kXorBit) & 1U) != 0;
    return static_cast<std::uint8_t>(is_xor ? differences : differences ^ kXnorMask);
}

/// The control characters by the two bits that they carry, C1 the higher. On the blue channel C0 is HSYNC and C1 is
/// VSYNC; both are 0 on the others.
constexpr std::array<TmdsCharacter, 4> kTmdsControl{0b1101010100, 0b0010101011, 0b0101010100, 0b1010101011};

constexpr TmdsCharacter tmds_control(bool c0, bool c1) {
    return kTmdsControl[(c0 ? std::size_t{1} : 0) + (c1 ? std::size_t{2} : 0)];
}

/// The two bits of a control character; nothing for any other character.
constexpr std::optional<unsigned> tmds_control_bits(TmdsCharacter character) {
    for (unsigned bits = 0; bits < kTmdsControl.size(); ++bits) {
        if (kTmdsControl[bits] == character) return bits;
    }
    return std::nullopt;
}
constexpr bool is_tmds_control(TmdsCharacter character) { return tmds_control_bits(character).has_value(); }

// ---- where characters begin ----

/// Control characters in a row that show where a channel's characters begin. In a stream that is cut elsewhere, pixels
/// never give two control characters in a row, and a pause, whose characters are all equal, gives none.
constexpr int kTmdsAlignmentRun = 12;

/// The search for where a channel's characters begin, in words of ten bits that are cut anywhere. Phases are tried in
/// turn, each for a word, and longer while it gives control characters.
struct TmdsAlignment {
    std::uint8_t phase = 0;      ///< bit of a word at which a character begins, 0 to 9
    bool found = false;          ///< a run of control characters has shown the phase
    std::uint8_t candidate = 0;  ///< the phase that is tried
    std::uint8_t run = 0;        ///< control characters in a row that it has given, up to kTmdsAlignmentRun

    /// Takes the next word.
    void step(TmdsCharacter word, TmdsCharacter next_word);

    /// In waveforms, see rtl/fields.h.
    template <typename See>
    static void visit_fields(const See& see) {
        constexpr int kNumberBits = 4;
        see("phase", &TmdsAlignment::phase, kNumberBits);
        see("found", &TmdsAlignment::found);
        see("candidate", &TmdsAlignment::candidate, kNumberBits);
        see("run", &TmdsAlignment::run, kNumberBits);
    }
};
constexpr bool operator==(const TmdsAlignment& a, const TmdsAlignment& b) {
    return a.phase == b.phase && a.found == b.found && a.candidate == b.candidate && a.run == b.run;
}

/// The character that begins at a word's bit `phase` and ends in the next word.
constexpr TmdsCharacter tmds_character(TmdsCharacter word, TmdsCharacter next_word, unsigned phase) {
    const unsigned both = word | (static_cast<unsigned>(next_word) << unsigned{kTmdsCharacterBits});
    return static_cast<TmdsCharacter>((both >> phase) & kTmdsCharacterMask);
}

// ---- which channel comes late ----

/// Characters by which each channel comes after the earliest one, 0 to kMostTmdsSkew.
using TmdsSkew = std::array<std::uint8_t, kTmdsChannels>;

/// Control characters that must precede a pixel for it to count as a line's first.
constexpr int kTmdsPauseBeforeLine = 8;

/// The skew, measured where a line begins. Bit n of a channel is set if the first character of a line came n characters
/// ago, 0 to kMostTmdsSkew. A result only kMostTmdsSkew characters after the earliest channel, if all channels have come.
std::optional<TmdsSkew> tmds_skew(const std::array<std::uint8_t, kTmdsChannels>& line_starts);

/// What goes wrong with a link's characters, by channel.
struct TmdsDisturbance {
    std::array<TmdsCharacter, kTmdsChannels> flips{};  ///< bits of the present characters
    std::array<std::uint8_t, kTmdsChannels>
        late_bits{};  ///< 0 to 9: bits from a word's begin to its character's
    std::array<std::uint8_t, kTmdsChannels> late_characters{};  ///< 0 to kMostTmdsSkew

    constexpr bool flips_any() const { return (flips[0] | flips[1] | flips[2]) != 0; }

    /// In waveforms, see rtl/fields.h.
    template <typename See>
    static void visit_fields(const See& see) {
        constexpr int kLateBits = 4;
        for (std::size_t i = 0; i < kTmdsChannels; ++i) {
            const auto see_own = [&see, i](const char* name, auto member, int bits) {
                const auto own = [ member, i ](const TmdsDisturbance& of) -> auto& {
                    return (of.*member)[i];
                };
                see(std::string(kTmdsChannelNames[i]) + name, own, bits);
            };
            see_own("_flips", &TmdsDisturbance::flips, kTmdsCharacterBits);
            see_own("_late_bits", &TmdsDisturbance::late_bits, kLateBits);
            see_own("_late_characters", &TmdsDisturbance::late_characters, kLateBits);
        }
    }
};
constexpr bool operator==(const TmdsDisturbance& a, const TmdsDisturbance& b) {
    for (std::size_t i = 0; i < kTmdsChannels; ++i) {
        if (a.flips[i] != b.flips[i] || a.late_bits[i] != b.late_bits[i] ||
            a.late_characters[i] != b.late_characters[i]) {
            return false;
        }
    }
    return true;
}

}  // namespace metabuffer
