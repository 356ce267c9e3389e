#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/exploration/value.h"

namespace metabuffer::exploration {

/// A value as either of the library's kinds of JSON: numbers are numbers, nothing is null.
template <typename Json>
Json json_of(const Value& value) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return *whole;
    if (const auto* number = std::get_if<double>(&value)) return *number;
    if (const auto* words = std::get_if<std::string>(&value)) return *words;
    return nullptr;
}

}  // namespace metabuffer::exploration
