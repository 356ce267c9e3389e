#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace metabuffer::input {

/// The most bytes of a text file, far beyond those of any that people or programs write.
constexpr std::uintmax_t kLongestTextBytes = std::uintmax_t{256} << 20U;

/// Whether something is there that is no regular file: a folder, or a pipe or device.
bool is_no_regular_file(const std::filesystem::path& file);

/// Throws InputError for what is there and is no regular file: a folder, or a pipe or device, whose end may never come.
void check_is_regular_file(const std::filesystem::path& file);

/// A file's bytes. Throws InputError if it cannot be read, is no regular file or longer than kLongestTextBytes.
std::string text_of_file(const std::filesystem::path& file);

}  // namespace metabuffer::input
