#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/range.h"

/// Wording that messages, reports and tables share.
namespace metabuffer::text {

/// Whether it is one of ASCII's control characters.
bool is_control(char character);
bool has_control(std::string_view text);

/// Whether it is one of 0 to 9, in any locale.
inline bool is_digit(char character) { return character >= '0' && character <= '9'; }

/// Control characters and runs of white space become one space each; none at either end.
std::string one_line(std::string_view text);

/// The most characters of a message to the user.
constexpr std::size_t kLongestMessage = 400;

/// A message for the user, whatever input it repeats: on one line, and cut in the middle if it is longer than
/// kLongestMessage. Its ends say where the error is and what would be right.
std::string message(std::string_view text);

/// The text between quotation marks, on one line, cut when it is long.
std::string quoted(std::string_view text);

/// The text between quotation marks, those in it doubled: a literal or a name of SQL, a field of CSV, a scalar of YAML.
std::string literal(std::string_view text, char quote);

/// A message on one line: "where: message", without `where` just the message.
std::string located(std::string_view where, std::string_view message);

/// "a, b, c".
std::string listed(const std::vector<std::string>& items);

/// "0 to 3, 5" of 0, 1, 2, 3 and 5, which ascend.
std::string number_runs(const std::vector<int>& numbers);

/// "a, b or c"; conjunction is "or" or "and".
std::string joined(const std::vector<std::string>& items, std::string_view conjunction);

/// The shortest text that reads back as the same number.
std::string number(double value);

/// Where the digits of a number begin that may have a plus sign, which from_chars refuses.
const char* after_plus(const std::string& text);

/// A decimal number, also `.5`, `5.` and `1e3`; not hexadecimal, not inf or nan.
std::optional<double> decimal_number(const std::string& text);

/// With `digits` digits after the point.
std::string decimal(double value, int digits);

/// "1 pair", "3 pairs".
template <typename Count>
std::string counted(Count count, const std::string& thing) {
    return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

/// "1 to 64".
std::string range(const IntegerRange& range);
std::string range(const NumberRange& range);

/// "0 is out of range; use 1 to 64".
std::string out_of_range(std::int64_t value, const IntegerRange& allowed);
std::string out_of_range(double value, const NumberRange& allowed);

/// Levenshtein distance; swapping two neighbours counts as one edit.
int edit_distance(std::string_view left, std::string_view right);

/// The candidate with the least distance, the first of several; candidates must not be empty.
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace metabuffer::text
