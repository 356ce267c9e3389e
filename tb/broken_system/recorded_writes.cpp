// To be preloaded into the program: records what is done to the files whose names begin with RECORDED_PREFIX, in order,
// in the file RECORDED_LOG. power_cut_test.py works out from it what a disk holds after its power was cut.
//
// A record is a line, OPERATION SIZE POSITION LENGTH PATH, followed by LENGTH bytes of data:
//   create PATH, write POSITION and data, truncate to SIZE, sync, unlink, rename (the data is the new path).

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>

#include "next_function.h"

namespace {

bool is_recorded(const std::string& path) {
    static const char* const prefix = std::getenv("RECORDED_PREFIX");
    const std::size_t slash = path.rfind('/');
    const std::string name = slash == std::string::npos ? path : path.substr(slash + 1);
    return prefix != nullptr && name.rfind(prefix, 0) == 0;
}

/// The recorded files that are open, by descriptor.
std::map<int, std::string>& open_files() {
    static std::map<int, std::string> files;
    return files;
}

void record(const char* operation, const std::string& path, long long size, long long position,
            const void* data, std::size_t length) {
    static const int log = next<int(const char*, int, ...)>("open")(
        std::getenv("RECORDED_LOG"), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    std::string text = std::string(operation) + " " + std::to_string(size) + " " + std::to_string(position) +
                       " " + std::to_string(length) + " " + path + "\n";
    text.append(static_cast<const char*>(data), length);
    if (next<ssize_t(int, const void*, std::size_t)>("write")(log, text.data(), text.size()) !=
        static_cast<ssize_t>(text.size())) {
        std::abort();
    }
}

const std::string* file_of(int descriptor) {
    const auto found = open_files().find(descriptor);
    return found == open_files().end() ? nullptr : &found->second;
}

int opened(const char* name, const char* path, int flags, mode_t mode) {
    const bool is_new = (flags & O_CREAT) != 0 && access(path, F_OK) != 0;
    const int descriptor = next<int(const char*, int, ...)>(name)(path, flags, mode);
    if (descriptor >= 0 && is_recorded(path)) {
        open_files()[descriptor] = path;
        if (is_new) record("create", path, 0, 0, "", 0);
    }
    return descriptor;
}

ssize_t written(const char* name, int descriptor, const void* bytes, std::size_t count, off_t position) {
    const ssize_t result =
        next<ssize_t(int, const void*, std::size_t, off_t)>(name)(descriptor, bytes, count, position);
    const std::string* file = file_of(descriptor);
    if (result > 0 && file != nullptr) {
        record("write", *file, 0, position, bytes, static_cast<std::size_t>(result));
    }
    return result;
}

int truncated(const char* name, int descriptor, off_t size) {
    const std::string* file = file_of(descriptor);
    if (file != nullptr) record("truncate", *file, size, 0, "", 0);
    return next<int(int, off_t)>(name)(descriptor, size);
}

int synced(const char* name, int descriptor) {
    const int result = next<int(int)>(name)(descriptor);
    const std::string* file = file_of(descriptor);
    if (file != nullptr) record("sync", *file, 0, 0, "", 0);
    return result;
}

}  // namespace

extern "C" {

METABUFFER_DEFINE_OPEN(open)
METABUFFER_DEFINE_OPEN(open64)
ssize_t write(int descriptor, const void* bytes, std::size_t count) {
    const std::string* file = file_of(descriptor);
    const off_t position = file == nullptr ? 0 : lseek(descriptor, 0, SEEK_CUR);
    const ssize_t result = next<ssize_t(int, const void*, std::size_t)>("write")(descriptor, bytes, count);
    if (result > 0 && file != nullptr) {
        record("write", *file, 0, position, bytes, static_cast<std::size_t>(result));
    }
    return result;
}
ssize_t pwrite(int descriptor, const void* bytes, std::size_t count, off_t position) {
    return written("pwrite", descriptor, bytes, count, position);
}
ssize_t pwrite64(int descriptor, const void* bytes, std::size_t count, off64_t position) {
    return written("pwrite64", descriptor, bytes, count, position);
}
int ftruncate(int descriptor, off_t size) { return truncated("ftruncate", descriptor, size); }
int ftruncate64(int descriptor, off64_t size) { return truncated("ftruncate64", descriptor, size); }
int fsync(int descriptor) { return synced("fsync", descriptor); }
int fdatasync(int descriptor) { return synced("fdatasync", descriptor); }
int close(int descriptor) {
    open_files().erase(descriptor);
    return next<int(int)>("close")(descriptor);
}
int unlink(const char* path) {
    if (is_recorded(path)) record("unlink", path, 0, 0, "", 0);
    return next<int(const char*)>("unlink")(path);
}
int rename(const char* from, const char* to) {
    if (is_recorded(from)) record("rename", from, 0, 0, to, std::strlen(to));
    return next<int(const char*, const char*)>("rename")(from, to);
}

}  // extern "C"
