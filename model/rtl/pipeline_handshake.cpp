#include "rtl/pipeline_handshake.h"

namespace metabuffer::rtl {

PipelineHandshake::PipelineHandshake(const sc_core::sc_module_name& name, bool may_stall)
    : Block(name), may_stall_(may_stall) {
    clocked_.evaluates(&PipelineHandshake::drive, {startframe_i, fetched_i, running_i});
}

void PipelineHandshake::reset() {
    registers_.reset();
    pipemaster_ = pipemaster_i.read();
    startframe_o.write(false);
}

void PipelineHandshake::clock_edge() {
    if (!may_stall_ || !column_stall_i.read()) {
        startframe_ = start_o.read();
        startframe_o.write(startframe_);
    }
    was_running_ = running_i.read();
    below_ = pipeready_i.read();
    was_ready_ = pipeready_o.read();
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
    sc_core::sc_trace(file, start_o.port(), path("start"));
}

}  // namespace metabuffer::rtl
