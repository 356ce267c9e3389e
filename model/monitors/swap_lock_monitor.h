#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "formats/dvi_timing.h"
#include "formats/image.h"
#include "monitors/fault_window.h"
#include "monitors/violation.h"
#include "rtl/block.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// Checks the swap lock (sections 5.4 and 7 of the paper) from outside: FRAMEDONE, FRAMEBAD, SWAPLOCK and SWAPSKIP at
/// the core clock, and the pictures on the DVI outputs. No wire shows when the pictures swap. This follows from SWAPLOCK,
/// delayed by two registers of the DVI output clock, and from the outputs' frames, which run in step from reset on: the
/// swap is due at the first clock of the next frame.
///
/// Rules:
/// - swap-lock/all-done: SWAPLOCK is high exactly while every FRAMEDONE is; where a fault of the scenario holds SWAPLOCK,
///   it may rise later, but is not taken back
/// - swap-lock/any-bad: SWAPSKIP is high exactly while any FRAMEBAD is; where a fault holds SWAPLOCK, SWAPSKIP may rise
///   later, but not after SWAPLOCK, and is not taken back
/// - swap-lock/framedone-fall: FRAMEDONE falls two registers of the core clock after a swap, on all displays, and never
///   otherwise
/// - swap-lock/framedone-rise: FRAMEDONE rises once for a swap, and not before the swap's level has come back
/// - swap-lock/framebad: FRAMEBAD does not change while FRAMEDONE is high
/// - swap-lock/in-step: the outputs' VSYNC is the same on every display
/// - swap-lock/picture: a display's picture changes at the start of a DVI frame in which a swap is due, and never
///   otherwise; before the first swap it is black
/// - swap-lock/kept: with SWAPSKIP the picture stays
class SwapLockMonitor final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};          ///< core clock
    sc_core::sc_in<bool> dvi_clk_i{"dvi_clk_i"};  ///< DVI output clock
    sc_core::sc_in<bool> reset_i{"reset_i"};      ///< synchronous in both domains, active high
    sc_core::sc_vector<sc_core::sc_in<bool>> framedone_i;
    sc_core::sc_vector<sc_core::sc_in<bool>> framebad_i;
    sc_core::sc_in<bool> swaplock_i{"swaplock_i"};
    sc_core::sc_in<bool> swapskip_i{"swapskip_i"};
    sc_core::sc_vector<sc_core::sc_in<rtl::DviLink>> link_i;

    /// The scenario gives displays and clocks and is not kept.
    SwapLockMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, ViolationLog& log);
    SC_HAS_PROCESS(SwapLockMonitor);

    /// A picture that a display (from 0) has shown in full, in the first DVI frame after a swap. dvi_cycle: the clock
    /// of its last pixel.
    struct Shown {
        std::size_t display;
        std::int64_t frame;  ///< composited frame, from 0
        std::int64_t dvi_cycle;
        const ColourImage& picture;
    };
    void on_picture(std::function<void(const Shown&)> callback) { on_picture_ = std::move(callback); }

    /// Number of the composited frame that the displays show, -1 before the first swap.
    std::int64_t frame() const { return state_.swaps - 1; }
    /// Swaps at which the displays kept their picture.
    std::int64_t kept_frames() const { return kept_frames_; }

  private:
    static constexpr std::int64_t kNever = -1;

    /// What is remembered of a display.
    struct Display {
        // core clock
        bool framedone = false;
        bool framebad = false;
        std::int64_t rises = 0;  ///< of FRAMEDONE
        // DVI output clock
        ColourImage picture;  ///< as shown last, black at first; overwritten as the next one comes
        std::size_t next_value = 0;
        bool reported = false;  ///< a violation in this DVI frame has been reported
    };

    void restart();
    void core_edge();
    void check_wires(std::int64_t cycle);
    void check_framedone(std::size_t display, std::int64_t cycle);
    std::int64_t earliest_rise_cycle(std::int64_t cycle) const;
    void dvi_edge();
    void start_dvi_frame();
    void take_clock();
    void take_pixel(std::size_t display, std::uint32_t data);
    void synchronize();
    void found_core(const char* rule, const std::string& signal, const std::string& what);
    void found_dvi(const char* rule, std::size_t display, const std::string& what);

    DviTiming timing_;
    std::int64_t core_period_picoseconds_;
    std::int64_t dvi_period_picoseconds_;
    ViolationLog& log_;
    std::function<void(const Shown&)> on_picture_;

    FaultWindows holds_;  ///< of the swap lock's wires
    std::int64_t kept_frames_ = 0;

    /// All that a reset clears.
    struct State {
        std::vector<Display> displays;
        bool wires_reported =
            false;              ///< SWAPLOCK or SWAPSKIP is reported as wrong; until they are right again
        bool swaplock = false;  ///< as sampled one edge ago
        bool swapskip = false;
        std::int64_t swaps = 0;

        // Core clock: the edges that sample the effects of the swap and of the end of its level.
        std::int64_t fall_cycle = kNever;
        std::int64_t rise_cycle = 0;
        std::int64_t previous_rise_cycle = 0;  ///< of the swap before the last
        std::int64_t swap_picoseconds = 0;     ///< of the last swap

        // DVI output clock.
        bool dvi_reset = true;
        std::int64_t position = 0;  ///< clock of the frame that the outputs drive
        bool swaplock_captured = false;
        bool swap_level = false;    ///< a swap has been made for this SWAPLOCK
        bool swap_pending = false;  ///< due at the next DVI frame
        bool skip_pending = false;
        bool fresh = false;  ///< the first DVI frame after a swap
        bool kept = false;   ///< that swap was skipped
        bool in_step_reported = false;
    };
    State state_;
};

}  // namespace metabuffer::monitors
