#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "formats/dvi_timing.h"
#include "monitors/violation.h"
#include "rtl/signals.h"

namespace metabuffer::monitors {

/// Checks a DVI link's DE, HSYNC and VSYNC clock by clock against its mode. It binds to the link from outside and
/// changes nothing; data are not checked.
///
/// An output runs from reset on: a vertical sync, then frame after frame. An input begins with one vertical sync (no
/// horizontal ones). It may pause in blanking, for any time, after that sync and between frames only. If a fault of the
/// scenario changes a frame's lines, only HSYNC, VSYNC's position in the line and VSYNC's length are checked against the
/// mode.
///
/// Rules: dvi/active-lines, dvi/active-pixels, dvi/line-length, dvi/hsync, dvi/vsync, dvi/vsync-at-line-start. Only the
/// first violation of a frame is reported; the monitor goes on with the next frame.
class DviMonitor final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< the link's clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<rtl::DviLink> link_i{"link_i"};

    enum class Kind : std::uint8_t { kInput, kOutput };

    /// What the monitor should know of a frame that begins.
    struct Frame {
        std::int64_t number = -1;  ///< a violation's frame
        bool corrupt = false;      ///< kInput: by the scenario it has other lines than the mode
    };

    struct Link {
        Kind kind = Kind::kOutput;
        DviTiming timing;
        std::string signal;                 ///< "DVI_IN_1"
        std::string clock;                  ///< "dvi_in"
        std::function<Frame()> next_frame;  ///< called as each frame begins
        std::function<void()> restart{};    ///< called as a reset begins
    };

    DviMonitor(const sc_core::sc_module_name& name, Link link, ViolationLog& log);
    SC_HAS_PROCESS(DviMonitor);

    /// Frames that have been seen to their end, also those with violations.
    std::int64_t frames_seen() const { return frames_seen_; }

  private:
    enum class State : std::uint8_t { kReset, kFirstSync, kBetween, kFrame, kLost };

    void clock_edge();
    void begin_frame();
    void end_frame();
    void step_first_sync(const rtl::DviLink& link);
    void step_between(const rtl::DviLink& link);
    void step_frame(const rtl::DviLink& link);
    void end_corrupt_frame(const rtl::DviLink& link);
    void step_lost(const rtl::DviLink& link);
    void advance();
    bool active_line() const;
    void check_clock(const rtl::DviLink& link);
    void check_corrupt_clock(const rtl::DviLink& link);
    bool hsync_due() const;
    void found(const char* rule, const std::string& what);

    Link link_;
    ViolationLog& log_;

    State state_ = State::kReset;
    Frame frame_;
    std::int64_t cycle_ = -1;  ///< counted, since a link's clock may drift
    int x_ = 0;                ///< clock of the line
    int line_ = 0;
    std::int64_t pause_clocks_ = 0;  ///< kBetween: clocks in blanking so far
    int vsync_clocks_ = 0;           ///< clocks that VSYNC has been high on end
    std::int64_t frames_seen_ = 0;
};

}  // namespace metabuffer::monitors
