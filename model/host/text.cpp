#include "host/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <system_error>

namespace metabuffer::text {
namespace {

constexpr std::size_t kLongestQuote = 60;

/// Of UTF-8: whether the byte belongs to the character before it.
bool is_continuation(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

/// Where the character of a byte begins, so that a cut there leaves whole characters.
std::size_t character_begin(std::string_view text, std::size_t at) {
    constexpr std::size_t kLongestCharacter = 4;
    std::size_t begin = at;
    while (begin > 0 && at - begin < kLongestCharacter && is_continuation(text[begin])) --begin;
    return begin;
}

}  // namespace

bool is_control(char character) { return static_cast<unsigned char>(character) < 0x20U || character == 0x7F; }

bool has_control(std::string_view text) { return std::any_of(text.begin(), text.end(), is_control); }

std::string one_line(std::string_view text) {
    std::string line;
    for (const char character : text) {
        if (character != ' ' && !is_control(character)) {
            line += character;
        } else if (!line.empty() && line.back() != ' ') {
            line += ' ';
        }
    }
    if (!line.empty() && line.back() == ' ') line.pop_back();
    return line;
}

std::string message(std::string_view text) {
    std::string line = one_line(text);
    if (line.size() <= kLongestMessage) return line;
    constexpr std::string_view kCut = " ... ";
    constexpr std::size_t kEndBytes = kLongestMessage / 2;
    const std::size_t begin = character_begin(line, kLongestMessage - kEndBytes - kCut.size());
    std::size_t end = line.size() - kEndBytes;
    while (end < line.size() && is_continuation(line[end])) ++end;
    return line.substr(0, begin).append(kCut).append(line, end);
}

std::string quoted(std::string_view text) {
    const bool is_long = text.size() > kLongestQuote;
    std::string line = one_line(is_long ? text.substr(0, character_begin(text, kLongestQuote)) : text);
    if (is_long) line += "...";
    return "'" + line + "'";
}

std::string literal(std::string_view text, char quote) {
    std::string result(1, quote);
    for (const char character : text) {
        result += character;
        if (character == quote) result += quote;
    }
    return result + quote;
}

std::string located(std::string_view where, std::string_view message) {
    std::string text(where);
    if (!where.empty()) text += ": ";
    return one_line(text.append(message));
}

std::string listed(const std::vector<std::string>& items) {
    std::string list;
    for (std::size_t i = 0; i < items.size(); ++i) list += (i > 0 ? ", " : "") + items[i];
    return list;
}

std::string number_runs(const std::vector<int>& numbers) {
    std::vector<std::string> runs;
    for (std::size_t i = 0; i < numbers.size();) {
        std::size_t last = i;
        while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
        runs.push_back(std::to_string(numbers[i]));
        if (last > i) runs.back() += " to " + std::to_string(numbers[last]);
        i = last + 1;
    }
    return listed(runs);
}

std::string joined(const std::vector<std::string>& items, std::string_view conjunction) {
    std::string list;
    for (std::size_t i = 0; i < items.size(); ++i) {
        if (i > 0) list += i + 1 == items.size() ? " " + std::string(conjunction) + " " : ", ";
        list += items[i];
    }
    return list;
}

// Not by fmt, which writes 100000 where the shortest text is 1e+05: results files have the shortest.
std::string number(double value) {
    std::array<char, 32> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    return error == std::errc() ? std::string(digits.data(), end) : std::to_string(value);
}

const char* after_plus(const std::string& text) { return text.data() + (text[0] == '+' ? 1 : 0); }

std::optional<double> decimal_number(const std::string& text) {
    const bool allowed = !text.empty() && std::all_of(text.begin(), text.end(), [](char character) {
        return is_digit(character) || std::string_view("+-.eE").find(character) != std::string_view::npos;
    });
    if (!allowed) return std::nullopt;
    const char* begin = after_plus(text);
    const char* end = text.data() + text.size();
    double value = 0.0;
    const auto [stop, error] = std::from_chars(begin, end, value);
    const bool signs_twice = begin != text.data() && begin != end && *begin == '-';
    if (stop != end || signs_twice || error != std::errc()) return std::nullopt;
    return value;
}

std::string decimal(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

std::string range(const IntegerRange& range) {
    return std::to_string(range.low) + " to " + std::to_string(range.high);
}

std::string range(const NumberRange& range) { return number(range.low) + " to " + number(range.high); }

std::string out_of_range(std::int64_t value, const IntegerRange& allowed) {
    return std::to_string(value) + " is out of range; use " + range(allowed);
}

std::string out_of_range(double value, const NumberRange& allowed) {
    return number(value) + " is out of range; use " + range(allowed);
}

int edit_distance(std::string_view left, std::string_view right) {
    // Three rows of the usual table: a swap of neighbours needs the one before last.
    std::vector<int> before_last(right.size() + 1);
    std::vector<int> last(right.size() + 1);
    std::vector<int> current(right.size() + 1);
    for (std::size_t j = 0; j <= right.size(); ++j) last[j] = static_cast<int>(j);
    for (std::size_t i = 1; i <= left.size(); ++i) {
        current[0] = static_cast<int>(i);
        for (std::size_t j = 1; j <= right.size(); ++j) {
            const int replace = last[j - 1] + (left[i - 1] == right[j - 1] ? 0 : 1);
            current[j] = std::min({replace, last[j] + 1, current[j - 1] + 1});
            if (i > 1 && j > 1 && left[i - 1] == right[j - 2] && left[i - 2] == right[j - 1]) {
                current[j] = std::min(current[j], before_last[j - 2] + 1);
            }
        }
        std::swap(before_last, last);
        std::swap(last, current);
    }
    return last[right.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
    return *std::min_element(candidates.begin(), candidates.end(),
                             [word](const std::string& a, const std::string& b) {
                                 return edit_distance(word, a) < edit_distance(word, b);
                             });
}

}  // namespace metabuffer::text
