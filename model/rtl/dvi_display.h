#pragma once

#include <cstdint>
#include <functional>
#include <utility>

#include "formats/image.h"
#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// A display, box E of the paper's Figure 1: a monitor that captures its pictures. It knows nothing of the machine; it
/// finds frames from VSYNC and DE and measures their geometry.
///
/// Timing: a frame is captured at the edge that sees VSYNC rise after it.
/// Raises /metabuffer/dvi_display/geometry (a warning) for a frame whose lines differ in length.
class DviDisplay final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< DVI output clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<DviLink> link_i{"link_i"};

    using FrameCaptured = std::function<void(const ColourImage&)>;

    explicit DviDisplay(const sc_core::sc_module_name& name);

    /// Called with every whole frame that has been shown.
    void on_frame(FrameCaptured callback) { on_frame_ = std::move(callback); }

    void trace(sc_core::sc_trace_file* file) const override;

    std::int64_t frames_captured() const { return frames_captured_; }

  private:
    static constexpr int kSizeBits = 32;  ///< enough for any mode

    void clock_edge();
    void reset() { registers_.reset(); }
    void take_pixels(std::uint32_t colour, std::int64_t count);
    void end_line();
    void end_frame();

    FrameCaptured on_frame_;
    ColourImage capture_;  ///< memory: the frame under way
    std::int64_t frames_captured_ = 0;

    RegisterSet registers_;
    Register<int> x_{registers_, "x", kSizeBits};
    Register<bool> in_frame_{registers_, "in_frame"};
    Register<bool> ragged_{registers_, "ragged"};  ///< the frame's lines differ in length
    Register<DviLink> previous_{registers_, "previous"};
    Clocked clocked_{*this, clk_i, reset_i, registers_, &DviDisplay::clock_edge, &DviDisplay::reset};
};

}  // namespace metabuffer::rtl
