#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <systemc>
#include <vector>

#include "formats/dvi_timing.h"
#include "report/report.h"
#include "tlm/payload.h"

namespace metabuffer::tlm {

/// The DVI frame decoder between a renderer's link and its input framebuffer (section 4 of the paper): tells
/// colour from depth by the control scanline, finds pairs, rejects what is spoilt, and says at which clocks the
/// input framebuffer learns of it. The causes and clocks are those of level rtl.
class DviDecoder final : public sc_core::sc_module {
  public:
    TargetSocket<DviDecoder, DviFrame> link_socket{"link_socket"};                       ///< DviFrame
    InitiatorSocket<DviDecoder, DecodedFrame> framebuffer_socket{"framebuffer_socket"};  ///< DecodedFrame

    /// timing: the mode of the renderer's link.
    DviDecoder(const sc_core::sc_module_name& name, const DviTiming& timing);

    /// What has been rejected up to a DVI input clock.
    std::array<std::int64_t, kRejectCauseCount> rejected_frames(std::int64_t through_edge) const;
    std::string waiting_for(std::int64_t through_edge) const;

  private:
    enum class Expect : std::uint8_t { kAnyColour, kColour, kDepth };
    struct Rejection {
        std::int64_t edge;
        RejectCause cause;
    };
    struct Expectation {
        std::int64_t edge;
        Expect expect;
        std::uint32_t number;
    };

    void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
    void decode(const DviFrame& frame);
    void end_control_scanline(const DviFrame& frame, std::int64_t edge);
    void reject(RejectCause cause, std::int64_t edge);
    void expect(Expect expect, std::int64_t edge);
    LinkEvent& event_at(std::int64_t edge);

    DviTiming timing_;
    Expect expect_ = Expect::kAnyColour;
    bool frame_lives_ = false;  ///< the frame under way is not rejected or passed over
    bool control_good_ = false;
    FrameKind kind_ = FrameKind::kColour;
    std::uint32_t number_ = 0;
    const PixelImage* colour_image_ = nullptr;
    std::array<std::int64_t, kRejectCauseCount> rejected_frames_{};
    std::vector<Rejection> newest_rejections_;      ///< of the frame under way, counted already
    std::vector<Expectation> newest_expectations_;  ///< before the frame under way and behind it
    Message<DecodedFrame> decoded_;
};

}  // namespace metabuffer::tlm
