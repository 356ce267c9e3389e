#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "formats/image.h"
#include "rtl/block.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// A display, box E of the paper's Figure 1: a monitor that captures what it is shown. It knows nothing of
/// the machine; it finds frames from VSYNC and DE and measures their geometry.
///
/// Timing: a frame is captured at the edge that sees VSYNC rise behind it.
/// Raises /metabuffer/dvi_display/geometry (a warning) for a frame whose lines differ in length.
class DviDisplay final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< DVI output clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<DviLink> link_i{"link_i"};

    using FrameCaptured = std::function<void(const ColourImage&)>;

    explicit DviDisplay(const sc_core::sc_module_name& name);
    SC_HAS_PROCESS(DviDisplay);

    /// Called with every whole frame that has been shown.
    void on_frame(FrameCaptured callback) { on_frame_ = std::move(callback); }

    void trace(sc_core::sc_trace_file* file) const override;

    std::int64_t frames_captured() const { return frames_captured_; }

  private:
    void clock_edge();
    void end_line();
    void end_frame();

    FrameCaptured on_frame_;
    ColourImage capture_;
    int x_ = 0;
    bool in_frame_ = false;
    bool ragged_ = false;
    bool previous_de_ = false;
    bool previous_vsync_ = false;
    std::int64_t frames_captured_ = 0;
};

}  // namespace metabuffer::rtl
