#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "monitors/violation.h"
#include "report/report.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {
class Metabuffer;
}  // namespace metabuffer::rtl

namespace metabuffer::monitors {
class MachineMonitors;
}  // namespace metabuffer::monitors

namespace metabuffer {

/// `metabuffer run --check` at level rtl: every monitor and scoreboard on the machine's wires, and what they find.
class MachineCheck {
  public:
    /// The scenario must outlive the check.
    explicit MachineCheck(const Scenario& scenario);
    MachineCheck(const MachineCheck&) = delete;
    MachineCheck& operator=(const MachineCheck&) = delete;
    ~MachineCheck();

    /// Binds to a machine that has not started yet.
    void attach(rtl::Metabuffer& machine);
    /// Call it at the end of the run. Compares the report's counters with what the wires have shown.
    void finish(const RunReport& report);

    const CheckRecord& record() const { return record_; }
    /// What was compared, for a summary; empty before finish().
    const std::string& compared() const { return compared_; }
    /// Options that show the first violation in a waveform; empty if there was none.
    const std::string& trace_options() const { return trace_options_; }

  private:
    void found(const monitors::Violation& violation);

    const Scenario& scenario_;
    CheckRecord record_;
    std::string compared_;
    std::string trace_options_;
    monitors::ViolationLog log_;
    std::unique_ptr<monitors::MachineMonitors> monitors_;
};

}  // namespace metabuffer
