#pragma once

#include <cstddef>
#include <string>

namespace metabuffer {

/// The name of a block or wire of a renderer or display, or of both. Indices count from 0, names from 1 as in the
/// paper.
inline std::string numbered(const std::string& stem, std::size_t index) {
    return stem + "_" + std::to_string(index + 1);
}
inline std::string numbered(const std::string& stem, std::size_t renderer, std::size_t display) {
    return numbered(numbered(stem, renderer), display);
}

}  // namespace metabuffer
