#pragma once

#include <cstddef>
#include <string>

namespace metabuffer {

/// The name of a block or wire of a renderer or display, and of one of each (indices, from 0): the paper counts from 1.
inline std::string numbered(const std::string& stem, std::size_t index) {
    return stem + "_" + std::to_string(index + 1);
}
inline std::string numbered(const std::string& stem, std::size_t renderer, std::size_t display) {
    return numbered(numbered(stem, renderer), display);
}

}  // namespace metabuffer
