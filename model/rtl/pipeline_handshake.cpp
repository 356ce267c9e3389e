#include "rtl/pipeline_handshake.h"

namespace metabuffer::rtl {

PipelineHandshake::PipelineHandshake(const sc_core::sc_module_name& name, bool may_stall, ClockGating gating)
    : Block(name), may_stall_(may_stall), gate_(gating) {
    SC_METHOD(process);
    sensitive << clk_i.pos() << startframe_i << fetched_i << running_i;
    dont_initialize();
}

void PipelineHandshake::end_of_elaboration() {
    gate_.attach(clk_i);
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= startframe_i.value_changed_event();
    wake_events_ |= pipeready_i.value_changed_event();
    wake_events_ |= fetched_i.value_changed_event();
    wake_events_ |= running_i.value_changed_event();
}

void PipelineHandshake::process() {
    if (!gate_.opened() && clk_i.posedge()) {
        clock_edge();
    }
    drive();
}

void PipelineHandshake::clock_edge() {
    if (reset_i.read()) {
        registers_.reset();
        pipemaster_ = pipemaster_i.read();
        startframe_o.write(false);
        return;
    }
    const bool idle_edge = idle();
    if (!may_stall_ || !column_stall_i.read()) {
        startframe_ = start_o.read();
        startframe_o.write(startframe_);
    }
    was_running_ = running_i.read();
    below_ = pipeready_i.read();
    was_ready_ = pipeready_o.read();
    if (gate_.idle_edge(idle_edge)) {
        next_trigger(wake_events_);
    }
}

/// This edge changes no register.
bool PipelineHandshake::idle() const {
    return !startframe_ && !start_o.read() && was_running_ == running_i.read() &&
           below_ == pipeready_i.read() && was_ready_ == pipeready_o.read();
}

void PipelineHandshake::drive() {
    // A PIPEREADY from below that belongs to the frame just composited may still be high at the frame's last edge.
    const bool pipeready =
        !running_i.read() && !was_running_ && !startframe_ && (was_ready_ || (fetched_i.read() && below_));
    pipeready_o.write(pipeready);
    start_o.write(!running_i.read() && (pipemaster_ ? pipeready : startframe_i.read()));
}

void PipelineHandshake::trace(sc_core::sc_trace_file* file) const {
    registers_.trace(file, path(""));
    sc_core::sc_trace(file, start_o, path("start"));
}

}  // namespace metabuffer::rtl
