#pragma once

#include <string_view>

/// The files of this folder that are part of the program, as they are, and Vega as `vega_bundle.js`.
namespace metabuffer::charts {

/// The file of that name, which CMakeLists.txt lists. Throws std::logic_error if it does not.
std::string_view embedded_file(std::string_view name);

}  // namespace metabuffer::charts
