#pragma once

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

/// Fails the fuzz test unless the condition holds, in every build type.
#define EXPECT(condition)                                                                   \
    do {                                                                                    \
        if (!(condition)) {                                                                 \
            metabuffer::fuzz::fail(std::string(__FILE__) + ":" + std::to_string(__LINE__) + \
                                   ": not so: " #condition);                                \
        }                                                                                   \
    } while (false)

namespace metabuffer::fuzz {

/// Where fail() writes, for a test that has another use for the standard error.
inline std::FILE*& complaints() {
    static std::FILE* stream = stderr;
    return stream;
}

/// Ends the process, which is how a fuzz test fails.
[[noreturn]] inline void fail(const std::string& what) {
    std::fprintf(complaints(), "%s\n", what.c_str());
    std::fflush(complaints());
    std::abort();
}

/// A complaint to the user is one line that is not empty.
inline void expect_one_clear_line(const std::exception& error) {
    const std::string message = error.what();
    if (message.empty() || message.find_first_of("\n\r") != std::string::npos)
        fail("not one line: '" + message + "'");
}

}  // namespace metabuffer::fuzz
