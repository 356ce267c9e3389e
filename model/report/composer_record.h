#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "report/report.h"

namespace metabuffer {

/// What a composer of level rtl, or an observer of its ports, reports: counters, and the core cycles of events. It is not
/// hardware.
class ComposerRecord {
  public:
    static constexpr std::int64_t kNever = -1;

    /// Core cycles of a frame's STARTFRAME and of its first and last pixel composited.
    struct FrameSpan {
        std::int64_t startframe_cycle = kNever;
        std::int64_t start_cycle = kNever;
        std::int64_t end_cycle = kNever;
    };

    const ComposerCounters& counters() const { return counters_; }
    /// One for each frame that has started.
    const std::vector<FrameSpan>& frame_spans() const { return frame_spans_; }
    /// A reset is over: the next frame is number 0.
    void forget_frames() {
        frame_spans_.clear();
        counters_.starved_by_frame.clear();
    }
    /// Core cycle of the first BUSREADY drop in a burst, and of the first starved pixel or stalled clock.
    std::int64_t first_busready_drop_cycle() const { return first_busready_drop_cycle_; }
    std::int64_t first_starved_cycle() const { return first_starved_cycle_; }
    /// Called for each starved raster pixel (`glitch` mode).
    void on_starved_pixel(std::function<void(const StarvedPixel&)> callback) {
        on_starved_pixel_ = std::move(callback);
    }

    // What the composer's parts report.

    ComposerCounters& mutable_counters() { return counters_; }
    void frame_started(std::int64_t cycle) { frame_spans_.push_back({cycle, kNever, kNever}); }
    void first_pixel_composited(std::int64_t cycle) {
        if (!frame_spans_.empty()) frame_spans_.back().start_cycle = cycle;
    }
    void last_pixel_composited(std::int64_t cycle) {
        if (!frame_spans_.empty()) frame_spans_.back().end_cycle = cycle;
    }
    /// Number of the frame that has started last; -1: none yet.
    int frame() const { return static_cast<int>(frame_spans_.size()) - 1; }
    void count_busready_drop(std::int64_t cycle) {
        ++counters_.busready_drops;
        note_first(first_busready_drop_cycle_, cycle);
    }
    /// A pixel starved or a clock was stalled.
    void note_starved(std::int64_t cycle) { note_first(first_starved_cycle_, cycle); }
    void count_starved_pixel(const StarvedPixel& pixel, std::int64_t cycle) {
        note_starved(cycle);
        counters_.add_starved_pixel(pixel);
        if (on_starved_pixel_) {
            on_starved_pixel_(pixel);
        }
    }

  protected:
    ~ComposerRecord() = default;

    ComposerCounters counters_;
    std::vector<FrameSpan> frame_spans_;

  private:
    static void note_first(std::int64_t& first, std::int64_t cycle) {
        if (first == kNever) {
            first = cycle;
        }
    }

    std::int64_t first_busready_drop_cycle_ = kNever;
    std::int64_t first_starved_cycle_ = kNever;
    std::function<void(const StarvedPixel&)> on_starved_pixel_;
};

}  // namespace metabuffer
