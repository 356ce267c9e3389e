#pragma once

#include <filesystem>
#include <string_view>

namespace metabuffer {

/// Puts a file in place whole: written aside in the same folder, under a name that nobody else has, and moved there once
/// its last byte is on its way to the disk. On failure there is what was there before. A file that was a symbolic link
/// is replaced by this one; what it pointed to stays. Throws OutputError.
void write_output_file(const std::filesystem::path& file, std::string_view bytes);

}  // namespace metabuffer
