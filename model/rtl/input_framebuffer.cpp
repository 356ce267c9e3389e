#include "rtl/input_framebuffer.h"

#include <algorithm>

#include "datapath/arbitration/arbitration_table.h"
#include "rtl/framebuffer_wires.h"

namespace metabuffer::rtl {
InputFramebuffer::InputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario,
                                   int renderer)
    : Block(name),
      busready_i("busready_i", static_cast<std::size_t>(scenario.displays.count())),
      tableready_i("tableready_i", busready_i.size()),
      renderer_(scenario.renderers[static_cast<std::size_t>(renderer)]),
      lanes_(BusBeat::lanes(pixels_per_beat(scenario.bus, scenario.memory))),
      wires_(std::make_unique<FramebufferWires>(scenario.displays.count(),
                                                goes_by_deadlines(scenario.bus.arbitration),
                                                scenario.memory.shared() ? WriteBuffer::kHalves : 0)),
      link_port_("link_port", scenario, renderer_,
                 {[this](std::uint32_t pair) {
                      counters_.add_rejected_rows(pair, table_unit_.back_table());
                      counters_.rejected_slot_tables += table_unit_.back_slots_rejected() ? 1 : 0;
                  },
                  [this](int pairs) { counters_.dropped_frames += pairs; }}),

      table_unit_("table_unit", scenario.bus, scenario.limits(renderer_)),
      frame_memory_("frame_memory", scenario.memory, renderer_.image_words()),
      memory_controller_("memory_controller", scenario.memory, renderer_.image_words()),
      bus_arbiter_("bus_arbiter", scenario.bus, scenario.displays.count()),
      bus_port_(
          "bus_port", scenario, renderer_, [this](bool fresh) { start_frame(fresh); }, counters_.bus) {
    bind_link_side();
    bind_bus_side();
    bind_arbiter();
    if (scenario.memory.shared()) {
        write_buffer_ =
            std::make_unique<WriteBuffer>("write_buffer", scenario.memory, renderer_.image_words());
        bind_write_buffer();
    }
}

InputFramebuffer::~InputFramebuffer() = default;

RendererCounters InputFramebuffer::counters() const {
    RendererCounters counters = counters_;
    bus_port_.count_slept_cycles(counters.bus);
    return counters;
}

void InputFramebuffer::bind_link_side() {
    link_port_.clk_i(dvi_clk_i);
    link_port_.reset_i(reset_i);
    link_port_.pixel_i(pixel_i);
    link_port_.event_i(event_i);
    link_port_.request_i(wires_->request);
    link_port_.pair_request_o(pair_request_o);
    link_port_.answer_o(wires_->answer);
    link_port_.fresh_o(wires_->fresh);
    link_port_.front_o(wires_->front);
    link_port_.write_o(wires_->write);
    table_unit_.clk_i(dvi_clk_i);
    table_unit_.reset_i(reset_i);
    table_unit_.event_i(event_i);
    table_unit_.front_i(wires_->front);
    table_unit_.table_o(wires_->table);
    frame_memory_.clk_i(clk_i);
    frame_memory_.reset_i(reset_i);
    frame_memory_.write_clk_i(dvi_clk_i);
    frame_memory_.write_i(wires_->write);
    frame_memory_.front_i(wires_->front);
    frame_memory_.command_i(wires_->command);
    frame_memory_.data_o(wires_->data);
    memory_controller_.clk_i(clk_i);
    memory_controller_.reset_i(reset_i);
    memory_controller_.request_i(wires_->memory_request);
    memory_controller_.answer_o(wires_->memory_answer);
    memory_controller_.command_o(wires_->command);
}

void InputFramebuffer::bind_bus_side() {
    bus_port_.clk_i(clk_i);
    bus_port_.reset_i(reset_i);
    bus_port_.request_o(wires_->request);
    bus_port_.answer_i(wires_->answer);
    bus_port_.fresh_i(wires_->fresh);
    bus_port_.table_i(wires_->table);
    bus_port_.bus_o(bus_o);
    bus_port_.memory_o(wires_->memory_request);
    bus_port_.memory_i(wires_->memory_answer);
    bus_port_.data_i(wires_->data);
    for (std::size_t line = 0; line < busready_i.size(); ++line) {
        bus_port_.busready_i[line](busready_i[line]);
        bus_port_.tableready_i[line](tableready_i[line]);
    }
}

void InputFramebuffer::bind_arbiter() {
    bus_arbiter_.clk_i(clk_i);
    bus_arbiter_.reset_i(reset_i);
    bus_arbiter_.table_i(wires_->table);
    const auto bind = [](auto& from, auto& wire, auto& to) {
        from(wire);
        to(wire);
    };
    bind(bus_port_.start_o, wires_->start, bus_arbiter_.start_i);
    bind(bus_port_.take_o, wires_->take, bus_arbiter_.take_i);
    bind(bus_arbiter_.grant_valid_o, wires_->grant_valid, bus_port_.grant_valid_i);
    bind(bus_arbiter_.search_o, wires_->search, bus_port_.search_i);
    bind(bus_arbiter_.lost_o, wires_->lost, bus_port_.lost_i);
    bind(bus_arbiter_.recovered_o, wires_->recovered, bus_port_.recovered_i);
    bus_arbiter_.slot_o(wires_->slot);
    for (std::size_t line = 0; line < busready_i.size(); ++line) {
        bind(bus_port_.pending_o[line], wires_->pending[line], bus_arbiter_.pending_i[line]);
        bind(bus_port_.ready_o[line], wires_->ready[line], bus_arbiter_.ready_i[line]);
        bind(bus_arbiter_.grant_o[line], wires_->grant[line], bus_port_.grant_i[line]);
        if (wires_->deadline.size() > 0) {
            bind(bus_port_.deadline_o[line], wires_->deadline[line], bus_arbiter_.deadline_i[line]);
        }
    }
}

void InputFramebuffer::bind_write_buffer() {
    WriteBuffer& buffer = *write_buffer_;
    buffer.clk_i(dvi_clk_i);
    buffer.reset_i(reset_i);
    buffer.write_i(wires_->write);
    buffer.command_i(wires_->command);
    buffer.drain_i(wires_->drain);
    buffer.data_o(wires_->write_data);
    for (std::size_t half = 0; half < WriteBuffer::kHalves; ++half) {
        buffer.full_o[half](wires_->write_full[half]);
        buffer.block_o[half](wires_->write_block[half]);
        memory_controller_.write_full_i[half](wires_->write_full[half]);
        memory_controller_.write_block_i[half](wires_->write_block[half]);
    }
    bus_port_.front_i[0](wires_->front);
    memory_controller_.drain_o[0](wires_->drain);
    frame_memory_.write_data_i[0](wires_->write_data);
}

void InputFramebuffer::start_frame(bool fresh) {
    counters_.repeated_frames += fresh ? 0 : 1;
    frame_sources_.push_back(link_port_.front_source());
    frame_sources_.back().fresh = fresh;
}

void InputFramebuffer::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, pair_request_o.port(), path("pair_request"));
    sc_trace(file, bus_o.read(), path("BUS"), lanes_);
    for (std::size_t d = 0; d < busready_i.size(); ++d) {
        sc_core::sc_trace(file, busready_i[d].port(), path(numbered("BUSREADY", d).c_str()));
        sc_core::sc_trace(file, tableready_i[d].port(), path(numbered("TABLEREADY", d).c_str()));
    }
    trace_parts(file);
}

}  // namespace metabuffer::rtl
