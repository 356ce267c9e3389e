#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <systemc>

#include "monitors/violation.h"

namespace metabuffer::monitors {

/// Reports a monitor's violations to the log: of each wire one a frame, so that one mistake does not hide the next. Further
/// ones are only counted. A wire may have several groups of rules, each reported separately.
class RuleReporter {
  public:
    static constexpr std::int64_t kNoFrame = -1;

    explicit RuleReporter(ViolationLog& log, std::string clock = "core")
        : log_(log), clock_(std::move(clock)) {}

    /// Reports the violation unless one of the same wire and group was reported for that frame. frame: kNoFrame where
    /// the wires do not show it.
    void report(const char* group, const char* rule, const std::string& signal, std::int64_t cycle,
                std::int64_t frame, const std::string& detail);
    /// Violations of that wire and group are only counted for the rest of the frame.
    void mute(const char* group, const std::string& signal, std::int64_t frame) {
        last_frame_[group + (' ' + signal)] = frame;
    }
    /// Violations that were seen and not reported.
    std::int64_t unreported() const { return unreported_; }

  private:
    ViolationLog& log_;
    std::string clock_;
    std::map<std::string, std::int64_t> last_frame_;  ///< by group and wire: the frame of the last report
    std::int64_t unreported_ = 0;
};

/// The name of the signal that a port is bound to; of the port itself if it is bound to something nameless.
std::string bound_signal(const sc_core::sc_port_base& port, const sc_core::sc_interface* bound);

/// The same for an input port, once the ports are bound.
template <typename Value>
std::string signal_name(const sc_core::sc_in<Value>& port) {
    return bound_signal(port, port.get_interface());
}

}  // namespace metabuffer::monitors
