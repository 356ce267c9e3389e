#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tools/exploration/value_json.h"

namespace metabuffer::charts {

using Json = nlohmann::ordered_json;

inline Json json_of(const exploration::Value& value) { return exploration::json_of<Json>(value); }

/// JSON for use inside a script, of a page or of node. Nothing in it can end the script; invalid UTF-8 is replaced.
inline std::string script_text(const Json& json) {
    const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    std::string result;
    result.reserve(text.size());
    for (const char character : text) {
        // "<" begins "</script>" and "<!--". In JSON it occurs only in strings.
        if (character == '<') {
            result += "\\u003c";
        } else {
            result += character;
        }
    }
    return result;
}

}  // namespace metabuffer::charts
