#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "report/machine_report.h"
#include "rtl/block.h"
#include "rtl/bus_arbiter.h"
#include "rtl/bus_port.h"
#include "rtl/frame_memory.h"
#include "rtl/link_port.h"
#include "rtl/memory_controller.h"
#include "rtl/signals.h"
#include "rtl/table_unit.h"
#include "rtl/write_buffer.h"

namespace metabuffer::rtl {

struct FramebufferWires;

/// The input framebuffer, box B of the paper's Figure 1 (sections 4 and 5): receives a renderer's pairs in the back
/// device of its memory and sends the front device's segments over the renderer's bus. It is made of
///
/// - link_port, in DVI input clocks: writes pixels, keeps track of the two devices, answers the bus side;
/// - frame_memory: the two devices;
/// - write_buffer, with shared ports: keeps the link's words until the memory's pins are free;
/// - table_unit: the viewport tables of both, and the slot table;
/// - memory_controller: pages, banks, refresh and, with shared ports, the link's writes;
/// - bus_port, in core clocks: table and bursts on the bus;
/// - bus_arbiter: decides whose burst is next.
///
/// Their headers say what each does at which clock.
class InputFramebuffer final : public Block {
  public:
    In<bool> clk_i{"clk_i"};          ///< core clock
    In<bool> reset_i{"reset_i"};      ///< synchronous in both domains, active high
    In<bool> dvi_clk_i{"dvi_clk_i"};  ///< DVI input clock
    In<DecodedPixel> pixel_i{"pixel_i"};
    In<DecoderEvent> event_i{"event_i"};
    Out<bool> pair_request_o{"pair_request_o"};  ///< the back device is free (DVI input clock)
    PinVector<In<bool>> busready_i;              ///< one per composer of the row
    PinVector<In<bool>> tableready_i;
    Out<BusBeat> bus_o{"bus_o"};

    /// renderer: index, from 0. The scenario must outlive the module.
    InputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer);
    ~InputFramebuffer() override;

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override { return bus_port_.waiting_for(); }

    /// Counters of bus and table; the decoder counts what the link rejected.
    RendererCounters counters() const;

    /// The event's renderer is not set.
    const MachineEvent& first_recovered_slot() const { return bus_port_.first_recovered_slot(); }

    /// The source of each composited frame that has been started.
    const std::vector<FrameSource>& frame_sources() const { return frame_sources_; }
    /// A reset is over: the next frame is number 0.
    void forget_frames() { frame_sources_.clear(); }

    /// Pixels received from the link, for the watchdog.
    std::int64_t link_pixels() const { return link_port_.link_pixels(); }

    /// The wires between the blocks inside, for monitors; null in a replacement without these blocks.
    FramebufferWires* inner_wires() { return wires_.get(); }

  private:
    void bind_link_side();
    void bind_bus_side();
    void bind_arbiter();
    void bind_write_buffer();
    void start_frame(bool fresh);

    const Renderer& renderer_;
    int lanes_;
    RendererCounters counters_;
    std::vector<FrameSource> frame_sources_;

    std::unique_ptr<FramebufferWires> wires_;
    LinkPort link_port_;
    TableUnit table_unit_;
    FrameMemory frame_memory_;
    std::unique_ptr<WriteBuffer> write_buffer_;  ///< null without shared ports
    MemoryController memory_controller_;
    BusArbiter bus_arbiter_;
    BusPort bus_port_;
};

}  // namespace metabuffer::rtl
