// To be preloaded into the program: the n-th call of one function of the system, counted over all processes of a run,
// fails as the system would make it fail. failing_calls_test.py runs the program with it for one n after another.
//
// FAILING_CALL: the function. FAILING_AT: n, from 1; 0 only counts. FAILING_COUNT: a file of 8 bytes for the count.

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "next_function.h"

namespace {

/// The count of all processes, in memory that they share.
std::atomic<std::int64_t>* shared_count() {
    static std::atomic<std::int64_t>* const count = []() -> std::atomic<std::int64_t>* {
        const char* file = std::getenv("FAILING_COUNT");
        if (file == nullptr) return nullptr;
        const int descriptor = next<int(const char*, int, ...)>("open")(file, O_RDWR | O_CLOEXEC);
        if (descriptor < 0) return nullptr;
        void* memory = next<void*(void*, std::size_t, int, int, int, off_t)>("mmap")(
            nullptr, sizeof(std::int64_t), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
        next<int(int)>("close")(descriptor);
        return memory == MAP_FAILED ? nullptr : static_cast<std::atomic<std::int64_t>*>(memory);
    }();
    return count;
}

/// Counts a call; returns whether it is the one to fail.
bool fails(const char* function) {
    static const char* const chosen = std::getenv("FAILING_CALL");
    static const char* const at = std::getenv("FAILING_AT");
    if (chosen == nullptr || at == nullptr || std::strcmp(chosen, function) != 0) return false;
    std::atomic<std::int64_t>* count = shared_count();
    return count != nullptr && count->fetch_add(1) + 1 == std::atoll(at);
}

int fail_with(int error) {
    errno = error;
    return -1;
}

/// Pipes and terminals do not fail when a disk is full, and are not tested here.
bool is_file(int descriptor) {
    const int before = errno;
    struct stat status {};
    const bool result = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    errno = before;
    return result;
}

/// The files that the system itself provides always exist. A library that needs one has no other way than to end the
/// process.
bool is_of_system(const char* path) {
    return std::strncmp(path, "/proc/", 6) == 0 || std::strncmp(path, "/sys/", 5) == 0;
}

int opened(const char* name, const char* path, int flags, mode_t mode) {
    if (!is_of_system(path) && fails("open")) return fail_with((flags & O_CREAT) != 0 ? ENOSPC : EMFILE);
    return next<int(const char*, int, ...)>(name)(path, flags, mode);
}

FILE* opened_stream(const char* name, const char* path, const char* mode) {
    if (!is_of_system(path) && fails("open")) {
        errno = EMFILE;
        return nullptr;
    }
    return next<FILE*(const char*, const char*)>(name)(path, mode);
}

void* mapped(const char* name, void* address, std::size_t length, int protection, int flags, int descriptor,
             off_t offset) {
    if (fails("mmap")) {
        errno = ENOMEM;
        return MAP_FAILED;
    }
    return next<void*(void*, std::size_t, int, int, int, off_t)>(name)(address, length, protection, flags,
                                                                       descriptor, offset);
}

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* bytes, std::size_t count) {
    if (is_file(descriptor) && fails("write")) return fail_with(ENOSPC);
    return next<ssize_t(int, const void*, std::size_t)>("write")(descriptor, bytes, count);
}
ssize_t pwrite(int descriptor, const void* bytes, std::size_t count, off_t offset) {
    if (fails("write")) return fail_with(ENOSPC);
    return next<ssize_t(int, const void*, std::size_t, off_t)>("pwrite")(descriptor, bytes, count, offset);
}
ssize_t pwrite64(int descriptor, const void* bytes, std::size_t count, off64_t offset) {
    if (fails("write")) return fail_with(ENOSPC);
    return next<ssize_t(int, const void*, std::size_t, off64_t)>("pwrite64")(descriptor, bytes, count,
                                                                             offset);
}
METABUFFER_DEFINE_OPEN(open)
METABUFFER_DEFINE_OPEN(open64)
FILE* fopen(const char* path, const char* mode) { return opened_stream("fopen", path, mode); }
FILE* fopen64(const char* path, const char* mode) { return opened_stream("fopen64", path, mode); }
int close(int descriptor) {
    // The descriptor is closed even if the call fails, as the system does it.
    const bool is_chosen = fails("close");
    const int result = next<int(int)>("close")(descriptor);
    return is_chosen ? fail_with(EIO) : result;
}
int rename(const char* from, const char* to) {
    return fails("rename") ? fail_with(ENOSPC) : next<int(const char*, const char*)>("rename")(from, to);
}
int mkdir(const char* path, mode_t mode) {
    return fails("mkdir") ? fail_with(ENOSPC) : next<int(const char*, mode_t)>("mkdir")(path, mode);
}
int unlink(const char* path) {
    return fails("unlink") ? fail_with(EIO) : next<int(const char*)>("unlink")(path);
}
int fsync(int descriptor) { return fails("fsync") ? fail_with(EIO) : next<int(int)>("fsync")(descriptor); }
int fdatasync(int descriptor) {
    return fails("fsync") ? fail_with(EIO) : next<int(int)>("fdatasync")(descriptor);
}
pid_t fork() { return fails("fork") ? fail_with(EAGAIN) : next<pid_t()>("fork")(); }
int pipe2(int ends[2], int flags) {
    return fails("pipe2") ? fail_with(EMFILE) : next<int(int*, int)>("pipe2")(ends, flags);
}
int socketpair(int domain, int type, int protocol, int ends[2]) {
    return fails("socketpair") ? fail_with(EMFILE)
                               : next<int(int, int, int, int*)>("socketpair")(domain, type, protocol, ends);
}
ssize_t sendmsg(int descriptor, const msghdr* message, int flags) {
    return fails("sendmsg") ? fail_with(ENOBUFS)
                            : next<ssize_t(int, const msghdr*, int)>("sendmsg")(descriptor, message, flags);
}
void* mmap(void* address, std::size_t length, int protection, int flags, int descriptor, off_t offset) {
    return mapped("mmap", address, length, protection, flags, descriptor, offset);
}
void* mmap64(void* address, std::size_t length, int protection, int flags, int descriptor, off64_t offset) {
    return mapped("mmap64", address, length, protection, flags, descriptor, offset);
}
ssize_t read(int descriptor, void* bytes, std::size_t count) {
    if (is_file(descriptor) && fails("read")) return fail_with(EIO);
    return next<ssize_t(int, void*, std::size_t)>("read")(descriptor, bytes, count);
}

}  // extern "C"
