#pragma once

#include <string>

#include "tools/program/exit_status.h"

namespace metabuffer {

/// How a command failed: what to tell the caller and, in one line that is not too long, the user.
struct Failure {
    ExitStatus status = kExitModelError;
    std::string message;
};

/// The failure that the exception being handled stands for; call it in a catch (...) only.
Failure current_failure();

/// Makes an exception that nobody catches, thrown by a destructor, a thread or as a library is loaded, end the program
/// as it would end a command: with its line and its status.
void report_uncaught_exceptions();

}  // namespace metabuffer
