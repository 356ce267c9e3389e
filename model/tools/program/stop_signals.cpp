#include "tools/program/stop_signals.h"

#include <sys/signalfd.h>
#include <unistd.h>

namespace metabuffer {

StopSignals::StopSignals() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    sigprocmask(SIG_BLOCK, &signals, &former_);
    descriptor_ = signalfd(-1, &signals, SFD_CLOEXEC);
    if (descriptor_ < 0) sigprocmask(SIG_SETMASK, &former_, nullptr);
}

StopSignals::~StopSignals() {
    if (descriptor_ < 0) return;
    // A signal that came has been handled, and must not end the process now.
    signalfd_siginfo answered{};
    sigset_t pending;
    if (sigpending(&pending) == 0 &&
        (sigismember(&pending, SIGINT) == 1 || sigismember(&pending, SIGTERM) == 1)) {
        static_cast<void>(!read(descriptor_, &answered, sizeof answered));
    }
    close(descriptor_);
    sigprocmask(SIG_SETMASK, &former_, nullptr);
}

}  // namespace metabuffer
