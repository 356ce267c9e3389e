#pragma once

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/types.h>

#include <cstdarg>

// For libraries that are preloaded: the functions that theirs replace.
namespace {

/// The function of that name that the program would have called.
template <typename Function>
Function* next(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// open()'s third argument, which is there if the flags ask for it.
[[maybe_unused]] mode_t mode_of(int flags, va_list& arguments) {
    constexpr int kUnnamedFile = O_TMPFILE & ~O_DIRECTORY;
    return (flags & (O_CREAT | kUnnamedFile)) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

}  // namespace

/// Defines open() and open64(): opened(name, path, flags, mode) does their work.
#define METABUFFER_DEFINE_OPEN(name)                   \
    int name(const char* path, int flags, ...) {       \
        va_list arguments;                             \
        va_start(arguments, flags);                    \
        const mode_t mode = mode_of(flags, arguments); \
        va_end(arguments);                             \
        return opened(#name, path, flags, mode);       \
    }
