#include "rtl/dvi_output.h"

namespace metabuffer::rtl {
namespace {

/// Clocks from a pixel's read at read_o to the pixel on the link.
constexpr int kReadClocks = 2;
/// Of the horizontal sync, from the end of the active pixels.
constexpr int kSyncStart = DviTiming::kHorizontalFrontPixels;
constexpr int kSyncEnd = kSyncStart + DviTiming::kHorizontalSyncPixels;

}  // namespace

DviOutput::DviOutput(const sc_core::sc_module_name& name, const Scenario& scenario)
    : Block(name),
      timing_(scenario.displays.timing()),
      front_frame_(registers_, "front_frame", 1 + bits_for(scenario.frames), -1),
      x_(registers_, "x", bits_for(timing_.line_clocks())),
      // The first frame is preceded by its vertical sync.
      line_(registers_, "line", bits_for(timing_.frame_lines()),
            timing_.frame_lines() - DviTiming::kVerticalSyncLines),
      next_read_(registers_, "next_read", bits_for(scenario.displays.pixels())),
      read_(registers_, "read", bits_for(scenario.displays.pixels() - 1)) {}

void DviOutput::reset() {
    registers_.reset();
    swaps_.clear();
    swapped_o.write(swapped_);
    skipped_o.write(swap_skipped_);
    reads_o.write(reads_);
    read_o.write(read_);
    link_o.write(link_);
}

void DviOutput::clock_edge() {
    follow_swaplock();
    if (x_ == 0) {
        start_line();
    }
    drive_link();
    read_ahead();
    ++x_;
    if (x_ == timing_.line_clocks()) {
        x_ = 0;
        ++line_;
    }
}

void DviOutput::follow_swaplock() {
    if (!swaplock_.sample(swaplock_i.read())) {
        if (swapped_) {
            swapped_ = false;
            swapped_o.write(swapped_);
        }
    } else if (!swapped_) {
        swap_pending_ = true;
        // SWAPSKIP needs no synchronizer: it is stable at least as long as SWAPLOCK, which has crossed two registers.
        if (swapskip_i.read() != swap_skipped_) {
            swap_skipped_ = !swap_skipped_;
            skipped_o.write(swap_skipped_);
        }
    }
}

void DviOutput::start_line() {
    if (line_ == timing_.frame_lines()) {
        line_ = 0;
    }
    if (line_ == 0) {
        start_frame();
    }
    vsync_line_ = line_ >= timing_.frame_lines() - DviTiming::kVerticalSyncLines;
    active_line_ = is_active(line_);
}

void DviOutput::start_frame() {
    next_read_ = 0;
    if (!swap_pending_) {
        return;
    }
    swap_pending_ = false;
    swaps_.push_back({now_picoseconds(), swap_skipped_});
    if (swap_skipped_) {
        ++kept_frames_;
    } else {
        front_ = !front_;
        picture_shown_ = true;
    }
    ++front_frame_;
    swapped_ = true;
    swapped_o.write(swapped_);
}

void DviOutput::drive_link() {
    const int into_blanking = x_ - timing_.active_pixels;
    const bool changes =
        x_ == 0 || into_blanking == 0 || into_blanking == kSyncStart || into_blanking == kSyncEnd;
    const bool shows = picture_shown_ && active_line_ && into_blanking < 0;
    if (!changes && !shows) {
        return;
    }
    DviLink link;
    link.vsync = vsync_line_;
    link.de = active_line_ && into_blanking < 0;
    link.hsync = into_blanking >= kSyncStart && into_blanking < kSyncEnd;
    link.data = shows ? data_i.read() : 0;
    drive_output(link_, link_o, link);
}

/// Reads the pixel that is on the link kReadClocks later. A line's blanking is longer than that, and a frame begins with
/// blank lines.
void DviOutput::read_ahead() {
    bool reads = false;
    if (picture_shown_) {
        const int ahead = x_ + kReadClocks;
        reads = ahead < timing_.line_clocks()
                    ? active_line_ && ahead < timing_.active_pixels
                    : is_active(line_ + 1) && ahead - timing_.line_clocks() < timing_.active_pixels;
    }
    if (reads) {
        read_ = {front_, next_read_};
        read_o.write(read_);
        ++next_read_;
    }
    drive_output(reads_, reads_o, reads);
}

void DviOutput::trace(sc_core::sc_trace_file* file) const { registers_.trace(file, path("")); }

}  // namespace metabuffer::rtl
