#include "rtl/tmds_decoder.h"

#include <algorithm>
#include <optional>

#include "report/waits.h"

namespace metabuffer::rtl {
namespace {

constexpr int kStartBits = 1 + kMostTmdsSkew;
constexpr unsigned kStartMask = (1U << unsigned{kStartBits}) - 1;

}  // namespace

TmdsDecoder::Channel::Channel(RegisterSet& registers, const std::string& name)
    : alignment(registers, name + "_alignment"),
      pause(registers, name + "_pause", bits_for(kTmdsPauseBeforeLine)),
      line_starts(registers, name + "_line_starts", kStartBits),
      measured(registers, name + "_measured", bits_for(kMostTmdsSkew)),
      skew(registers, name + "_skew", bits_for(kMostTmdsSkew)) {}

TmdsDecoder::TmdsDecoder(const sc_core::sc_module_name& name) : Block(name) {}

void TmdsDecoder::reset() {
    registers_.reset();
    link_o.write(link_);
}

void TmdsDecoder::clock_edge() {
    const TmdsLink characters = align(tmds_i.read());
    characters_.shift(characters);
    mark_lines(characters);
    remove_skew();
    const DviLink link = aligned() ? decode() : DviLink{};
    drive_output(link_, link_o, link);
}

/// The characters that begin in the words of the clock before.
TmdsLink TmdsDecoder::align(const TmdsLink& words) {
    TmdsLink characters;
    for (std::size_t i = 0; i < kTmdsChannels; ++i) {
        TmdsAlignment alignment = channels_[i].alignment;
        alignment.step(words_.value().channels[i], words.channels[i]);
        channels_[i].alignment = alignment;
        characters.channels[i] =
            tmds_character(words_.value().channels[i], words.channels[i], alignment.phase);
    }
    words_ = words;
    return characters;
}

void TmdsDecoder::mark_lines(const TmdsLink& characters) {
    for (std::size_t i = 0; i < kTmdsChannels; ++i) {
        Channel& channel = channels_[i];
        const bool control = is_tmds_control(characters.channels[i]);
        const bool starts = !control && channel.pause == kTmdsPauseBeforeLine;
        const unsigned marks = unsigned{channel.line_starts} << 1U | (starts ? 1U : 0U);
        channel.line_starts = static_cast<std::uint8_t>(marks & kStartMask);
        channel.pause = control ? std::min(channel.pause + 1, kTmdsPauseBeforeLine) : 0;
    }
}

/// A single line may be wrong: a bit error can hide its beginning.
void TmdsDecoder::remove_skew() {
    const std::optional<TmdsSkew> skew =
        tmds_skew({channels_[0].line_starts, channels_[1].line_starts, channels_[2].line_starts});
    if (!skew) {
        return;
    }
    bool again = true;
    for (std::size_t i = 0; i < kTmdsChannels; ++i) {
        again = again && channels_[i].measured == (*skew)[i];
        channels_[i].measured = (*skew)[i];
    }
    if (again) {
        for (Channel& channel : channels_) {
            channel.skew = channel.measured;
        }
    }
}

bool TmdsDecoder::aligned() const {
    return std::all_of(channels_.begin(), channels_.end(),
                       [](const Channel& channel) { return channel.alignment.value().found; });
}

DviLink TmdsDecoder::decode() const {
    constexpr unsigned kByteBits = 8;
    constexpr unsigned kVsyncBit = 2;
    DviLink link;
    unsigned controls = 0;
    for (std::size_t i = 0; i < kTmdsChannels; ++i) {
        const TmdsCharacter character = characters_.stage(1 + kMostTmdsSkew - channels_[i].skew).channels[i];
        const std::optional<unsigned> control = tmds_control_bits(character);
        controls += control ? 1U : 0U;
        link.data |= std::uint32_t{decode_tmds(character)} << (kByteBits * i);
        if (i != static_cast<std::size_t>(TmdsChannel::kBlue)) {
            continue;
        }
        link.hsync = control ? (*control & 1U) != 0 : link_.value().hsync;
        link.vsync = control ? (*control & kVsyncBit) != 0 : link_.value().vsync;
    }
    link.de = controls < 2;
    if (link.de) {
        link.hsync = link_.value().hsync;
        link.vsync = link_.value().vsync;
    } else {
        link.data = 0;
    }
    return link;
}

/// With the same words at every edge to come, no register changes.
void TmdsDecoder::trace(sc_core::sc_trace_file* file) const {
    sc_trace(file, tmds_i.read(), path("TMDS_in"));
    registers_.trace(file, path(""));
}

std::string TmdsDecoder::waiting_for() const { return aligned() ? "" : waits::for_control_characters(); }

}  // namespace metabuffer::rtl
