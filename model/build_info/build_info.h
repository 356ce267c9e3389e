#pragma once

#include <string>

/// Which build this is. The version is in CMakeLists.txt, the commit comes from git when the program is built.
namespace metabuffer {

/// "0.1.0 (6c1f4b0a9d2e)"; "-changed-" and a digest of the sources follow the commit if files differ from it. If git does
/// not report the commit: "0.1.0 (unknown commit, sources 3f9a12ab45cd)". All results of one build have the same.
std::string build_version();

/// What `metabuffer --version` prints: the build's version and those of SystemC and OpenImageIO.
std::string build_description();

}  // namespace metabuffer
