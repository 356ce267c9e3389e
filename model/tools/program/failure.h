#pragma once

#include <string>

#include "tools/program/exit_status.h"

namespace metabuffer {

/// How a command failed: what to tell the caller and, in one line, the user.
struct Failure {
    ExitStatus status = kExitModelError;
    std::string message;
};

/// The failure that the exception being handled stands for; call it in a catch (...) only.
Failure current_failure();

}  // namespace metabuffer
