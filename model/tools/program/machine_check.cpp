#include "tools/program/machine_check.h"

#include <algorithm>

#include "monitors/machine_monitors.h"
#include "rtl/metabuffer.h"

namespace metabuffer {
namespace {

/// Core clocks that a waveform shows before and after a violation.
constexpr std::int64_t kClocksAround = 50;

}  // namespace

MachineCheck::MachineCheck(const Scenario& scenario) : scenario_(scenario) {
    record_.rules = static_cast<int>(monitors::machine_rules().size());
    log_.on_violation([this](const monitors::Violation& violation) { found(violation); });
}

MachineCheck::~MachineCheck() = default;

void MachineCheck::attach(rtl::Metabuffer& machine) {
    monitors_ = std::make_unique<monitors::MachineMonitors>("monitors", scenario_, machine, log_);
}

void MachineCheck::finish(const RunReport& report) {
    monitors_->finish(report);
    const monitors::Scoreboard& scoreboard = monitors_->scoreboard();
    record_.pictures = scoreboard.pictures();
    compared_ = std::to_string(record_.rules) + " rules, " + std::to_string(scoreboard.bus_pixels()) +
                " pixels on buses, " + std::to_string(scoreboard.raster_pixels()) +
                " pixels out of pipelines and " + std::to_string(record_.pictures) + " pictures";
}

void MachineCheck::found(const monitors::Violation& violation) {
    record_.add(to_string(violation));
    if (!trace_options_.empty()) return;
    std::int64_t cycle = violation.cycle;
    const std::int64_t core_period = clock_period_picoseconds(scenario_.clocks.core_mhz);
    if (violation.clock == "dvi_in") {
        cycle = cycle * clock_period_picoseconds(scenario_.clocks.dvi_in_mhz) / core_period;
    } else if (violation.clock == "dvi_out") {
        cycle = cycle * clock_period_picoseconds(scenario_.clocks.dvi_out_mhz) / core_period;
    }
    trace_options_ = "--trace FILE.vcd --trace-window cycles:" +
                     std::to_string(std::max<std::int64_t>(0, cycle - kClocksAround)) + "-" +
                     std::to_string(cycle + kClocksAround);
}

}  // namespace metabuffer
