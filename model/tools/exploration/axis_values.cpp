#include "tools/exploration/axis_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include "host/text.h"
#include "tools/exploration/sweep_plan.h"
#include "tools/exploration/value.h"

namespace metabuffer::exploration {
namespace {

constexpr double kLargestNumber = 1e15;

/// Rounds decimals to what was meant: 0.1 and 0.2 make 0.3, not 0.30000000000000004.
double without_noise(double value) { return std::strtod(fmt::format("{:.12g}", value).c_str(), nullptr); }

std::string number_text(double value, bool whole) {
    // Whole numbers get no exponent: keys that take only these do not know 1e+05.
    const bool is_whole = whole || (value == std::floor(value) && std::abs(value) < kLargestNumber);
    return is_whole ? std::to_string(std::llround(value)) : text::number(without_noise(value));
}

std::string axis_text(const AxisNumber& number) { return number_text(number.value, number.is_whole); }

std::optional<std::string> problem_of_ends(const AxisNumber& from, const AxisNumber& to) {
    if (from.value <= to.value) return std::nullopt;
    return "from " + axis_text(from) + " is above to " + axis_text(to) + "; use from at most to";
}

/// The end of the range. It is a little more than `to` if rounding could make the last value miss that.
double last_of(const AxisRange& range) {
    constexpr double kRounding = 1e-9;
    const double step = range.step ? range.step->value : range.factor ? 0.0 : 1.0;
    const bool exact = range.from.is_whole && range.to.is_whole && step == std::floor(step) && !range.factor;
    const double slack = kRounding * (range.factor ? range.to.value : step);
    return exact ? range.to.value : range.to.value + slack;
}

/// How many numbers a range has. A double, since there may be a great many.
double count_of(const AxisRange& range) {
    const double last = last_of(range);
    if (range.factor)
        return std::floor(std::log(last / range.from.value) / std::log(range.factor->value)) + 1.0;
    return std::floor((last - range.from.value) / (range.step ? range.step->value : 1.0)) + 1.0;
}

std::string too_many(double count) {
    return "makes " + text::number(count) + " values; use at most " + std::to_string(kMostPoints);
}

/// Random numbers, the same on every computer. The standard defines the numbers of std::mt19937_64, but not those of
/// std::uniform_int_distribution.
class RandomNumbers {
  public:
    explicit RandomNumbers(std::uint64_t seed) : engine_(seed) {}

    /// 0 to count - 1, all equally likely.
    std::uint64_t below(std::uint64_t count) {
        // Numbers above the last full set of `count` are not used: they would favour the lowest results.
        const std::uint64_t left_over = (std::numeric_limits<std::uint64_t>::max() % count + 1) % count;
        const std::uint64_t most = std::numeric_limits<std::uint64_t>::max() - left_over;
        std::uint64_t drawn = engine_();
        while (drawn > most) drawn = engine_();
        return drawn % count;
    }
    /// 0 <= x < 1 in steps of 2^-53.
    double fraction() { return std::ldexp(static_cast<double>(engine_() >> 11U), -53); }

  private:
    std::mt19937_64 engine_;
};

bool is_whole(const RandomAxis& random) { return random.from.is_whole && random.to.is_whole; }

double choices_of(const RandomAxis& random) { return random.to.value - random.from.value + 1.0; }

std::string drawn(const RandomAxis& random, RandomNumbers& numbers) {
    if (is_whole(random)) {
        const std::uint64_t above = numbers.below(static_cast<std::uint64_t>(choices_of(random)));
        return std::to_string(std::llround(random.from.value) + static_cast<std::int64_t>(above));
    }
    const double width = random.to.value - random.from.value;
    return number_text(random.from.value + width * numbers.fraction(), false);
}

/// Different whole numbers, if many of the range are wanted: to draw again until one is new would take long.
std::vector<std::string> shuffled(const RandomAxis& random, RandomNumbers& numbers) {
    std::vector<std::int64_t> all(static_cast<std::size_t>(choices_of(random)));
    std::iota(all.begin(), all.end(), std::llround(random.from.value));
    std::vector<std::string> values;
    for (std::size_t i = 0; i < static_cast<std::size_t>(random.count); ++i) {
        std::swap(all[i], all[i + static_cast<std::size_t>(numbers.below(all.size() - i))]);
        values.push_back(std::to_string(all[i]));
    }
    return values;
}

}  // namespace

std::optional<AxisNumber> axis_number(const std::string& text) {
    const Value value = value_of(text);
    AxisNumber number;
    if (const auto* whole = std::get_if<std::int64_t>(&value)) {
        number = {static_cast<double>(*whole), true};
    } else if (const auto* decimal = std::get_if<double>(&value)) {
        number = {*decimal, false};
    } else {
        return std::nullopt;
    }
    if (std::abs(number.value) > kLargestNumber) return std::nullopt;
    return number;
}

std::optional<std::string> problem_of(const AxisRange& range) {
    if (auto problem = problem_of_ends(range.from, range.to)) return problem;
    if (range.step && range.factor) return "has a step and a factor; use one of the two";
    if (range.step && range.step->value <= 0.0) {
        return "step " + axis_text(*range.step) + " goes nowhere; use a step above 0";
    }
    if (range.factor && range.factor->value <= 1.0) {
        return "factor " + axis_text(*range.factor) + " goes nowhere; use a factor above 1";
    }
    if (range.factor && range.from.value <= 0.0) {
        return "from " + axis_text(range.from) + " does not go with a factor; use from above 0, or a step";
    }
    if (const double count = count_of(range); count > static_cast<double>(kMostPoints))
        return too_many(count);
    return std::nullopt;
}

std::vector<std::string> values_of(const AxisRange& range) {
    const bool whole_ends = range.from.is_whole && range.to.is_whole;
    const bool whole = whole_ends && (range.factor || !range.step || range.step->is_whole);
    const double last = last_of(range);
    std::vector<std::string> values;
    const auto count = static_cast<std::int64_t>(count_of(range));
    for (std::int64_t i = 0; i <= count; ++i) {
        // Computed from the start each time: the rounding errors of a sum would grow.
        const auto steps = static_cast<double>(i);
        const double value = range.factor ? range.from.value * std::pow(range.factor->value, steps)
                                          : range.from.value + steps * (range.step ? range.step->value : 1.0);
        if (value > last) break;
        std::string text = number_text(value, whole);
        if (values.empty() || values.back() != text) values.push_back(std::move(text));
    }
    return values;
}

std::optional<std::string> problem_of(const RandomAxis& random) {
    if (auto problem = problem_of_ends(random.from, random.to)) return problem;
    if (random.distinct && is_whole(random) && static_cast<double>(random.count) > choices_of(random)) {
        return "has " + text::number(choices_of(random)) + " numbers to draw " +
               std::to_string(random.count) + " different ones from; use a smaller count or a wider range";
    }
    if (random.distinct && !is_whole(random)) {
        // Decimals are rounded to twelve digits, and some are drawn repeatedly. So the range must be much wider.
        const double largest = std::max(std::abs(random.from.value), std::abs(random.to.value));
        const double choices = (random.to.value - random.from.value) / std::max(largest * 1e-9, 1e-300);
        if (random.count > 1 && static_cast<double>(random.count) > choices) {
            return "from " + axis_text(random.from) + " to " + axis_text(random.to) + " is too narrow for " +
                   std::to_string(random.count) + " different numbers; use a smaller count or a wider range";
        }
    }
    return std::nullopt;
}

std::vector<std::string> values_of(const RandomAxis& random) {
    RandomNumbers numbers(random.seed);
    if (random.distinct && is_whole(random) &&
        choices_of(random) <= 2.0 * static_cast<double>(random.count)) {
        return shuffled(random, numbers);
    }
    std::vector<std::string> values;
    std::set<std::string> known;
    while (static_cast<std::int64_t>(values.size()) < random.count) {
        std::string text = drawn(random, numbers);
        if (random.distinct && !known.insert(text).second) continue;
        values.push_back(std::move(text));
    }
    return values;
}

}  // namespace metabuffer::exploration
