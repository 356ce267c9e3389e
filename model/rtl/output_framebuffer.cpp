#include "rtl/output_framebuffer.h"

#include "datapath/colour_correction.h"
#include "report/waits.h"

namespace metabuffer::rtl {

OutputFramebuffer::OutputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario,
                                     int display, ClockGating gating)
    : Block(name),
      display_(scenario.displays),
      timing_(display_.timing()),
      may_stall_(scenario.composer.on_starvation == StarvationMode::kStall),
      raster_pixels_(std::int64_t{display_.raster_width_pixels()} * display_.raster_height_pixels()),
      colour_table_(display_.colour_table_of(display)),
      gate_(gating),
      averager_(core_registers_, "averager", 1, Averager(display_.width_pixels, display_.supersample)),
      raster_position_(core_registers_, "raster_position", bits_for(raster_pixels_)),
      next_word_(core_registers_, "next_word",
                 bits_for(std::int64_t{display_.width_pixels} * display_.height_pixels)),
      frames_taken_(core_registers_, "frames_taken", bits_for(scenario.frames)),
      front_frame_(dvi_registers_, "front_frame", 1 + bits_for(scenario.frames), -1),
      x_(dvi_registers_, "x", bits_for(timing_.line_clocks())),
      // The first frame is preceded by its vertical sync.
      line_(dvi_registers_, "line", bits_for(timing_.frame_lines()),
            timing_.frame_lines() - DviTiming::kVerticalSyncLines),
      next_shown_(dvi_registers_, "next_shown",
                  bits_for(std::int64_t{display_.width_pixels} * display_.height_pixels)) {
    for (std::vector<std::uint32_t>& bank : banks_) {
        bank.resize(static_cast<std::size_t>(display_.width_pixels) *
                    static_cast<std::size_t>(display_.height_pixels));
    }
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
    SC_METHOD(dvi_clock_edge);
    sensitive << dvi_clk_i.pos();
    dont_initialize();
}

// ---- core clock ----

void OutputFramebuffer::reset() {
    core_registers_.reset();
    pipeready_o.write(false);
    framedone_o.write(false);
    framebad_o.write(false);
}

void OutputFramebuffer::end_of_elaboration() {
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= startframe_i.value_changed_event();
    wake_events_ |= column_stall_i.value_changed_event();
    wake_events_ |= swapped_.value_changed_event();
}

void OutputFramebuffer::clock_edge() {
    if (gate_.opened()) {
        return;
    }
    if (reset_i.read()) {
        reset();
        return;
    }
    const bool swapped = swapped_synchronizer_.sample(swapped_.read());
    if (swapped && !swapped_seen_) {
        frame_done_ = false;
        // It is stable: it was set at the swap, which has crossed two registers since then.
        if (!swap_skipped_) {
            back_ = 1 - back_;
        }
        mark_frame(false);
    }
    swapped_seen_ = swapped;
    // Nothing ever raises COLUMNSTALL in glitch mode.
    const bool stalled = may_stall_ && column_stall_i.read();
    if (stalled) {
        ++stalled_cycles_;
    } else if (receiving_) {
        take_pixel(pipe_i.read());
    } else if (startframe_i.read()) {
        receiving_ = true;
        raster_position_ = 0;
        next_word_ = 0;
        averager_->restart();
    }
    const bool framedone = frame_done_ && !swapped;
    if (framedone != framedone_) {
        framedone_ = framedone;
        framedone_o.write(framedone);
    }
    const bool pipeready = !receiving_ && !frame_done_;
    if (pipeready != pipeready_) {
        pipeready_ = pipeready;
        pipeready_o.write(pipeready);
    }
    if (gate_.idle_edge(!receiving_ && !stalled && swapped_synchronizer_.settled(swapped_.read()))) {
        next_trigger(wake_events_);
    }
}

void OutputFramebuffer::mark_frame(bool bad) {
    if (bad != framebad_) {
        framebad_ = bad;
        framebad_o.write(bad);
    }
}

void OutputFramebuffer::take_pixel(const PipePixel& pixel) {
    if (!pixel.valid) {
        SC_REPORT_ERROR(
            "/metabuffer/output_framebuffer/bubble",
            (std::string(name()) + " found no pixel at raster position " + std::to_string(raster_position_))
                .c_str());
        return;
    }
    ++pixels_taken_;
    if (pixel.lost) {
        mark_frame(true);
    }
    std::uint32_t& word = banks_[back_][next_word_];
    if (averager_->push(pixel.pixel, word)) {
        if (colour_table_ != nullptr) {
            word = corrected(*colour_table_, word);
        }
        ++next_word_;
    }
    ++raster_position_;
    if (raster_position_ == raster_pixels_) {
        receiving_ = false;
        frame_done_ = true;
        ++frames_taken_;
    }
}

// ---- DVI output clock ----

void OutputFramebuffer::dvi_reset() {
    dvi_registers_.reset();
    swaps_.clear();
    swapped_.write(false);
    link_o.write(link_);
}

void OutputFramebuffer::start_dvi_frame() {
    next_shown_ = 0;
    if (!swap_pending_) {
        return;
    }
    swap_pending_ = false;
    swaps_.push_back({now_picoseconds(), swap_skipped_});
    if (swap_skipped_) {
        ++kept_frames_;
    } else {
        front_ = 1 - front_;
        picture_shown_ = true;
    }
    ++front_frame_;
    swapped_.write(true);
}

void OutputFramebuffer::dvi_clock_edge() {
    if (reset_i.read()) {
        dvi_reset();
        return;
    }
    const bool swaplock = swaplock_synchronizer_.sample(swaplock_i.read());
    if (!swaplock) {
        swapped_.write(false);
    } else if (!swapped_.read()) {
        swap_pending_ = true;
        // SWAPSKIP needs no synchronizer: it is stable at least as long as SWAPLOCK, which has crossed two registers.
        swap_skipped_ = swapskip_i.read();
    }

    if (x_ == 0) {
        if (line_ == timing_.frame_lines()) {
            line_ = 0;
        }
        if (line_ == 0) {
            start_dvi_frame();
        }
        vsync_line_ = line_ >= timing_.frame_lines() - DviTiming::kVerticalSyncLines;
        active_line_ = line_ >= DviTiming::kVerticalBackLines &&
                       line_ < DviTiming::kVerticalBackLines + timing_.active_lines;
    }
    DviLink link;
    link.vsync = vsync_line_;
    link.de = active_line_ && x_ < timing_.active_pixels;
    if (link.de && picture_shown_) {
        link.data = banks_[front_][next_shown_];
        ++next_shown_;
    }
    const int sync_start = timing_.active_pixels + DviTiming::kHorizontalFrontPixels;
    link.hsync = x_ >= sync_start && x_ < sync_start + DviTiming::kHorizontalSyncPixels;
    if (!(link == link_.value())) {
        link_ = link;
        link_o.write(link_);
    }
    ++x_;
    if (x_ == timing_.line_clocks()) {
        x_ = 0;
        ++line_;
    }
}

void OutputFramebuffer::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, startframe_i, path("STARTFRAME_in"));
    sc_core::sc_trace(file, pipeready_o, path("PIPEREADY"));
    sc_core::sc_trace(file, framedone_o, path("FRAMEDONE"));
    sc_core::sc_trace(file, framebad_o, path("FRAMEBAD"));
    sc_core::sc_trace(file, swaplock_i, path("SWAPLOCK"));
    sc_core::sc_trace(file, swapskip_i, path("SWAPSKIP"));
    sc_core::sc_trace(file, swapped_, path("swapped"));
    sc_trace(file, pipe_i.read(), path("PIPE_in"));
    sc_trace(file, link_o.read(), path("DVI"));
    core_registers_.trace(file, path(""));
    dvi_registers_.trace(file, path(""));
}

std::string OutputFramebuffer::waiting_for() const {
    if (receiving_) {
        return waits::for_raster_pixel(raster_position_, frames_taken_);
    }
    return frame_done_ ? waits::for_swaplock(frames_taken_ - 1) : waits::for_startframe(frames_taken_);
}

}  // namespace metabuffer::rtl
