#pragma once

#include <cstdint>
#include <vector>

#include "formats/dvi_timing.h"
#include "rtl/block.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// A renderer's graphics card as the link sees it, box A of the paper's Figure 1: a test double that sends
/// the scenario's pairs, colour frame first, depth frame second, each under a control scanline written as the
/// host would write it (section 4).
///
/// Timing: after reset one vertical sync, then frame after frame of DviTiming. lockstep: the first clock of a
/// pair follows the clock that sees pair_request high with no pair under way, and one pair a frame is sent;
/// between pairs the link stays in blanking. free-running: pair follows pair without pause, for ever.
/// Faults of the scenario (see Fault) spoil or delay the frames they name.
class DviSource final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< DVI input clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<bool> pair_request_i{"pair_request_i"};
    sc_core::sc_out<DviLink> link_o{"link_o"};

    /// The scenario must outlive the module. renderer: index, from 0.
    DviSource(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
              ClockGating gating = ClockGating::kOn);
    SC_HAS_PROCESS(DviSource);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

  private:
    enum class State : std::uint8_t { kFirstSync, kIdle, kSilence, kFrame };

    void end_of_elaboration() override;
    void clock_edge();
    void start_frame_or_blank();
    bool start_next_frame();
    void prepare_frame();
    const Fault* fault_of(FrameKind kind, FaultKind fault) const;
    bool has_fault(FaultKind fault) const { return fault_of(kind_, fault) != nullptr; }
    int active_pixels_of_line() const;
    std::uint32_t active_data() const;
    void step_raster();

    const Scenario& scenario_;
    const Renderer& renderer_;
    int renderer_index_;
    DviTiming timing_;

    ClockGate gate_;
    sc_core::sc_event_or_list wake_events_;

    State state_ = State::kFirstSync;
    std::uint32_t next_pair_ = 0;  ///< number of the next pair to start
    std::uint32_t pair_ = 0;       ///< the pair under way
    bool pair_under_way_ = false;
    FrameKind kind_ = FrameKind::kColour;
    bool delay_served_ = false;
    std::int64_t silence_clocks_ = 0;
    std::vector<std::uint32_t> control_;  ///< the frame's control scanline
    const PixelImage* image_ = nullptr;
    int x_ = 0;
    int line_ = 0;
    int active_lines_ = 0;  ///< of the frame under way: a fault may change it
    bool vsync_line_ = false;
    int line_active_pixels_ = 0;  ///< of the line under way: likewise
    DviLink link_;
};

}  // namespace metabuffer::rtl
