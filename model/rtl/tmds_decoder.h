#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The decoder at the receiver's end of a DVI link: between a renderer's link and its frame decoder, or in a display. It
/// finds where the characters of each channel begin, removes the skew between channels, and gives the pixels that the
/// encoder had. DVI 1.0 defines the characters (formats/tmds.h); the paper names DVI alone. Only machines with
/// `links.layer: tmds` have it.
///
/// Timing: registered. A pixel is on link_o kTmdsDecoderClocks after its first character is at tmds_i; the characters of
/// the other channels may come up to kMostTmdsSkew clocks later.
///
/// - Where characters begin: found after kTmdsAlignmentRun control characters in a row, in each channel by itself. link_o
///   is low until all three have been found once. A channel that slips is found again in the next blanking; until then
///   it gives wrong bytes.
/// - Skew is measured where a line begins. It is removed once two lines in a row have had the same.
/// - DE is low while two channels or three have a control character. So wrong bits in one channel change pixels, but no
///   line's length.
/// - HSYNC and VSYNC follow blue while DE is low, and stay where blue has no control character.
class TmdsDecoder final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< the link's clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<TmdsLink> tmds_i{"tmds_i"};
    Out<DviLink> link_o{"link_o"};

    explicit TmdsDecoder(const sc_core::sc_module_name& name);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

  private:
    /// What is known of one channel.
    struct Channel {
        Channel(RegisterSet& registers, const std::string& name);
        Register<TmdsAlignment> alignment;
        Register<int> pause;                 ///< control characters in a row, up to kTmdsPauseBeforeLine
        Register<std::uint8_t> line_starts;  ///< as tmds_skew has them
        Register<std::uint8_t> measured;     ///< at the beginning of the last line
        Register<std::uint8_t> skew;         ///< that is removed
    };

    void clock_edge();
    void reset();
    TmdsLink align(const TmdsLink& words);
    void mark_lines(const TmdsLink& characters);
    void remove_skew();
    bool aligned() const;
    DviLink decode() const;

    RegisterSet registers_;
    Register<TmdsLink> words_{registers_, "words"};  ///< ten bits of each channel, of the clock before
    std::array<Channel, kTmdsChannels> channels_{Channel{registers_, "blue"}, Channel{registers_, "green"},
                                                 Channel{registers_, "red"}};
    RegisterLine<TmdsLink> characters_{registers_, "characters", 1 + kMostTmdsSkew};
    Register<DviLink> link_{registers_, "DVI"};
    Clocked clocked_{*this, clk_i, reset_i, registers_, &TmdsDecoder::clock_edge, &TmdsDecoder::reset};
};

}  // namespace metabuffer::rtl
