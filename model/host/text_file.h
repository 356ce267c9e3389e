#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace metabuffer::input {

/// The most bytes of a text file, far more than people or programs write.
constexpr std::uintmax_t kLongestTextBytes = std::uintmax_t{256} << 20U;

/// Whether something is there that is not a regular file: a folder, or a pipe or device.
bool is_no_regular_file(const std::filesystem::path& file);

/// Throws InputError if something is there that is not a regular file: a folder, or a pipe or device, whose end may
/// never come.
void check_is_regular_file(const std::filesystem::path& file);

/// A file's bytes. Throws InputError if it cannot be read, is not a regular file or is longer than `most_bytes`.
std::string text_of_file(const std::filesystem::path& file, std::uintmax_t most_bytes = kLongestTextBytes);

}  // namespace metabuffer::input
