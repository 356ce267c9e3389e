// To be preloaded into the program: files below a folder called "unlocked" lie on a file system without locks, such as NFS
// without its lock daemon (ENOLCK) or Lustre mounted so (ENOSYS). MISSING_LOCKS: the number of the error.

#include <fcntl.h>
#include <limits.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <string>
#include <string_view>

#include "next_function.h"

namespace {

bool is_lock(int command) {
    for (const int one : {F_SETLK, F_SETLKW, F_GETLK, F_OFD_SETLK, F_OFD_SETLKW, F_OFD_GETLK}) {
        if (command == one) return true;
    }
    return false;
}

bool lies_unlocked(int descriptor) {
    std::array<char, PATH_MAX> target{};
    const ssize_t length =
        readlink(("/proc/self/fd/" + std::to_string(descriptor)).c_str(), target.data(), target.size());
    return length > 0 &&
           std::string_view(target.data(), static_cast<std::size_t>(length)).find("/unlocked/") !=
               std::string_view::npos;
}

int controlled(const char* name, int descriptor, int command, void* argument) {
    const char* const error = std::getenv("MISSING_LOCKS");
    if (error != nullptr && is_lock(command) && lies_unlocked(descriptor)) {
        errno = std::atoi(error);
        return -1;
    }
    return next<int(int, int, ...)>(name)(descriptor, command, argument);
}

}  // namespace

#define DEFINE_FCNTL(name)                                       \
    int name(int descriptor, int command, ...) {                 \
        va_list arguments;                                       \
        va_start(arguments, command);                            \
        void* const argument = va_arg(arguments, void*);         \
        va_end(arguments);                                       \
        return controlled(#name, descriptor, command, argument); \
    }

extern "C" {

DEFINE_FCNTL(fcntl)
DEFINE_FCNTL(fcntl64)

}  // extern "C"
