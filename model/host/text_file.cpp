#include "host/text_file.h"

#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer::input {

namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& why) {
    throw InputError(text::one_line(file.string() + ": cannot be read: " + why));
}

[[noreturn]] void fail_to_read(const std::filesystem::path& file, int error) {
    fail(file, std::generic_category().message(error == 0 ? EIO : error));
}

/// A limit in whole MiB or KiB.
std::string size_text(std::uintmax_t bytes) {
    const bool is_in_mib = bytes >> 20U > 0;
    return std::to_string(bytes >> (is_in_mib ? 20U : 10U)) + (is_in_mib ? " MiB" : " KiB");
}

}  // namespace

bool is_no_regular_file(const std::filesystem::path& file) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

void check_is_regular_file(const std::filesystem::path& file) {
    if (!is_no_regular_file(file)) return;
    std::error_code error;
    fail(file, std::filesystem::is_directory(file, error) ? std::generic_category().message(EISDIR)
                                                          : "it is no regular file");
}

std::string text_of_file(const std::filesystem::path& file, std::uintmax_t most_bytes) {
    check_is_regular_file(file);
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    if (!stream) fail_to_read(file, errno);
    std::error_code error;
    if (std::filesystem::file_size(file, error) > most_bytes && !error) {
        fail(file, "it is longer than " + size_text(most_bytes));
    }
    std::string content{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    if (stream.bad()) fail_to_read(file, errno);
    return content;
}

}  // namespace metabuffer::input
