#include "host/writer_lock.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer {
namespace {

bool says_no_locks(int error) { return error == ENOLCK || error == ENOSYS || error == EOPNOTSUPP; }

}  // namespace

bool lacks_locks(const std::filesystem::path& file) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return false;
    struct flock request {};
    request.l_type = F_RDLCK;
    request.l_whence = SEEK_SET;
    const bool lacks = fcntl(descriptor, F_GETLK, &request) != 0 && says_no_locks(errno);
    close(descriptor);
    return lacks;
}

WriterLock::WriterLock(const std::filesystem::path& lock_file, std::string what, const std::string& instead)
    : lock_file_(lock_file), what_(std::move(what)) {
    do {
        take(instead);
    } while (!is_in_place());
}

WriterLock::~WriterLock() {
    unlink(lock_file_.c_str());
    close(descriptor_);
}

void WriterLock::fail(int error) const {
    throw InputError(text::one_line(what_ + " cannot be written to: '" + lock_file_.string() +
                                    "': " + std::generic_category().message(error)));
}

void WriterLock::take(const std::string& instead) {
    descriptor_ = open(lock_file_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail(errno);
    struct flock request {};
    request.l_type = F_WRLCK;
    request.l_whence = SEEK_SET;
    // Not flock(): a forked child, which may outlive this process by a moment, would hold that lock as well.
    is_held_ = fcntl(descriptor_, F_SETLK, &request) == 0;
    const int error = errno;
    if (is_held_ || says_no_locks(error)) return;
    const bool another_holds = error == EAGAIN || error == EACCES;
    const bool is_told =
        another_holds && fcntl(descriptor_, F_GETLK, &request) == 0 && request.l_type != F_UNLCK;
    close(descriptor_);
    if (!another_holds) fail(error);
    throw InputError(what_ + " is being written by another process" +
                     (is_told ? " (" + std::to_string(request.l_pid) + ")" : "") + "; " + instead);
}

/// Whether the locked file is the one of that name: the last holder may have removed it in between.
bool WriterLock::is_in_place() {
    struct stat locked {};
    struct stat named {};
    if (fstat(descriptor_, &locked) == 0 && lstat(lock_file_.c_str(), &named) == 0 &&
        locked.st_dev == named.st_dev && locked.st_ino == named.st_ino) {
        return true;
    }
    close(descriptor_);
    return false;
}

}  // namespace metabuffer
