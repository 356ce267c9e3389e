#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "report/cycle_span.h"

namespace metabuffer::tlm {

/// A core clock that is not known yet, or will never come.
constexpr std::int64_t kUnknownCycle = std::numeric_limits<std::int64_t>::max();
/// A pipeline step that nothing ever needs.
constexpr std::int64_t kNoStep = std::numeric_limits<std::int64_t>::max();

/// Frames whose timing can be queried at the same time: one being composited, the one after it, and those that are
/// finished but not released yet.
constexpr int kFramesKept = 4;

/// The smallest of a fixed number of values that change one at a time.
class MinimumTree {
  public:
    explicit MinimumTree(std::size_t count);
    void set(std::size_t index, std::int64_t value);
    std::int64_t value(std::size_t index) const { return tree_[leaves_ + index]; }
    std::int64_t minimum() const { return tree_[1]; }

  private:
    std::size_t leaves_ = 1;
    std::vector<std::int64_t> tree_;
};

/// The clocks of a column's pipeline in one frame. The column moves in steps: the top composer sees its start in step
/// 0, composer r in step r; composer r composites raster position p in step r + 1 + p. A step takes a clock, and a
/// stall is clocks without a step. The clocks of steps up to last_known_step() are final.
class FrameTime {
  public:
    void start(std::int64_t cycle);
    bool started() const { return !anchors_.empty(); }
    std::int64_t start_cycle() const { return anchors_.front().cycle; }

    /// The clock of a step; kUnknownCycle beyond last_known_step().
    std::int64_t cycle_of(std::int64_t step) const {
        return started() && step <= last_known_step_ ? extrapolated_cycle(step) : kUnknownCycle;
    }
    /// The clock of a step if there are no stalls except those reported so far; the real clock is this one or later.
    std::int64_t extrapolated_cycle(std::int64_t step) const;
    /// The last step at or before a clock, -1 if there is none.
    std::int64_t step_at(std::int64_t cycle) const;

    std::int64_t last_known_step() const { return last_known_step_; }
    void set_last_known_step(std::int64_t step) { last_known_step_ = step; }
    /// Makes the clock of `step` no earlier than `cycle`; no later step may have been delayed yet. Returns the clocks
    /// that this adds.
    std::int64_t delay_step(std::int64_t step, std::int64_t cycle);

  private:
    /// From `step` on, steps follow each other clock by clock, up to the next anchor.
    struct Anchor {
        std::int64_t step;
        std::int64_t cycle;
    };
    std::vector<Anchor> anchors_;
    std::int64_t last_known_step_ = kNoStep;
};

/// The time of one display's pipeline, frame by frame (section 5.4 of the paper), and in `stall` mode the clocks in
/// which it stands still (COLUMNSTALL). No clock is simulated: each composer reports which step needs the first pixel
/// whose arrival is not known yet, and which known arrivals come too late for their step.
class ColumnTime {
  public:
    ColumnTime(int renderers, std::int64_t raster_pixels, bool may_stall);

    std::int64_t raster_pixels() const { return raster_pixels_; }
    int renderers() const { return renderers_; }
    bool may_stall() const { return may_stall_; }

    /// The frame's step 0 is at that clock. In `stall` mode no later step is known before every composer has reported
    /// what it needs.
    void start(int frame, std::int64_t cycle);
    /// The frame that is being composited or was the last one; -1: none yet.
    int newest_frame() const { return newest_frame_; }
    const FrameTime& frame(int frame) const { return frames_[static_cast<std::size_t>(frame % kFramesKept)]; }
    bool started(int frame) const { return frame <= newest_frame_; }

    /// `stall` mode, frame newest_frame(): the step that needs composer r's first pixel without a known arrival,
    /// kNoStep if all arrivals are known.
    void set_needed_step(int renderer, std::int64_t step) {
        needed_steps_.set(static_cast<std::size_t>(renderer), step);
    }
    /// `stall` mode: a pixel that is needed after `step` arrives at `arrival`, so step + 1 comes later than that.
    void add_arrival(int renderer, std::int64_t step, std::int64_t arrival);
    /// `stall` mode: works out what has become known. `now` is the present clock.
    void advance(std::int64_t now);

    /// Calls back, once, when a frame's step is known: at once if it is, else from start() or advance().
    void when_known(int frame, std::int64_t step, std::function<void()> callback);
    /// Calls the callbacks whose steps are known now. To be called after start() and advance(), once the caller's own
    /// state is consistent.
    void call_waiters();

    /// The step's clock, if it is known.
    std::int64_t cycle_of(int frame, std::int64_t step) const {
        return started(frame) ? this->frame(frame).cycle_of(step) : kUnknownCycle;
    }
    /// The step comes no earlier than this.
    std::int64_t not_before(int frame, std::int64_t step, std::int64_t now) const {
        return started(frame) ? this->frame(frame).extrapolated_cycle(step) : now + step;
    }
    /// The output framebuffer receives the newest frame's last pixel in this step.
    std::int64_t last_step() const { return renderers_ + raster_pixels_; }

    /// Called with each stretch of clocks in which the column stands still.
    void on_stall(std::function<void(int frame, CycleSpan stall)> callback) {
        on_stall_ = std::move(callback);
    }

    /// The clock of a frame's step 0; the frame must have been started.
    std::int64_t start_cycle(int frame) const { return start_cycles_[static_cast<std::size_t>(frame)]; }
    /// From a frame's first pixel in the top composer to its last one in the bottom one; the frame must have been
    /// composited.
    CycleSpan composition(int frame) const { return compositions_[static_cast<std::size_t>(frame)]; }
    /// The newest frame has been composited; its timing will be forgotten.
    void note_composited();
    bool composited(int frame) const { return static_cast<std::size_t>(frame) < compositions_.size(); }

    /// Clocks in which the column stood still, in all and because of one composer, up to a clock that is `now` or
    /// later.
    std::int64_t stalled_cycles(std::int64_t through_cycle) const {
        return stalled_cycles_for(kColumn, through_cycle);
    }
    std::int64_t stalled_cycles_for(int renderer, std::int64_t through_cycle) const;
    /// The first clock in which composer r finds that the column must stand still in the next one, as far as is known;
    /// kUnknownCycle if there is none.
    std::int64_t first_stall_cycle(int renderer) const;

  private:
    struct Arrival {
        std::int64_t step;
        std::int64_t cycle;
        int renderer;
        friend bool operator>(const Arrival& a, const Arrival& b) { return a.step > b.step; }
    };
    struct Waiter {
        int frame;
        std::int64_t step;
        std::function<void()> callback;
        friend bool operator>(const Waiter& a, const Waiter& b) {
            return a.frame != b.frame ? a.frame > b.frame : a.step > b.step;
        }
    };
    static constexpr int kColumn = -1;  ///< in the place of a renderer
    /// Clocks without a step: caused by one composer, or of the whole column.
    struct Stall {
        int renderer = kColumn;
        CycleSpan cycles;
    };

    FrameTime& current() { return frames_[static_cast<std::size_t>(newest_frame_ % kFramesKept)]; }
    void count_stall(int renderer, CycleSpan cycles);
    std::size_t stall_index(int renderer) const {
        return static_cast<std::size_t>(std::int64_t{renderer} + 1);
    }
    void forget_stalls(std::int64_t now);

    int renderers_;
    std::int64_t raster_pixels_;
    bool may_stall_;
    int newest_frame_ = -1;
    FrameTime frames_[kFramesKept];
    MinimumTree needed_steps_;
    std::priority_queue<Arrival, std::vector<Arrival>, std::greater<>> arrivals_;
    std::vector<std::int64_t> start_cycles_;  ///< by frame
    std::vector<CycleSpan> compositions_;     ///< by frame
    std::vector<Waiter> waiters_;             ///< a heap, the earliest first
    std::function<void(int, CycleSpan)> on_stall_;
    std::vector<std::int64_t> stalled_cycles_;      ///< of the column, then by renderer
    std::vector<std::int64_t> first_stall_cycles_;  ///< by renderer, of those that are counted
    std::size_t forget_at_ = 0;                     ///< size of newest_stalls_ at which it is cleaned up
    std::vector<Stall> newest_stalls_;              ///< counted already, perhaps beyond the present
};

}  // namespace metabuffer::tlm
