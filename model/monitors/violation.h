#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace metabuffer::monitors {

/// A rule of the machine's protocols that a block has broken, and where to look for it in a waveform.
struct Violation {
    std::string rule;         ///< short and stable: "bus/busready", "pipeline/raster", "pipeready/prefetched"
    std::string signal;       ///< by its name in the waveform: "BUS_1", "PIPEREADY_2_1"
    std::string clock;        ///< the clock that `cycle` counts: "core", "dvi_in", "dvi_out"
    std::int64_t cycle = 0;   ///< rising edges of that clock from time 0
    std::int64_t frame = -1;  ///< composited frame, from 0; for a link its pair; -1: none yet
    std::string detail;       ///< what was seen and what would have been right
};

/// "bus/busready: BUS_1, core clock 1204, frame 0: ..."
std::string to_string(const Violation& violation);

/// A wire's level, for a violation's detail.
constexpr const char* level_name(bool high) { return high ? "high" : "low"; }

/// Where monitors report violations. Without a listener each is an SC_REPORT_ERROR of type /metabuffer/monitor/<rule>,
/// which ends a test.
class ViolationLog {
  public:
    void on_violation(std::function<void(const Violation&)> listener) { listener_ = std::move(listener); }
    void add(const Violation& violation);
    std::int64_t count() const { return count_; }

  private:
    std::function<void(const Violation&)> listener_;
    std::int64_t count_ = 0;
};

}  // namespace metabuffer::monitors
