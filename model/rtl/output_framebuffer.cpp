#include "rtl/output_framebuffer.h"

namespace metabuffer::rtl {

OutputFramebuffer::OutputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario,
                                     int display)
    : Block(name),
      frame_averager_("frame_averager", scenario, display),
      display_memory_("display_memory", scenario.displays.pixels()),
      dvi_output_("dvi_output", scenario) {
    frame_averager_.clk_i(clk_i);
    frame_averager_.reset_i(reset_i);
    frame_averager_.startframe_i(startframe_i);
    frame_averager_.pipe_i(pipe_i);
    frame_averager_.column_stall_i(column_stall_i);
    frame_averager_.pipeready_o(pipeready_o);
    frame_averager_.framedone_o(framedone_o);
    frame_averager_.framebad_o(framebad_o);
    frame_averager_.writes_o(writes_);
    frame_averager_.write_o(write_);
    frame_averager_.swapped_i(swapped_);
    frame_averager_.skipped_i(skipped_);
    display_memory_.clk_i(clk_i);
    display_memory_.reset_i(reset_i);
    display_memory_.writes_i(writes_);
    display_memory_.write_i(write_);
    display_memory_.dvi_clk_i(dvi_clk_i);
    display_memory_.reads_i(reads_);
    display_memory_.read_i(read_);
    display_memory_.data_o(data_);
    dvi_output_.clk_i(dvi_clk_i);
    dvi_output_.reset_i(reset_i);
    dvi_output_.swaplock_i(swaplock_i);
    dvi_output_.swapskip_i(swapskip_i);
    dvi_output_.swapped_o(swapped_);
    dvi_output_.skipped_o(skipped_);
    dvi_output_.reads_o(reads_);
    dvi_output_.read_o(read_);
    dvi_output_.data_i(data_);
    dvi_output_.link_o(link_o);
}

void OutputFramebuffer::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, startframe_i.port(), path("STARTFRAME_in"));
    sc_core::sc_trace(file, pipeready_o.port(), path("PIPEREADY"));
    sc_core::sc_trace(file, framedone_o.port(), path("FRAMEDONE"));
    sc_core::sc_trace(file, framebad_o.port(), path("FRAMEBAD"));
    sc_core::sc_trace(file, swaplock_i.port(), path("SWAPLOCK"));
    sc_core::sc_trace(file, swapskip_i.port(), path("SWAPSKIP"));
    sc_trace(file, pipe_i.read(), path("PIPE_in"));
    sc_trace(file, link_o.read(), path("DVI"));
    trace_parts(file);
}

}  // namespace metabuffer::rtl
