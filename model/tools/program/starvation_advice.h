#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/child_process.h"
#include "host/message_channel.h"
#include "report/report.h"
#include "scenario/scenario.h"

namespace metabuffer {

/// What would keep the pixels of a scenario from starving: the least buffer, the least bus and memory, and columns that
/// stall. Each is tried by a run before it is named.
class StarvationAdvice {
  public:
    /// All runs together take no longer; what is not known by then is not named.
    static constexpr int kMostMilliseconds = 900;

    /// Starts the process in which the runs are tried. Construct it before this process elaborates anything. If no process
    /// can be started, or level tlm does not know what the run would do, there is no advice. The scenario must outlive it.
    explicit StarvationAdvice(const Scenario& scenario);
    StarvationAdvice(const StarvationAdvice&) = delete;
    StarvationAdvice& operator=(const StarvationAdvice&) = delete;
    ~StarvationAdvice();

    /// A line for each change that helps by itself; none if nothing starved in the run.
    std::vector<std::string> lines(const RunReport& report) const;
    /// The same for a terminal. If no change is known in time, which command finds one.
    std::string text(const RunReport& report, const std::string& scenario_file) const;

  private:
    class Process;
    std::unique_ptr<Process> process_;
};

}  // namespace metabuffer
