#include "tools/exploration/point_sequence.h"

#include <cstdint>
#include <utility>

namespace metabuffer::exploration {

namespace {

/// A number that looks random, the same on every computer (the finalizer of splitmix64).
std::uint64_t scattered(std::uint64_t value) {
    value += 0x9E3779B97F4A7C15U;
    value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9U;
    value = (value ^ (value >> 27U)) * 0x94D049BB133111EBU;
    return value ^ (value >> 31U);
}

}  // namespace

std::int64_t Shard::number_in(std::int64_t row) const {
    const auto shift = static_cast<std::int64_t>(scattered(static_cast<std::uint64_t>(row)) %
                                                 static_cast<std::uint64_t>(count));
    return row * count + (index + shift) % count;
}

PointSequence::PointSequence(std::vector<Axis> axes, Shard shard, const Filter& filter) : shard_(shard) {
    combinations_ = 1;
    for (const Axis& axis : axes) combinations_ *= static_cast<std::int64_t>(axis.values.front().size());
    axes_ = std::make_shared<const std::vector<Axis>>(std::move(axes));
    rows_ = (combinations_ + shard_.count - 1) / shard_.count;
    for (std::int64_t row = 0; row < rows_; ++row) {
        if (!has(row)) continue;
        if (!filter || filter(made(row).settings)) {
            ++size_;
            continue;
        }
        ++filtered_;
        if (left_out_.empty()) left_out_.resize(rows_);
        left_out_[row] = true;
    }
}

Point PointSequence::made(std::int64_t row) const {
    std::int64_t rest = shard_.number_in(row);
    std::vector<std::int64_t> entries(axes_->size());
    for (std::size_t axis = axes_->size(); axis-- > 0;) {
        const auto count = static_cast<std::int64_t>((*axes_)[axis].values.front().size());
        entries[axis] = rest % count;
        rest /= count;
    }
    Point point;
    for (std::size_t n = 0; n < axes_->size(); ++n) {
        const Axis& axis = (*axes_)[n];
        for (std::size_t key = 0; key < axis.keys.size(); ++key) {
            point.settings.push_back({axis.keys[key], axis.values[key][entries[n]]});
        }
    }
    return point;
}

}  // namespace metabuffer::exploration
