#pragma once

#include <string>

/// Which build this is. The version is in CMakeLists.txt, the commit comes from git when the program is built.
namespace metabuffer {

/// "0.1.0 (6c1f4b0a9d2e)"; "-changed" follows the commit if files differ from it. Without git only the version. Results
/// of one build have it in common.
std::string build_version();

/// What `metabuffer --version` prints: the build's version and those of SystemC and OpenImageIO.
std::string build_description();

}  // namespace metabuffer
