#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace metabuffer::monitors {

/// Registers in a row: each value comes out `clocks` clocks after it went in; with 0, at once.
template <typename Value>
class DelayLine {
  public:
    explicit DelayLine(std::int64_t clocks, const Value& rest = Value{})
        : values_(static_cast<std::size_t>(clocks), rest) {}
    /// A clock edge. Returns what is read at the end of the line.
    Value pass(const Value& value) {
        values_.push_back(value);
        const Value out = values_.front();
        values_.pop_front();
        return out;
    }
    void fill(const Value& value) { std::fill(values_.begin(), values_.end(), value); }
    bool settled(const Value& value) const {
        return std::all_of(values_.begin(), values_.end(),
                           [&value](const Value& each) { return each == value; });
    }

  private:
    std::deque<Value> values_;
};

}  // namespace metabuffer::monitors
