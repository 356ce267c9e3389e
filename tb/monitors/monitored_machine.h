#pragma once

#include <string>
#include <utility>
#include <vector>

#include "monitors/machine_monitors.h"
#include "rtl/metabuffer.h"

namespace metabuffer::test {

/// A machine of level rtl with every monitor bound to its wires, whose violations are kept instead of ending the run.
class MonitoredMachine {
  public:
    MonitoredMachine(const std::string& name, Scenario scenario)
        : scenario_(std::move(scenario)),
          machine_(name.c_str(), scenario_),
          monitors_((name + "_monitors").c_str(), scenario_, machine_, log_) {
        log_.on_violation([this](const monitors::Violation& violation) { violations_.push_back(violation); });
    }

    const Scenario& scenario() const { return scenario_; }
    const rtl::Metabuffer& machine() const { return machine_; }
    rtl::Metabuffer& machine() { return machine_; }
    const std::vector<monitors::Violation>& violations() const { return violations_; }
    const monitors::MachineMonitors& monitors() const { return monitors_; }

    std::size_t renderers() const { return scenario_.renderers.size(); }
    std::size_t displays() const { return static_cast<std::size_t>(scenario_.displays.count()); }

  private:
    Scenario scenario_;
    rtl::Metabuffer machine_;
    monitors::ViolationLog log_;
    std::vector<monitors::Violation> violations_;
    monitors::MachineMonitors monitors_;
};

}  // namespace metabuffer::test
