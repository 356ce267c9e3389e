#pragma once

#include <cstdint>
#include <functional>

#include "datapath/link/pair_keeper.h"
#include "report/machine_report.h"
#include "rtl/block.h"
#include "rtl/crossing.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The link's side of an input framebuffer (section 4 of the paper). It writes what the decoder finds into the back
/// device of the frame memory, keeps track of the two devices (PairKeeper) and answers the bus side, which asks for the
/// pair of each frame.
///
/// It works in DVI input clocks, and every output is registered. A question is a change of request_i, and an answer is
/// a change of answer_o; each crosses to the other clock domain through two registers of its receiver. fresh_o, front_o
/// and the front device's table change with the answer only.
class LinkPort final : public Block {
  public:
    In<bool> clk_i{"clk_i"};      ///< DVI input clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    In<DecodedPixel> pixel_i{"pixel_i"};
    In<DecoderEvent> event_i{"event_i"};
    In<bool> request_i{"request_i"};             ///< core clock: changes with each question
    Out<bool> pair_request_o{"pair_request_o"};  ///< the back device is free
    Out<bool> answer_o{"answer_o"};              ///< changes with each answer
    Out<bool> fresh_o{"fresh_o"};                ///< the devices were swapped for it
    Out<bool> front_o{"front_o"};                ///< which device the bus reads
    Out<MemoryWrite> write_o{"write_o"};

    struct Records {
        /// The back device holds this pair, whole.
        std::function<void(std::uint32_t pair)> accepted;
        std::function<void(int pairs)> dropped;
    };
    LinkPort(const sc_core::sc_module_name& name, const Scenario& scenario, const Renderer& renderer,
             Records records);

    void trace(sc_core::sc_trace_file* file) const override;

    /// Of the pair in the front device.
    const FrameSource& front_source() const { return front_source_; }
    /// Pixels received from the link, for the watchdog.
    std::int64_t link_pixels() const { return link_pixels_; }

  private:
    void clock_edge();
    void reset();
    void pass_edge();
    void write_pixel(const DecodedPixel& pixel);
    void take_event(const DecoderEvent& event);
    void answer(bool fresh);

    DepthFormat depth_format_;
    Records records_;

    RegisterSet registers_;
    Crossing request_{registers_, "request"};
    Register<bool> pair_request_{registers_, "pair_request"};
    Register<bool> answer_{registers_, "answer"};
    Register<bool> fresh_{registers_, "fresh"};
    Register<bool> front_{registers_, "front"};
    Register<MemoryWrite> write_;
    Register<PairKeeper> pairs_;

    // What a report says of the run.
    std::int64_t edge_ = 0;                    ///< number of the clock's edge
    std::int64_t last_pixel_picoseconds_ = 0;  ///< when the last pixel was on the link
    std::int64_t link_pixels_ = 0;
    FrameSource front_source_;
    Clocked clocked_{*this, clk_i, reset_i, registers_, &LinkPort::clock_edge, &LinkPort::reset};
};

}  // namespace metabuffer::rtl
