#include "rtl/composer.h"

#include "report/waits.h"
#include "scenario/derived_timing.h"

namespace metabuffer::rtl {

Composer::Composer(const sc_core::sc_module_name& name, const Scenario& scenario, int display)
    : Block(name),
      pixels_per_beat_(pixels_per_beat(scenario.bus, scenario.memory)),
      wires_(scenario.composer.window_rows()),
      beat_receiver_("beat_receiver", scenario, display, *this),
      fifo_("fifo", scenario.composer.buffer_pixels, scenario.composer.window_rows()),
      raster_walker_("raster_walker", scenario),
      merge_stage_("merge_stage", scenario),
      pipeline_handshake_("pipeline_handshake", scenario.composer.may_stall()),
      raster_recorder_("raster_recorder", scenario, *this) {
    bind_bus_side();
    bind_fifo();
    bind_pipeline_side();
    bind_recorder();
}

void Composer::bind_bus_side() {
    beat_receiver_.clk_i(clk_i);
    beat_receiver_.reset_i(reset_i);
    beat_receiver_.bus_i(bus_i);
    beat_receiver_.busready_o(busready_o);
    beat_receiver_.tableready_o(tableready_o);
    beat_receiver_.column_stall_i(column_stall_i);
    beat_receiver_.start_i(wires_.start);
    beat_receiver_.uses_i(wires_.uses);
    beat_receiver_.use_i(wires_.use);
    beat_receiver_.segment_o(wires_.segment);
    beat_receiver_.progress_o(wires_.progress);
    beat_receiver_.fetched_o(wires_.fetched);
    beat_receiver_.write_o(wires_.fifo.write);
    beat_receiver_.release_o(wires_.fifo.release);
}

void Composer::bind_fifo() {
    FifoWires& wires = wires_.fifo;
    fifo_.clk_i(clk_i);
    fifo_.reset_i(reset_i);
    fifo_.write_i(wires.write);
    fifo_.read_i(wires.read);
    fifo_.release_i(wires.release);
    fifo_.word_o(wires.word);
    fifo_.free_o(wires.free);
    merge_stage_.write_i(wires.write);
    merge_stage_.read_o(wires.read);
    merge_stage_.word_i(wires.word);
    if (wires.second_row == nullptr) {
        return;
    }
    FifoWires::SecondRow& row = *wires.second_row;
    fifo_.second_row->next_word_o(row.next_word);
    fifo_.second_row->row_read_i(row.read);
    fifo_.second_row->row_word_o(row.word);
    fifo_.second_row->row_next_word_o(row.row_next_word);
    merge_stage_.second_row->next_word_i(row.next_word);
    merge_stage_.second_row->row_read_o(row.read);
    merge_stage_.second_row->row_word_i(row.word);
    merge_stage_.second_row->row_next_word_i(row.row_next_word);
}

void Composer::bind_pipeline_side() {
    raster_walker_.clk_i(clk_i);
    raster_walker_.reset_i(reset_i);
    raster_walker_.column_stall_i(column_stall_i);
    raster_walker_.start_i(wires_.start);
    raster_walker_.segment_i(wires_.segment);
    raster_walker_.running_o(wires_.running);
    raster_walker_.ahead_o(wires_.ahead);
    raster_walker_.uses_o(wires_.uses);
    raster_walker_.use_o(wires_.use);
    merge_stage_.clk_i(clk_i);
    merge_stage_.reset_i(reset_i);
    merge_stage_.pipemaster_i(pipemaster_i);
    merge_stage_.pipe_i(pipe_i);
    merge_stage_.pipe_o(pipe_o);
    merge_stage_.column_stall_i(column_stall_i);
    merge_stage_.stall_o(stall_o);
    merge_stage_.running_i(wires_.running);
    merge_stage_.ahead_i(wires_.ahead);
    merge_stage_.progress_i(wires_.progress);
    merge_stage_.missing_o(wires_.missing);
    pipeline_handshake_.clk_i(clk_i);
    pipeline_handshake_.reset_i(reset_i);
    pipeline_handshake_.pipemaster_i(pipemaster_i);
    pipeline_handshake_.column_stall_i(column_stall_i);
    pipeline_handshake_.startframe_i(startframe_i);
    pipeline_handshake_.startframe_o(startframe_o);
    pipeline_handshake_.pipeready_i(pipeready_i);
    pipeline_handshake_.pipeready_o(pipeready_o);
    pipeline_handshake_.fetched_i(wires_.fetched);
    pipeline_handshake_.running_i(wires_.running);
    pipeline_handshake_.start_o(wires_.start);
}

void Composer::bind_recorder() {
    raster_recorder_.clk_i(clk_i);
    raster_recorder_.reset_i(reset_i);
    raster_recorder_.column_stall_i(column_stall_i);
    raster_recorder_.start_i(wires_.start);
    raster_recorder_.running_i(wires_.running);
    raster_recorder_.ahead_i(wires_.ahead);
    raster_recorder_.progress_i(wires_.progress);
    raster_recorder_.missing_i(wires_.missing);
}

void Composer::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, pipemaster_i.port(), path("PIPEMASTER"));
    sc_core::sc_trace(file, pipeready_i.port(), path("PIPEREADY_in"));
    sc_core::sc_trace(file, pipeready_o.port(), path("PIPEREADY"));
    sc_core::sc_trace(file, startframe_i.port(), path("STARTFRAME_in"));
    sc_core::sc_trace(file, startframe_o.port(), path("STARTFRAME"));
    sc_core::sc_trace(file, busready_o.port(), path("BUSREADY"));
    sc_core::sc_trace(file, tableready_o.port(), path("TABLEREADY"));
    sc_core::sc_trace(file, stall_o.port(), path("STALL"));
    sc_trace(file, pipe_i.read(), path("PIPE_in"));
    sc_trace(file, pipe_o.read(), path("PIPE"));
    trace_lanes(file, wires_.fifo.write.read().words, pixels_per_beat_, path("fifo.write.word"));
    trace_parts(file);
}

std::string Composer::waiting_for() const {
    if (wires_.running.read()) {
        return stall_o.read() ? waits::for_segment_pixel(merge_stage_.newest_pixel(), frame(),
                                                         raster_recorder_.x(), raster_recorder_.y())
                              : waits::for_column();
    }
    if (std::string frame = beat_receiver_.waiting_for(); !frame.empty()) {
        return frame;
    }
    const int next = this->frame() + 1;
    return pipeready_o.read() ? waits::for_startframe(next) : waits::for_pipeready(next);
}

}  // namespace metabuffer::rtl
