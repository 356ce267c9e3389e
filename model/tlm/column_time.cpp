#include "tlm/column_time.h"

#include <algorithm>
#include <utility>

namespace metabuffer::tlm {

MinimumTree::MinimumTree(std::size_t count) {
    while (leaves_ < count) {
        leaves_ *= 2;
    }
    tree_.assign(2 * leaves_, std::numeric_limits<std::int64_t>::max());
}

void MinimumTree::set(std::size_t index, std::int64_t value) {
    std::size_t node = leaves_ + index;
    tree_[node] = value;
    while (node > 1) {
        node /= 2;
        const std::int64_t smaller = std::min(tree_[2 * node], tree_[2 * node + 1]);
        if (tree_[node] == smaller) {
            return;
        }
        tree_[node] = smaller;
    }
}

void FrameTime::start(std::int64_t cycle) {
    anchors_.assign(1, Anchor{0, cycle});
    last_known_step_ = kNoStep;
}

std::int64_t FrameTime::extrapolated_cycle(std::int64_t step) const {
    const Anchor* anchor = &anchors_.back();
    if (step < anchor->step) {
        const auto behind = std::upper_bound(anchors_.begin(), anchors_.end(), step,
                                             [](std::int64_t s, const Anchor& a) { return s < a.step; });
        anchor = &*std::prev(behind);
    }
    return anchor->cycle + (step - anchor->step);
}

std::int64_t FrameTime::step_at(std::int64_t cycle) const {
    if (!started() || cycle < anchors_.front().cycle) {
        return -1;
    }
    const Anchor& newest = anchors_.back();
    if (cycle >= newest.cycle) {
        return std::min(newest.step + (cycle - newest.cycle), last_known_step_);
    }
    const auto behind = std::upper_bound(anchors_.begin(), anchors_.end(), cycle,
                                         [](std::int64_t c, const Anchor& a) { return c < a.cycle; });
    const Anchor& anchor = *std::prev(behind);
    return std::min({anchor.step + (cycle - anchor.cycle), behind->step - 1, last_known_step_});
}

std::int64_t FrameTime::delay_step(std::int64_t step, std::int64_t cycle) {
    const std::int64_t before = extrapolated_cycle(step);
    if (cycle <= before) {
        return 0;
    }
    if (anchors_.back().step == step) {
        anchors_.back().cycle = cycle;
    } else {
        anchors_.push_back({step, cycle});
    }
    return cycle - before;
}

ColumnTime::ColumnTime(int renderers, std::int64_t raster_pixels, bool may_stall)
    : renderers_(renderers),
      raster_pixels_(raster_pixels),
      may_stall_(may_stall),
      needed_steps_(static_cast<std::size_t>(may_stall ? renderers : 1)),
      stalled_cycles_(static_cast<std::size_t>(renderers) + 1),
      first_stall_cycles_(static_cast<std::size_t>(renderers), kUnknownCycle) {}

void ColumnTime::start(int frame, std::int64_t cycle) {
    newest_frame_ = frame;
    start_cycles_.push_back(cycle);
    current().start(cycle);
    if (may_stall_) {
        // Step 0 is known; later steps wait until the composers report what they need.
        current().set_last_known_step(0);
        for (int r = 0; r < renderers_; ++r) {
            needed_steps_.set(static_cast<std::size_t>(r), 0);
        }
    }
}

void ColumnTime::add_arrival(int renderer, std::int64_t step, std::int64_t arrival) {
    arrivals_.push({step, arrival, renderer});
}

void ColumnTime::advance(std::int64_t now) {
    FrameTime& time = current();
    forget_stalls(now);
    const std::int64_t blocked = needed_steps_.minimum();
    while (!arrivals_.empty() && arrivals_.top().step <= blocked) {
        const Arrival arrival = arrivals_.top();
        arrivals_.pop();
        const std::int64_t step_cycle = time.extrapolated_cycle(arrival.step);
        if (arrival.cycle > step_cycle) {
            count_stall(arrival.renderer, {step_cycle + 1, arrival.cycle});
            std::int64_t& first = first_stall_cycles_[static_cast<std::size_t>(arrival.renderer)];
            first = std::min(first, step_cycle);
        }
        const std::int64_t next_cycle = time.extrapolated_cycle(arrival.step + 1);
        if (time.delay_step(arrival.step + 1, arrival.cycle + 1) > 0) {
            const CycleSpan stall{next_cycle, arrival.cycle};
            count_stall(kColumn, stall);
            if (on_stall_) on_stall_(newest_frame_, stall);
        }
    }
    time.set_last_known_step(blocked);
}

void ColumnTime::count_stall(int renderer, CycleSpan cycles) {
    stalled_cycles_[stall_index(renderer)] += cycles.cycles();
    newest_stalls_.push_back({renderer, cycles});
}

/// Only a stall that ends in the future can be cut short by the end of the run.
void ColumnTime::forget_stalls(std::int64_t now) {
    constexpr std::size_t kMany = 1024;
    if (newest_stalls_.size() >= forget_at_) {
        newest_stalls_.erase(std::remove_if(newest_stalls_.begin(), newest_stalls_.end(),
                                            [now](const Stall& stall) { return stall.cycles.last <= now; }),
                             newest_stalls_.end());
        // If most of them are still to come, checking all of them each time would take too long.
        forget_at_ = std::max(kMany, 2 * newest_stalls_.size());
    }
}

void ColumnTime::when_known(int frame, std::int64_t step, std::function<void()> callback) {
    waiters_.push_back({frame, step, std::move(callback)});
    std::push_heap(waiters_.begin(), waiters_.end(), std::greater<>());
}

void ColumnTime::call_waiters() {
    while (!waiters_.empty()) {
        const Waiter& first = waiters_.front();
        if (cycle_of(first.frame, first.step) == kUnknownCycle) return;
        std::pop_heap(waiters_.begin(), waiters_.end(), std::greater<>());
        const std::function<void()> callback = std::move(waiters_.back().callback);
        waiters_.pop_back();
        callback();
    }
}

void ColumnTime::note_composited() {
    // The bottom composer is a step ahead of the output framebuffer.
    compositions_.push_back({current().cycle_of(1), current().cycle_of(last_step() - 1)});
}

std::int64_t ColumnTime::first_stall_cycle(int renderer) const {
    const auto r = static_cast<std::size_t>(renderer);
    const std::int64_t counted = first_stall_cycles_[r];
    const std::int64_t needed = needed_steps_.minimum();
    if (needed == kNoStep || needed_steps_.value(r) != needed) return counted;
    // The pixel may never come.
    return std::min(counted, frame(newest_frame_).extrapolated_cycle(needed));
}

std::int64_t ColumnTime::stalled_cycles_for(int renderer, std::int64_t through_cycle) const {
    std::int64_t count = stalled_cycles_[stall_index(renderer)];
    for (const Stall& stall : newest_stalls_) {
        if (stall.renderer == renderer && stall.cycles.last > through_cycle) {
            count -= stall.cycles.last - std::max(stall.cycles.first - 1, through_cycle);
        }
    }
    // Who waits for a pixel whose arrival is not known has waited until now.
    const std::int64_t blocked = needed_steps_.minimum();
    const bool is_column = renderer == kColumn;
    if (blocked < kNoStep &&
        (is_column || needed_steps_.value(static_cast<std::size_t>(renderer)) == blocked)) {
        const FrameTime& time = frame(newest_frame_);
        const std::int64_t before =
            is_column ? time.extrapolated_cycle(blocked + 1) - 1 : time.extrapolated_cycle(blocked);
        count += std::max<std::int64_t>(0, through_cycle - before);
    }
    return count;
}

}  // namespace metabuffer::tlm
