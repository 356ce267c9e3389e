#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

namespace metabuffer::exploration {

/// A setting or a figure as tables hold it: nothing, a whole number, a number or a text.
using Value = std::variant<std::monostate, std::int64_t, double, std::string>;

/// The value that a scenario's text means: a number if all of it is one, nothing if it is empty, else the text.
Value value_of(std::string_view text);

/// The value that YAML in flow style means. Quotation marks are not part of a text, and what is in them is never a
/// number. The sign before a number may be a plus. Lists and maps are texts as they are.
Value value_of_setting(const std::string& flow);

/// A number gets as few digits as read back the same; nothing becomes the empty text.
std::string text_of(const Value& value);

}  // namespace metabuffer::exploration
