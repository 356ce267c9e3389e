#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

namespace metabuffer::exploration {

/// One setting of a point: a scenario key's path as --set takes it, or kScenarioAxis, and a YAML value in flow style.
struct Setting {
    std::string key;
    std::string value;
    friend bool operator==(const Setting& a, const Setting& b) {
        return a.key == b.key && a.value == b.value;
    }
};

/// Keys that change together: a point has entry n of each.
struct Axis {
    std::vector<std::string> keys;
    std::vector<std::vector<std::string>> values;  ///< by key; all of the same length, no entry twice
    /// By key: begins the message if something is wrong with it ("sweep.yaml:7: axes[0].key"). May be left empty.
    std::vector<std::string> where;
};

/// One machine to run, or to search with.
struct Point {
    std::vector<Setting> settings;  ///< of the axes, in their order
};

/// One of `count` parts of a sweep. A row is `count` combinations that follow each other; each shard has one of them.
/// Which one changes from row to row as if by chance, so that shards are not in step with an axis.
struct Shard {
    std::int64_t index = 0;  ///< 0 to count - 1
    std::int64_t count = 1;  ///< 1 or more

    /// The number of the shard's combination in that row, which begins with number row * count.
    std::int64_t number_in(std::int64_t row) const;
    friend bool operator==(const Shard& a, const Shard& b) {
        return a.index == b.index && a.count == b.count;
    }
};

/// The points of a sweep, or of one shard of it: all combinations of the axes' entries, the last axis changing fastest,
/// without those that a filter has left out. It holds the axes and a bit for each combination of the shard, and makes a
/// point when it is asked for.
class PointSequence {
  public:
    using Filter = std::function<bool(const std::vector<Setting>&)>;

    PointSequence() = default;
    /// Every axis must have values. filter: whether a point is kept; empty: all are.
    PointSequence(std::vector<Axis> axes, Shard shard, const Filter& filter);

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    /// Combinations of the shard that the filter left out.
    std::size_t filtered() const { return filtered_; }

    class Iterator {
      public:
        using iterator_category = std::input_iterator_tag;
        using value_type = Point;
        using difference_type = std::ptrdiff_t;
        using pointer = const Point*;
        using reference = Point;

        Iterator(const PointSequence& points, std::int64_t row) : points_(&points), row_(row) { skip(); }
        Point operator*() const { return points_->made(row_); }
        Iterator& operator++() {
            ++row_;
            skip();
            return *this;
        }
        friend bool operator==(const Iterator& a, const Iterator& b) { return a.row_ == b.row_; }
        friend bool operator!=(const Iterator& a, const Iterator& b) { return a.row_ != b.row_; }

      private:
        void skip() {
            while (row_ < points_->rows_ && !points_->has(row_)) ++row_;
        }

        const PointSequence* points_;
        std::int64_t row_;
    };
    Iterator begin() const { return {*this, 0}; }
    Iterator end() const { return {*this, rows_}; }

  private:
    Point made(std::int64_t row) const;
    bool has(std::int64_t row) const {
        return shard_.number_in(row) < combinations_ && (left_out_.empty() || !left_out_[row]);
    }

    std::shared_ptr<const std::vector<Axis>> axes_;  ///< shared by the copies
    Shard shard_;
    std::int64_t combinations_ = 0;  ///< of the axes' entries, in all shards
    std::int64_t rows_ = 0;       ///< each has one combination of the shard, but the last one may have none
    std::vector<bool> left_out_;  ///< by row; empty: none
    std::size_t size_ = 0;
    std::size_t filtered_ = 0;
};

}  // namespace metabuffer::exploration
