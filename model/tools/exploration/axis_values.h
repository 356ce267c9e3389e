#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// The values of an axis that is given as a range or as random numbers.
namespace metabuffer::exploration {

/// A number as it was written. Whole if it has neither a point nor an exponent.
struct AxisNumber {
    double value = 0.0;
    bool is_whole = false;
};

/// Nothing if the text is not a number, or if it is beyond 1e15: not all whole numbers above are exact.
std::optional<AxisNumber> axis_number(const std::string& text);

/// from, from + step, ... or from, from * factor, ... up to `to`, both ends included if they are hit. Neither step nor
/// factor: step 1. If both ends are whole, a factor's values are rounded to whole numbers, and each is used once.
struct AxisRange {
    AxisNumber from;
    AxisNumber to;
    std::optional<AxisNumber> step;
    std::optional<AxisNumber> factor;
};

/// What is wrong with it and what would be right; nothing if it is good.
std::optional<std::string> problem_of(const AxisRange& range);

/// Its values; problem_of() must find nothing.
std::vector<std::string> values_of(const AxisRange& range);

/// Random numbers of from..to, whole ones (both ends included) if both ends are whole.
struct RandomAxis {
    AxisNumber from;
    AxisNumber to;
    std::int64_t count = 1;
    std::uint64_t seed = 0;
    bool distinct = false;  ///< no number is drawn twice
};

std::optional<std::string> problem_of(const RandomAxis& random);

/// Its values, the same on every computer; problem_of() must find nothing.
std::vector<std::string> values_of(const RandomAxis& random);

}  // namespace metabuffer::exploration
