#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "host/range.h"
#include "host/text.h"

namespace metabuffer {

/// For a command's add_option(...)->check(): a number within the range. CLI11's own check accepts nan, and prints the
/// range with all its digits.
inline CLI::Validator number_within(const NumberRange& range) {
    return {[range](std::string& text) {
                double value = 0.0;
                if (!CLI::detail::lexical_cast(text, value)) {
                    return text::quoted(text) + " is no number; use " + text::range(range);
                }
                // A test for numbers outside the range would let nan pass.
                return range.contains(value)
                           ? std::string()
                           : text::quoted(text) + " is out of range; use " + text::range(range);
            },
            text::range(range)};
}

}  // namespace metabuffer
