#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <systemc>
#include <vector>

#include "datapath/link/pair_follower.h"
#include "formats/dvi_timing.h"
#include "tlm/payload.h"

namespace metabuffer::tlm {

/// The DVI frame decoder between a renderer's link and its input framebuffer (section 4 of the paper): distinguishes
/// colour from depth by the control scanline, finds pairs, rejects corrupt frames, and reports at which clocks the
/// input framebuffer receives each event. The causes and clocks are those of level rtl.
class DviDecoder final : public sc_core::sc_module {
  public:
    TargetSocket<DviDecoder, DviFrame> link_socket{"link_socket"};
    InitiatorSocket<DviDecoder, DecodedFrame> framebuffer_socket{"framebuffer_socket"};

    /// timing: the mode of the renderer's link. latency_clocks: of the link's encoder and decoder, if it has any.
    DviDecoder(const sc_core::sc_module_name& name, const DviTiming& timing, int latency_clocks);

    /// What has been rejected up to a DVI input clock.
    std::array<std::int64_t, kRejectCauseCount> rejected_frames(std::int64_t through_edge) const;
    std::string waiting_for(std::int64_t through_edge) const;

  private:
    /// The state of the follower of pairs from a clock on.
    struct Moment {
        std::int64_t edge = 0;
        PairFollower pairs;
    };

    void b_transport(Payload& payload, sc_core::sc_time& delay);
    void decode(const DviFrame& frame);
    void end_control_scanline(const DviFrame& frame, std::int64_t edge);
    void learnt(LinkEvent event, std::int64_t edge);
    const PairFollower& pairs_at(std::int64_t through_edge) const;

    DviTiming timing_;
    std::int64_t latency_clocks_;
    PairFollower pairs_;
    const StoredImage* colour_image_ = nullptr;
    std::vector<std::uint8_t> payload_;   ///< of the newest control scanline
    std::vector<Moment> newest_moments_;  ///< before the frame under way and during it
    Message<DecodedFrame> decoded_;
};

}  // namespace metabuffer::tlm
