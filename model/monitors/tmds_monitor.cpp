#include "monitors/tmds_monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <bitset>
#include <cstdlib>
#include <sstream>
#include <utility>

namespace metabuffer::monitors {
namespace {

constexpr std::array<const char*, kTmdsChannels> kNames{"blue", "green", "red"};

using Bits = std::bitset<kTmdsCharacterBits>;
constexpr std::size_t kXorBit = 8;
constexpr std::size_t kInvertedBit = 9;
constexpr std::size_t kByteBits = 8;

/// The byte, bit by bit: each is the XOR, or XNOR, of two that follow each other.
unsigned byte_of(const Bits& character) {
    unsigned byte = character[0] != character[kInvertedBit] ? 1 : 0;
    for (std::size_t i = 1; i < kByteBits; ++i) {
        const bool differ = character[i] != character[i - 1];
        if (differ == character[kXorBit]) byte |= 1U << i;
    }
    return byte;
}

bool is_control(const Bits& character) {
    static const std::array<Bits, 4> kControl{Bits("1101010100"), Bits("0010101011"), Bits("0101010100"),
                                              Bits("1010101011")};
    return std::find(kControl.begin(), kControl.end(), character) != kControl.end();
}

std::string text(TmdsCharacter character) { return Bits(character).to_string(); }

template <typename Value>
std::string words(const Value& value) {
    std::ostringstream out;
    out << value;
    return out.str();
}

}  // namespace

TmdsMonitor::TmdsMonitor(const sc_core::sc_module_name& name, Link link, ViolationLog& log)
    : sc_core::sc_module(name), link_(std::move(link)), reporter_(log, link_.clock) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

/// With XOR or XNOR by the byte's ones; and a byte that is balanced in itself has upper bits that are, too.
bool TmdsMonitor::is_of_a_pixel(TmdsCharacter character) {
    const Bits bits(character);
    const unsigned byte = byte_of(bits);
    const auto ones = std::bitset<kByteBits>(byte).count();
    const bool with_xnor = ones > kByteBits / 2 || (ones == kByteBits / 2 && (byte & 1U) == 0);
    if (bits[kXorBit] == with_xnor) return false;
    std::size_t ones_sent = 0;
    for (std::size_t i = 0; i < kByteBits; ++i) ones_sent += bits[i] ? 1 : 0;
    return ones_sent != kByteBits / 2 || bits[kInvertedBit] != bits[kXorBit];
}

void TmdsMonitor::restart() {
    before_.fill(rtl::DviLink{});
    disparity_.fill(0);
    first_sync_ = false;
    aligned_ = false;
}

/// An edge samples what the edge before it has driven: the characters are of the pixel that the last edge sampled.
void TmdsMonitor::clock_edge() {
    ++cycle_;
    if (reset_i.read()) {
        restart();
        return;
    }
    check_characters(before_[kTmdsEncoderClocks - 1]);
    check_decoded();
    std::rotate(before_.begin(), before_.end() - 1, before_.end());
    before_[0] = link_i.read();
}

void TmdsMonitor::check_characters(const rtl::DviLink& pixel) {
    pixels_ += pixel.de ? 1 : 0;
    for (std::size_t channel = 0; channel < kTmdsChannels; ++channel) {
        const TmdsCharacter character = tmds_i.read().channels[channel];
        const Bits bits(character);
        const bool control = is_control(bits);
        if (!control && !is_of_a_pixel(character)) {
            found("tmds/character", channel, text(character) + " is no character that an encoder sends");
        } else if (control == pixel.de) {
            found("tmds/control", channel,
                  text(character) + (control ? " is a control character in a pixel"
                                             : " is not a control character, while DE is low"));
        } else if (control) {
            check_control(channel, character, pixel);
        } else {
            check_data(channel, character, pixel.data >> (kByteBits * channel) & 0xFFU);
        }
    }
}

void TmdsMonitor::check_control(std::size_t channel, TmdsCharacter character, const rtl::DviLink& pixel) {
    disparity_[channel] = 0;
    const bool c0 = channel == 0 && pixel.hsync;
    const bool c1 = channel == 0 && pixel.vsync;
    // C0 is a control character's first bit, and C1 says whether its last bit is the same.
    const Bits bits(character);
    const bool has_c0 = bits[0];
    const bool has_c1 = bits[kInvertedBit] == has_c0;
    if (has_c0 != c0 || has_c1 != c1) {
        found("tmds/control", channel,
              fmt::format("{} has C0 {} and C1 {}, {} and {} would be right", text(character), int{has_c0},
                          int{has_c1}, int{c0}, int{c1}));
    }
}

void TmdsMonitor::check_data(std::size_t channel, TmdsCharacter character, std::uint32_t data) {
    const Bits bits(character);
    const unsigned byte = byte_of(bits);
    if (byte != data) {
        found("tmds/data", channel,
              fmt::format("{} stands for 0x{:02x}, 0x{:02x} would be right", text(character), byte, data));
    }
    const int more = 2 * static_cast<int>(bits.count()) - kTmdsCharacterBits;
    const int before = disparity_[channel];
    disparity_[channel] += more;
    if (before * more > 0 || std::abs(disparity_[channel]) > kMostTmdsDisparity) {
        found(
            "tmds/disparity", channel,
            fmt::format("{} makes a disparity of {} into {}", text(character), before, disparity_[channel]));
    }
}

void TmdsMonitor::check_decoded() {
    if (link_.disturbed) return;
    const rtl::DviLink& wanted = before_[kTmdsLinkClocks - 1];
    aligned_ = aligned_ || (first_sync_ && !wanted.vsync);
    first_sync_ = first_sync_ || wanted.vsync;
    const rtl::DviLink& seen = seen_i.read();
    if (aligned_ ? seen == wanted : !seen.de) return;
    reporter_.report("tmds/link", "tmds/link", link_.dvi_signal, cycle_, RuleReporter::kNoFrame,
                     "it is " + words(seen) + ", " +
                         (aligned_ ? words(wanted) + " would be right"
                                   : std::string("before the end of the first VSYNC")));
}

void TmdsMonitor::found(const char* rule, std::size_t channel, const std::string& what) {
    reporter_.report(rule, rule, link_.tmds_signal, cycle_, RuleReporter::kNoFrame,
                     std::string(kNames[channel]) + ": " + what);
}

}  // namespace metabuffer::monitors
