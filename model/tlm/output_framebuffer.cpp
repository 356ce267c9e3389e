#include "tlm/output_framebuffer.h"

#include <algorithm>

#include "datapath/colour_correction.h"
#include "datapath/span.h"
#include "report/waits.h"

namespace metabuffer::tlm {

OutputFramebuffer::OutputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario,
                                     int display, ColumnTime& column, SwapLock& swap_lock,
                                     std::int64_t pipeready_cycle)
    : sc_core::sc_module(name),
      scenario_(scenario),
      column_(column),
      swap_lock_(swap_lock),
      first_pipeready_cycle_(pipeready_cycle),
      colour_table_(scenario.displays.colour_table_of(display)) {
    pipe_socket.register_b_transport(this, &OutputFramebuffer::take_band);
    pipe_socket.register_nb_transport_fw(this, &OutputFramebuffer::take_startframe);
    swap_lock.on_swap([this](int frame, std::int64_t pipeready_cycle, std::int64_t shown_picoseconds) {
        take_swap(frame, pipeready_cycle, shown_picoseconds);
    });
    SC_METHOD(show);
    sensitive << shown_event_;
    dont_initialize();
}

void OutputFramebuffer::start_of_simulation() { raise_pipeready(0, first_pipeready_cycle_); }

void OutputFramebuffer::raise_pipeready(int frame, std::int64_t cycle) {
    pipeline_->frame = frame;
    pipeline_->cycle = cycle;
    transport_backward(pipe_socket, pipeline_.payload(), pipeready_phase);
}

::tlm::tlm_sync_enum OutputFramebuffer::take_startframe(Payload& /*payload*/, Phase& /*phase*/,
                                                        sc_core::sc_time& /*delay*/) {
    return ::tlm::TLM_ACCEPTED;  // the column knows when its pixels come
}

void OutputFramebuffer::take_band(Payload& payload, sc_core::sc_time& /*delay*/) {
    const auto& band = content_of<PipelineFrame>(payload);
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    const DisplayConfig& displays = scenario_.displays;
    if (band.raster != nullptr) {
        ColourImage& bank = banks_[static_cast<std::size_t>(band.frame % 2)];
        if (bank.values.empty()) {
            bank = ColourImage(displays.width_pixels, displays.height_pixels);
        }
        for (int row = 0; row < band.rows; row += displays.supersample) {
            const auto width = static_cast<std::size_t>(displays.width_pixels);
            std::uint32_t* const shown = &bank.at(0, (band.first_row + row) / displays.supersample);
            average_span(&band.raster->argb[band.raster->index(0, row)], displays.supersample, width, shown);
            if (colour_table_ != nullptr) {
                correct_span(*colour_table_, shown, width);
            }
        }
    }
    if (band.first_row + band.rows == displays.raster_height_pixels()) {
        swap_lock_.frame_done(band.frame, column_.frame(band.frame).cycle_of(column_.last_step()));
    }
}

void OutputFramebuffer::take_swap(int frame, std::int64_t pipeready_cycle, std::int64_t shown_picoseconds) {
    showing_.push_back({frame, shown_picoseconds});
    if (showing_.size() == 1) {
        wait_for_end_of_frame();
    }
    raise_pipeready(frame + 1, pipeready_cycle);
}

void OutputFramebuffer::wait_for_end_of_frame() {
    const auto shown = static_cast<sc_dt::uint64>(showing_.front().picoseconds);
    shown_event_.notify(sc_core::sc_time::from_value(shown) - sc_core::sc_time_stamp());
}

void OutputFramebuffer::show() {
    const int frame = showing_.front().frame;
    showing_.pop_front();
    if (!showing_.empty()) {
        wait_for_end_of_frame();
    }
    shown_->frame = frame;
    const ColourImage& bank = banks_[static_cast<std::size_t>(frame % 2)];
    shown_->image = bank.values.empty() ? nullptr : &bank;
    transport(dvi_socket, shown_.payload());
}

std::int64_t OutputFramebuffer::pixels_taken(std::int64_t through_cycle) const {
    const int frame = column_.newest_frame();
    if (frame < 0) {
        return 0;
    }
    const std::int64_t steps = column_.frame(frame).step_at(through_cycle) - column_.renderers();
    return frame * column_.raster_pixels() + std::clamp<std::int64_t>(steps, 0, column_.raster_pixels());
}

std::string OutputFramebuffer::waiting_for(std::int64_t through_cycle) const {
    const int newest = column_.newest_frame();
    const std::int64_t position =
        newest < 0 ? -1 : column_.frame(newest).step_at(through_cycle) - column_.renderers();
    if (position >= 0 && position < column_.raster_pixels()) {
        return waits::for_raster_pixel(position, newest);
    }
    // The start of the newest frame may be known before it happens.
    const int taken = position < 0 ? newest - 1 : newest;
    const bool bank_free =
        taken < 0 || (swap_lock_.swaps() > taken && swap_lock_.pipeready_cycle() <= through_cycle);
    return bank_free ? waits::for_startframe(std::max(taken + 1, 0)) : waits::for_swaplock(taken);
}

}  // namespace metabuffer::tlm
