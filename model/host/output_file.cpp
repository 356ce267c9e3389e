#include "host/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "host/errors.h"
#include "host/text.h"
#include "host/text_file.h"

namespace metabuffer {

void fail_to_write(const std::filesystem::path& file, const std::string& why) {
    throw OutputError(text::one_line("cannot write '" + file.string() + "': " + why));
}

OutputFile::OutputFile(const std::filesystem::path& target) : name_(target), target_(target) {
    follow_links();
    // Checked now, not at the end of a long run when the file is put in place.
    std::error_code error;
    if (std::filesystem::is_directory(target_, error)) fail(EISDIR);
    if (input::is_no_regular_file(target_)) {
        fail_to_write(name_, "it is no regular file; name a file in a folder");
    }
    open_aside();
}

/// A link may also lead to a file that is not there yet.
void OutputFile::follow_links() {
    constexpr int kMostLinks = 40;  // as many as Linux follows
    std::error_code error;
    for (int n = 0; std::filesystem::is_symlink(std::filesystem::symlink_status(target_, error)); ++n) {
        if (n == kMostLinks) fail(ELOOP);
        // An absolute link replaces the folder before it.
        target_ = target_.parent_path() / std::filesystem::read_symlink(target_, error);
        if (error) fail(error.value());
    }
}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0) close(descriptor_);
    if (is_aside_) unlink(aside_.c_str());
}

void OutputFile::fail(int error) const {
    fail_to_write(name_, std::generic_category().message(error == 0 ? EIO : error));
}

void OutputFile::open_aside() {
    constexpr int kTries = 1000;
    for (int n = 0; n < kTries; ++n) {
        // Short, however long the target's name is.
        aside_ = target_;
        aside_.replace_filename(".metabuffer-" + std::to_string(getpid()) + "-" + std::to_string(n) +
                                ".part");
        // Never through a link, and never into a file that another process has.
        descriptor_ = open(aside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        is_aside_ = descriptor_ >= 0;
        if (is_aside_) return;
        if (errno != EEXIST) fail(errno);
    }
    fail(EEXIST);
}

void OutputFile::write(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
        if (count < 0 && errno != EINTR) fail(errno);
        if (count > 0) bytes.remove_prefix(static_cast<std::size_t>(count));
    }
}

void OutputFile::sync() {
    if (fsync(descriptor_) != 0) fail(errno);
}

void OutputFile::put_in_place() {
    // Some file systems report a full disk only here.
    const int descriptor = descriptor_;
    descriptor_ = -1;
    if (close(descriptor) != 0) fail(errno);
    if (rename(aside_.c_str(), target_.c_str()) != 0) fail(errno);
    is_aside_ = false;
}

void write_output_file(const std::filesystem::path& file, std::string_view bytes) {
    OutputFile output(file);
    output.write(bytes);
    output.put_in_place();
}

}  // namespace metabuffer
