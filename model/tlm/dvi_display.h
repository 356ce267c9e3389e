#pragma once

#include <functional>
#include <systemc>
#include <utility>

#include "formats/image.h"
#include "tlm/payload.h"

namespace metabuffer::tlm {

/// A display, box E of the paper's Figure 1: receives the frames that have been on its DVI link.
class DviDisplay final : public sc_core::sc_module {
  public:
    TargetSocket<DviDisplay, ShownFrame> dvi_socket{"dvi_socket"};

    explicit DviDisplay(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
        dvi_socket.register_b_transport(this, &DviDisplay::take_frame);
    }

    /// Called with every frame; the image is null in a run without images.
    using FrameShown = std::function<void(int frame, const ColourImage* image)>;
    void on_frame(FrameShown callback) { on_frame_ = std::move(callback); }

  private:
    void take_frame(Payload& payload, sc_core::sc_time& /*delay*/) {
        const auto& shown = content_of<ShownFrame>(payload);
        payload.set_response_status(::tlm::TLM_OK_RESPONSE);
        if (on_frame_) {
            on_frame_(shown.frame, shown.image);
        }
    }

    FrameShown on_frame_;
};

}  // namespace metabuffer::tlm
