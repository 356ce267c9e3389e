#pragma once

#include <sys/types.h>

namespace metabuffer {

/// fork() for a process that may have loaded OpenImageIO, whose libraries start threads: the image service, and tests. The
/// address sanitizer's allocator does not survive a fork() while one of these threads holds its lock; with that
/// sanitizer this waits until the threads sleep. The child must end by _exit().
pid_t quiet_fork();

}  // namespace metabuffer
