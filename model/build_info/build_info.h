#pragma once

#include <string>

/// Which build this is. The version stands in CMakeLists.txt, the commit comes from git when the program is built.
namespace metabuffer {

/// "0.1.0 (6c1f4b0a9d2e)"; "-changed" behind the commit if files differ from it. Without git the version alone. What
/// results of one build have in common.
std::string build_version();

/// What `metabuffer --version` prints: the build's version and those of SystemC and OpenImageIO.
std::string build_description();

}  // namespace metabuffer
