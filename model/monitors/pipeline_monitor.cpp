#include "monitors/pipeline_monitor.h"

#include <algorithm>
#include <utility>

namespace metabuffer::monitors {
namespace {

constexpr const char* kSkew = "skew";
constexpr const char* kFrame = "frame";

}  // namespace

PipelineMonitor::PipelineMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int display,
                                 ViolationLog& log)
    : sc_core::sc_module(name),
      startframe_o("startframe_o", scenario.renderers.size()),
      pipe_o("pipe_o", scenario.renderers.size()),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      may_stall_(scenario.composer.may_stall()),
      raster_width_(scenario.displays.raster_width_pixels()),
      raster_pixels_(raster_width_ * scenario.displays.raster_height_pixels()),
      display_("display " + std::to_string(display + 1) + ": "),
      reporter_(log),
      startframe_(scenario.renderers.size()),
      valid_(scenario.renderers.size()) {}

void PipelineMonitor::end_of_elaboration() {
    pipeready_name_ = signal_name(pipeready_i);
    for (const auto& port : startframe_o) {
        startframe_names_.push_back(signal_name(port));
    }
    for (const auto& port : pipe_o) {
        pipe_names_.push_back(signal_name(port));
    }
}

void PipelineMonitor::restart() {
    std::fill(startframe_.begin(), startframe_.end(), std::uint8_t{0});
    std::fill(valid_.begin(), valid_.end(), std::uint8_t{0});
    stood_still_ = receiving_ = pipeready_ = startframe_read_ = false;
    frame_ = -1;
    frames_taken_ = 0;
    seen_reset_ = true;
}

void PipelineMonitor::clock_edge() {
    if (reset_i.read()) {
        clocked_.stay_awake();
        restart();
        return;
    }
    if (!seen_reset_) {
        return;
    }
    const std::int64_t edge = rtl::clock_edge_number(core_period_picoseconds_);
    const bool moves = check_skew(edge);
    check_framebuffer(edge);
    if (moves || receiving_ || startframe_read_ || stood_still_) {
        clocked_.stay_awake();
    }
}

/// Each stage shows what the one above showed a clock earlier. True if anything is in the pipeline.
bool PipelineMonitor::check_skew(std::int64_t edge) {
    bool moves = false;
    std::uint8_t startframe_above = 0;
    std::uint8_t valid_above = 0;
    for (std::size_t r = 0; r < startframe_.size(); ++r) {
        const auto startframe = static_cast<std::uint8_t>(startframe_o[r].read());
        const auto valid = static_cast<std::uint8_t>(pipe_o[r].read().valid);
        moves = moves || startframe != 0 || valid != 0;
        // A stage that stands still shows what it showed before; the top stage makes its own values.
        const bool judged = r > 0 || stood_still_;
        if (judged && startframe != (stood_still_ ? startframe_[r] : startframe_above)) {
            reporter_.report(kSkew, "pipeline/skew", startframe_names_[r], edge, frame_,
                             display_ +
                                 (startframe != 0 ? "STARTFRAME that the stage above did not show"
                                                  : "no STARTFRAME, which the stage above showed") +
                                 " a clock earlier");
        }
        if (judged && valid != (stood_still_ ? valid_[r] : valid_above)) {
            reporter_.report(kSkew, "pipeline/skew", pipe_names_[r], edge, frame_,
                             display_ +
                                 (valid != 0 ? "a pixel that the stage above did not show"
                                             : "no pixel, though the stage above showed one") +
                                 " a clock earlier");
        }
        startframe_above = std::exchange(startframe_[r], startframe);
        valid_above = std::exchange(valid_[r], valid);
    }
    return moves;
}

/// Checks what the output framebuffer reads at this edge, and its PIPEREADY since the edge before.
void PipelineMonitor::check_framebuffer(std::int64_t edge) {
    const bool pipeready = pipeready_i.read();
    if (pipeready_ && !pipeready && !startframe_read_ && !receiving_) {
        reporter_.report(kFrame, "pipeready/framebuffer", pipeready_name_, edge, frame_ + 1,
                         display_ + "PIPEREADY is taken back before STARTFRAME");
    } else if (pipeready && (startframe_read_ || receiving_)) {
        reporter_.report(kFrame, "pipeready/framebuffer", pipeready_name_, edge, frame_,
                         display_ + "PIPEREADY is high while a frame comes in");
    }
    pipeready_ = pipeready;
    startframe_read_ = false;
    stood_still_ = may_stall_ && column_stall_i.read();
    if (stood_still_) {
        ++stalled_cycles_;
        return;
    }
    const bool was_receiving = receiving_;
    if (receiving_) {
        take_pixel(edge);
    } else if (valid_.back() != 0) {
        reporter_.report(kFrame, "pipeline/outside", pipe_names_.back(), edge, frame_,
                         display_ + "a pixel outside a frame's raster");
    }
    if (startframe_.back() != 0 && was_receiving) {
        reporter_.report(kFrame, "pipeline/frame", startframe_names_.back(), edge, frame_,
                         display_ + "STARTFRAME before the frame is over");
    } else if (startframe_.back() != 0) {
        receiving_ = startframe_read_ = true;
        raster_position_ = 0;
        ++frame_;
    }
}

void PipelineMonitor::take_pixel(std::int64_t edge) {
    if (valid_.back() == 0) {
        reporter_.report(kFrame, "pipeline/bubble", pipe_names_.back(), edge, frame_,
                         display_ + "no pixel at raster position " +
                             std::to_string(raster_position_ % raster_width_) + ", " +
                             std::to_string(raster_position_ / raster_width_));
    }
    if (++raster_position_ == raster_pixels_) {
        receiving_ = false;
        ++frames_taken_;
    }
}

}  // namespace metabuffer::monitors
