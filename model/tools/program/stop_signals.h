#pragma once

#include <csignal>

namespace metabuffer {

/// While this object lives, Ctrl-C and SIGTERM do not end the process but can be polled for, so that work can be ended
/// in good order. Processes that are started meanwhile do not see these signals.
class StopSignals {
  public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    /// Readable once a signal has come; -1 if this computer does not offer it.
    int descriptor() const { return descriptor_; }

  private:
    sigset_t former_{};
    int descriptor_ = -1;
};

}  // namespace metabuffer
