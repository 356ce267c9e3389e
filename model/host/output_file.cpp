#include "host/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
    throw OutputError(text::one_line("cannot write '" + file.string() +
                                     "': " + std::generic_category().message(error == 0 ? EIO : error)));
}

/// A file beside the target that is removed again unless it has been moved to its place.
class TemporaryFile {
  public:
    explicit TemporaryFile(const std::filesystem::path& target) : target_(target) {
        constexpr int kTries = 100;
        for (int n = 0; n < kTries && descriptor_ < 0; ++n) {
            // Short, however long the target's name is.
            path_ = target;
            path_.replace_filename(".metabuffer-" + std::to_string(getpid()) + "-" + std::to_string(n) +
                                   ".part");
            // Never through a link, and never into a file that somebody else has.
            descriptor_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
            if (descriptor_ < 0 && errno != EEXIST) fail(target_, errno);
        }
        if (descriptor_ < 0) fail(target_, EEXIST);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile() {
        if (descriptor_ >= 0) close(descriptor_);
        if (!is_moved_) unlink(path_.c_str());
    }

    void write(std::string_view bytes) {
        while (!bytes.empty()) {
            const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
            if (count < 0 && errno != EINTR) fail(target_, errno);
            if (count > 0) bytes.remove_prefix(static_cast<std::size_t>(count));
        }
        // Some file systems report a full disk only here.
        const int descriptor = descriptor_;
        descriptor_ = -1;
        if (close(descriptor) != 0) fail(target_, errno);
    }

    void move_to_target() {
        if (rename(path_.c_str(), target_.c_str()) != 0) fail(target_, errno);
        is_moved_ = true;
    }

  private:
    std::filesystem::path target_;
    std::filesystem::path path_;
    int descriptor_ = -1;
    bool is_moved_ = false;
};

}  // namespace

void write_output_file(const std::filesystem::path& file, std::string_view bytes) {
    TemporaryFile temporary(file);
    temporary.write(bytes);
    temporary.move_to_target();
}

}  // namespace metabuffer
