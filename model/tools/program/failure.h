#pragma once

#include <string>

#include "tools/program/exit_status.h"

namespace metabuffer {

/// How a command failed: the exit status for the caller and, in one line of limited length, the message for the user.
struct Failure {
    ExitStatus status = kExitModelError;
    std::string message;
};

/// The failure for the exception that is being handled. Call it only in a catch (...).
Failure current_failure();

/// Makes an uncaught exception end the program as it would end a command: with its line and its status. A destructor, a
/// thread, or the loading of a library may throw one.
void report_uncaught_exceptions();

}  // namespace metabuffer
