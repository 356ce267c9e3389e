#include "monitors/dvi_monitor.h"

#include <utility>

#include "rtl/block.h"

namespace metabuffer::monitors {

DviMonitor::DviMonitor(const sc_core::sc_module_name& name, Link link, ViolationLog& log)
    : sc_core::sc_module(name), link_(std::move(link)), log_(log) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

/// An edge samples what the edge before it has driven, so at the first edge after reset there is nothing to check yet.
void DviMonitor::clock_edge() {
    ++cycle_;
    if (reset_i.read()) {
        if (state_ != State::kReset && link_.restart) link_.restart();
        state_ = State::kReset;
        return;
    }
    const rtl::DviLink& link = link_i.read();
    switch (state_) {
        case State::kReset:
            x_ = 0;
            vsync_clocks_ = 0;
            if (link_.kind == Kind::kInput) {
                line_ = 0;
                state_ = State::kFirstSync;
            } else {
                begin_frame();
                line_ = link_.timing.frame_lines() - DviTiming::kVerticalSyncLines;
            }
            return;
        case State::kFirstSync:
            step_first_sync(link);
            break;
        case State::kBetween:
            step_between(link);
            break;
        case State::kFrame:
            step_frame(link);
            break;
        case State::kLost:
            step_lost(link);
            break;
    }
    vsync_clocks_ = link.vsync ? vsync_clocks_ + 1 : 0;
}

void DviMonitor::begin_frame() {
    frame_ = link_.next_frame ? link_.next_frame() : Frame{};
    state_ = State::kFrame;
    x_ = 0;
    line_ = 0;
}

/// The clock that is checked next may be a frame's first, or one of a pause.
void DviMonitor::end_frame() {
    ++frames_seen_;
    if (link_.kind == Kind::kOutput) {
        begin_frame();
        return;
    }
    state_ = State::kBetween;
    pause_clocks_ = 0;
}

void DviMonitor::step_first_sync(const rtl::DviLink& link) {
    if (link.de || link.hsync || !link.vsync) {
        found("dvi/vsync", "a link comes up with " + std::to_string(DviTiming::kVerticalSyncLines) +
                               " lines of VSYNC alone");
        return;
    }
    if (++x_ == link_.timing.line_clocks()) {
        x_ = 0;
        if (++line_ == DviTiming::kVerticalSyncLines) {
            state_ = State::kBetween;
            pause_clocks_ = 0;
        }
    }
}

/// The lines ahead of a frame's first active one look like blanking up to the first HSYNC, which shows when the frame
/// has begun.
void DviMonitor::step_between(const rtl::DviLink& link) {
    const int sync_start = link_.timing.active_pixels + DviTiming::kHorizontalFrontPixels;
    if (link.vsync) {
        found("dvi/vsync", "VSYNC is high after the end of a frame, which has " +
                               std::to_string(DviTiming::kVerticalSyncLines) + " lines of it");
    } else if (link.de) {
        found("dvi/active-lines", "DE is high before the back porch lines of a frame");
    } else if (!link.hsync) {
        ++pause_clocks_;
    } else if (pause_clocks_ < sync_start) {
        found("dvi/hsync", "HSYNC rises " + std::to_string(pause_clocks_) + " clocks after a frame's end, " +
                               std::to_string(sync_start) + " would be the least");
    } else {
        begin_frame();
        x_ = sync_start;
        advance();
    }
}

void DviMonitor::step_frame(const rtl::DviLink& link) {
    if (frame_.corrupt) {
        // Its number of lines is not known, only that it ends with its vertical sync.
        if (x_ == 0 && !link.vsync && vsync_clocks_ > 0) {
            end_corrupt_frame(link);
            return;
        }
        check_corrupt_clock(link);
    } else {
        check_clock(link);
    }
    if (state_ == State::kFrame) advance();
}

void DviMonitor::end_corrupt_frame(const rtl::DviLink& link) {
    if (vsync_clocks_ != DviTiming::kVerticalSyncLines * link_.timing.line_clocks()) {
        found("dvi/vsync",
              "VSYNC is shorter than " + std::to_string(DviTiming::kVerticalSyncLines) + " lines");
    }
    end_frame();
    step_between(link);
}

/// The end of a vertical sync shows where the next frame can begin. A short pulse of VSYNC does not count.
void DviMonitor::step_lost(const rtl::DviLink& link) {
    if (link.vsync || vsync_clocks_ < link_.timing.line_clocks()) return;
    end_frame();
    if (link_.kind == Kind::kInput) {
        step_between(link);
    } else {
        step_frame(link);
    }
}

void DviMonitor::advance() {
    if (++x_ < link_.timing.line_clocks()) return;
    x_ = 0;
    if (++line_ == link_.timing.frame_lines() && !frame_.corrupt) end_frame();
}

bool DviMonitor::active_line() const {
    return line_ >= DviTiming::kVerticalBackLines &&
           line_ < DviTiming::kVerticalBackLines + link_.timing.active_lines;
}

bool DviMonitor::hsync_due() const {
    const int sync_start = link_.timing.active_pixels + DviTiming::kHorizontalFrontPixels;
    return x_ >= sync_start && x_ < sync_start + DviTiming::kHorizontalSyncPixels;
}

void DviMonitor::check_clock(const rtl::DviLink& link) {
    const DviTiming& timing = link_.timing;
    const bool vsync_due = line_ >= timing.frame_lines() - DviTiming::kVerticalSyncLines;
    const bool de_due = active_line() && x_ < timing.active_pixels;
    if (link.vsync == vsync_due && link.de == de_due && link.hsync == hsync_due()) return;

    if (link.vsync != vsync_due) {
        const std::string what = std::string("VSYNC is ") + level_name(link.vsync) + ", " +
                                 level_name(vsync_due) + " would be right: it is high in the last " +
                                 std::to_string(DviTiming::kVerticalSyncLines) + " of " +
                                 std::to_string(timing.frame_lines()) + " lines";
        found(x_ == 0 ? "dvi/vsync" : "dvi/vsync-at-line-start", what);
        return;
    }
    if (link.de != de_due) {
        const int sync_end =
            timing.active_pixels + DviTiming::kHorizontalFrontPixels + DviTiming::kHorizontalSyncPixels;
        const bool line_too_short = link.de && x_ >= sync_end;
        const bool line_too_long = !link.de && x_ == 0 && line_ > DviTiming::kVerticalBackLines;
        const char* rule = line_too_short || line_too_long ? "dvi/line-length"
                           : !active_line() || x_ == 0     ? "dvi/active-lines"
                                                           : "dvi/active-pixels";
        found(rule, std::string("DE is ") + level_name(link.de) + ", " + level_name(de_due) +
                        " would be right: lines of " + std::to_string(timing.line_clocks()) +
                        " clocks, the first " + std::to_string(timing.active_pixels) + " active in lines " +
                        std::to_string(DviTiming::kVerticalBackLines) + " to " +
                        std::to_string(DviTiming::kVerticalBackLines + timing.active_lines - 1));
        return;
    }
    found("dvi/hsync", std::string("HSYNC is ") + level_name(link.hsync) + ", " + level_name(!link.hsync) +
                           " would be right: it is high from clock " +
                           std::to_string(timing.active_pixels + DviTiming::kHorizontalFrontPixels) +
                           " on for " + std::to_string(DviTiming::kHorizontalSyncPixels));
}

void DviMonitor::check_corrupt_clock(const rtl::DviLink& link) {
    if (link.hsync != hsync_due()) {
        found("dvi/hsync", std::string("HSYNC is ") + level_name(link.hsync) +
                               " in a frame of faulty lines, " + level_name(!link.hsync) + " would be right");
        return;
    }
    const bool was_vsync = vsync_clocks_ > 0;
    if (x_ != 0 && link.vsync != was_vsync) {
        found("dvi/vsync-at-line-start", "VSYNC changes within a line");
    } else if (vsync_clocks_ >= DviTiming::kVerticalSyncLines * link_.timing.line_clocks()) {
        found("dvi/vsync",
              "VSYNC is longer than " + std::to_string(DviTiming::kVerticalSyncLines) + " lines");
    }
}

void DviMonitor::found(const char* rule, const std::string& what) {
    std::string where;
    if (state_ == State::kFrame) {
        where = "clock " + std::to_string(x_) + " of line " + std::to_string(line_) + ": ";
    }
    state_ = State::kLost;
    log_.add({rule, link_.signal, link_.clock, cycle_, frame_.number, where + what});
}

}  // namespace metabuffer::monitors
