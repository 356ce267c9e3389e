#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/errors.h"

namespace metabuffer::test {

/// The message of the InputError that the call throws, on one line; empty if it throws none.
template <typename Call>
std::string input_error_of(Call call) {
    try {
        call();
    } catch (const InputError& error) {
        std::string message = error.what();
        CHECK(message.find('\n') == std::string::npos);
        return message;
    }
    return "";
}

/// Whether a text is what it should be; "..." stands for any words, such as those of a library.
inline bool is_text(const std::string& text, const std::string& wanted) {
    const std::size_t gap = wanted.find("...");
    if (gap == std::string::npos) return text == wanted;
    if (text.compare(0, gap, wanted, 0, gap) != 0) return false;
    const std::string rest = wanted.substr(gap + 3);
    for (std::size_t at = gap; at <= text.size(); ++at) {
        if (is_text(text.substr(at), rest)) return true;
    }
    return false;
}

inline void check_text(const std::string& text, const std::string& wanted) {
    INFO(text << "\nshould be\n" << wanted);
    CHECK(is_text(text, wanted));
}

/// Inputs and the line that each is refused with, an empty one if it is right.
template <typename Input>
using Refusals = std::vector<std::pair<Input, std::string>>;

/// Checks a table: `check_refusals(error_of)({{"input", "line"}, ...})`.
template <typename Input = std::string, typename ErrorOf>
auto check_refusals(ErrorOf error_of) {
    return [error_of](const Refusals<Input>& refusals) {
        for (const auto& [input, line] : refusals) {
            if constexpr (std::is_convertible_v<Input, std::string>) UNSCOPED_INFO(std::string(input));
            check_text(error_of(input), line);
        }
    };
}

}  // namespace metabuffer::test
