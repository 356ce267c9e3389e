#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dvi_waveform.h"
#include "rtl/signals.h"
#include "support/random_seed.h"
#include "support/tmds_flow_chart.h"

/// Waveforms of DVI links in characters, by the flow charts of DVI 1.0 and not by the model's encoder.
namespace metabuffer::test {

using TmdsWaveform = std::vector<rtl::TmdsLink>;
/// The characters of a waveform by channel: blue, green, red.
using TmdsStreams = std::array<std::vector<TmdsCharacter>, 3>;

inline TmdsStreams tmds_streams(const Waveform& wave) {
    TmdsStreams streams;
    std::array<TmdsFlowChart, 3> charts;
    for (const rtl::DviLink& link : wave) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            if (link.de) {
                charts[channel].encode(link.data >> (8 * channel) & 0xFFU);
                streams[channel].push_back(charts[channel].character());
                continue;
            }
            charts[channel].cnt = 0;
            const bool c0 = channel == 0 && link.hsync;
            const bool c1 = channel == 0 && link.vsync;
            const TmdsCharacter control =
                c1 ? (c0 ? 0b1010101011 : 0b0101010100) : (c0 ? 0b0010101011 : 0b1101010100);
            streams[channel].push_back(control);
        }
    }
    return streams;
}

/// A vertical sync of so many lines, and frames of random pixels.
inline Waveform random_waveform(int width, int height, int sync_lines, int frames, std::uint64_t seed) {
    Random random(seed);
    Waveform wave;
    append_blank_lines(wave, width, sync_lines, true);
    for (int frame = 0; frame < frames; ++frame) {
        LinkLines lines(static_cast<std::size_t>(height),
                        std::vector<std::uint32_t>(static_cast<std::size_t>(width)));
        for (auto& line : lines) {
            for (std::uint32_t& pixel : line) pixel = static_cast<std::uint32_t>(random.bits()) & 0xFF'FFFFU;
        }
        append_frame(wave, width, lines);
    }
    return wave;
}

/// All channels side by side, as long as the shortest.
inline TmdsWaveform tmds_waveform(const TmdsStreams& streams) {
    TmdsWaveform wave;
    for (std::size_t i = 0; i < streams[0].size() && i < streams[1].size() && i < streams[2].size(); ++i) {
        rtl::TmdsLink link;
        for (std::size_t channel = 0; channel < 3; ++channel) link.channels[channel] = streams[channel][i];
        wave.push_back(link);
    }
    return wave;
}

inline TmdsWaveform tmds_waveform(const Waveform& wave) { return tmds_waveform(tmds_streams(wave)); }

}  // namespace metabuffer::test
