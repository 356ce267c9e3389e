#include "host/text_file.h"

#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer::input {

std::string text_of_file(const std::filesystem::path& file) {
    const auto fail = [&file](int error) {
        throw InputError(
            text::one_line(file.string() + ": cannot be read: " + std::generic_category().message(error)));
    };
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) fail(EISDIR);
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    if (!stream) fail(errno == 0 ? EIO : errno);
    std::string content{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    if (stream.bad()) fail(errno == 0 ? EIO : errno);
    return content;
}

}  // namespace metabuffer::input
