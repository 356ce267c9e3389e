#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <systemc>

#include "monitors/rule_reporter.h"
#include "monitors/violation.h"
#include "rtl/signals.h"

namespace metabuffer::monitors {

/// Checks the characters of a DVI link, and the pixels that its decoder makes of them, clock by clock. It binds to the
/// link from outside and changes nothing. Of the encoder it uses no arithmetic: it judges characters by what DVI 1.0
/// promises of them.
///
/// - tmds/character: a character is one of those that an encoder can send
/// - tmds/control: control characters come while DE is low, and only then, with HSYNC and VSYNC on the blue channel
/// - tmds/data: a character stands for the byte of its pixel
/// - tmds/disparity: a channel's ones and zeros balance: no character adds to those of which there are too many
/// - tmds/link: the decoder gives each pixel at its clock. Before the end of the first vertical sync, in which it finds
///   the characters' beginning, it gives no DE. Not checked on links whose characters a fault disturbs.
class TmdsMonitor final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};             ///< the link's clock
    sc_core::sc_in<bool> reset_i{"reset_i"};         ///< synchronous, active high
    sc_core::sc_in<rtl::DviLink> link_i{"link_i"};   ///< at the encoder
    sc_core::sc_in<rtl::TmdsLink> tmds_i{"tmds_i"};  ///< as the encoder drives it
    sc_core::sc_in<rtl::DviLink> seen_i{"seen_i"};   ///< from the decoder

    struct Link {
        std::string tmds_signal;  ///< "TMDS_IN_1"
        std::string dvi_signal;   ///< "DVI_IN_1"
        std::string clock;        ///< "dvi_in"
        bool disturbed = false;   ///< a fault of the scenario disturbs its characters
    };
    TmdsMonitor(const sc_core::sc_module_name& name, Link link, ViolationLog& log);
    SC_HAS_PROCESS(TmdsMonitor);

    /// Whether an encoder sends the character for some byte.
    static bool is_of_a_pixel(TmdsCharacter character);

    /// Violations that were seen and not reported: of each rule the first one is.
    std::int64_t unreported() const { return reporter_.unreported(); }
    /// Characters of pixels that have been checked.
    std::int64_t pixels() const { return pixels_; }

  private:
    void clock_edge();
    void restart();
    void check_characters(const rtl::DviLink& pixel);
    void check_control(std::size_t channel, TmdsCharacter character, const rtl::DviLink& pixel);
    void check_data(std::size_t channel, TmdsCharacter character, std::uint32_t data);
    void check_decoded();
    void found(const char* rule, std::size_t channel, const std::string& what);

    Link link_;
    RuleReporter reporter_;
    std::int64_t cycle_ = -1;                           ///< counted, since a link's clock may drift
    std::array<rtl::DviLink, kTmdsLinkClocks> before_;  ///< the newest first
    std::array<int, kTmdsChannels> disparity_{};
    bool first_sync_ = false;  ///< has begun, as the decoder should give it
    bool aligned_ = false;     ///< and has ended
    std::int64_t pixels_ = 0;
};

}  // namespace metabuffer::monitors
