#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "monitors/bus_monitor.h"
#include "monitors/composer_monitor.h"
#include "monitors/pipeline_monitor.h"
#include "rtl/metabuffer.h"
#include "rtl/wires.h"

namespace metabuffer::test {

/// A machine of level rtl with the monitors of its buses, composers and pipelines bound to its wires.
class MonitoredMachine {
  public:
    MonitoredMachine(const std::string& name, Scenario scenario)
        : scenario_(std::move(scenario)), machine_(name.c_str(), scenario_) {
        machine_.on_finished([this] { report_ = machine_.report(); });
        log_.on_violation([this](const monitors::Violation& violation) { violations_.push_back(violation); });
        for (std::size_t r = 0; r < renderers(); ++r) watch_bus(name, r);
        for (std::size_t r = 0; r < renderers(); ++r) {
            for (std::size_t d = 0; d < displays(); ++d) watch_composer(name, r, d);
        }
        for (std::size_t d = 0; d < displays(); ++d) watch_pipeline(name, d);
    }

    const Scenario& scenario() const { return scenario_; }
    const rtl::Metabuffer& machine() const { return machine_; }
    const RunReport& report() const { return report_; }  ///< when it finished
    const std::vector<monitors::Violation>& violations() const { return violations_; }
    const monitors::BusMonitor& bus(std::size_t renderer) const { return *buses_[renderer]; }
    const monitors::ComposerMonitor& composer(std::size_t i) const { return *composers_[i]; }
    const monitors::PipelineMonitor& pipeline(std::size_t display) const { return *pipelines_[display]; }

    std::size_t renderers() const { return scenario_.renderers.size(); }
    std::size_t displays() const { return static_cast<std::size_t>(scenario_.displays.count()); }

  private:
    void watch_bus(const std::string& name, std::size_t r) {
        rtl::Wires& wires = machine_.wires();
        auto monitor = std::make_unique<monitors::BusMonitor>((name + rtl::numbered("_bus", r)).c_str(),
                                                              scenario_, static_cast<int>(r), log_);
        monitor->clk_i(machine_.core_clk());
        monitor->reset_i(machine_.reset());
        monitor->bus_i(wires.bus[r]);
        for (std::size_t d = 0; d < displays(); ++d) {
            monitor->busready_i[d](wires.busready[r * displays() + d]);
            monitor->tableready_i[d](wires.tableready[r * displays() + d]);
        }
        buses_.push_back(std::move(monitor));
    }

    void watch_composer(const std::string& name, std::size_t r, std::size_t d) {
        rtl::Wires& wires = machine_.wires();
        auto monitor = std::make_unique<monitors::ComposerMonitor>(
            (name + rtl::numbered("_composer", r, d)).c_str(), scenario_, static_cast<int>(r),
            static_cast<int>(d), log_);
        const std::size_t above = r * displays() + d;
        const std::size_t below = above + displays();
        monitor->clk_i(machine_.core_clk());
        monitor->reset_i(machine_.reset());
        monitor->pipemaster_i(wires.pipemaster[r]);
        monitor->bus_i(wires.bus_seen_by(above));
        monitor->busready_o(wires.busready[above]);
        monitor->tableready_o(wires.tableready[above]);
        monitor->startframe_i(wires.startframe[above]);
        monitor->startframe_o(wires.startframe[below]);
        monitor->pipe_i(wires.pipe[above]);
        monitor->pipe_o(wires.pipe[below]);
        monitor->pipeready_i(wires.pipeready[below]);
        monitor->pipeready_o(wires.pipeready[above]);
        monitor->column_stall_i(wires.column_stall[d]);
        monitor->stall_o(wires.stall[above]);
        composers_.push_back(std::move(monitor));
    }

    void watch_pipeline(const std::string& name, std::size_t d) {
        rtl::Wires& wires = machine_.wires();
        auto monitor = std::make_unique<monitors::PipelineMonitor>(
            (name + rtl::numbered("_pipeline", d)).c_str(), scenario_, static_cast<int>(d), log_);
        monitor->clk_i(machine_.core_clk());
        monitor->reset_i(machine_.reset());
        monitor->column_stall_i(wires.column_stall[d]);
        for (std::size_t r = 0; r < renderers(); ++r) {
            monitor->startframe_o[r](wires.startframe[(r + 1) * displays() + d]);
            monitor->pipe_o[r](wires.pipe[(r + 1) * displays() + d]);
        }
        monitor->pipeready_i(wires.pipeready[renderers() * displays() + d]);
        pipelines_.push_back(std::move(monitor));
    }

    Scenario scenario_;
    rtl::Metabuffer machine_;
    monitors::ViolationLog log_;
    std::vector<monitors::Violation> violations_;
    std::vector<std::unique_ptr<monitors::BusMonitor>> buses_;
    std::vector<std::unique_ptr<monitors::ComposerMonitor>> composers_;
    std::vector<std::unique_ptr<monitors::PipelineMonitor>> pipelines_;
    RunReport report_;
};

}  // namespace metabuffer::test
