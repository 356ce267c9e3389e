#pragma once

#include <filesystem>
#include <string>

namespace metabuffer::input {

/// A file's bytes. Throws InputError.
std::string text_of_file(const std::filesystem::path& file);

}  // namespace metabuffer::input
