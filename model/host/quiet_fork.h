#pragma once

#include <sys/types.h>

namespace metabuffer {

/// fork() for a process that may have read images. OpenImageIO's libraries start threads as they are loaded; with the
/// address sanitizer, whose allocator does not survive a fork() while one of these holds its lock, this waits until
/// they rest. The child must end by _exit().
pid_t quiet_fork();

}  // namespace metabuffer
