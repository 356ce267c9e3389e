#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "monitors/arbiter_monitor.h"
#include "monitors/bus_monitor.h"
#include "monitors/composer_monitor.h"
#include "monitors/dvi_monitor.h"
#include "monitors/fifo_monitor.h"
#include "monitors/memory_monitor.h"
#include "monitors/pipeline_monitor.h"
#include "monitors/scoreboard.h"
#include "monitors/swap_lock_monitor.h"
#include "monitors/tmds_monitor.h"
#include "monitors/violation.h"
#include "report/report.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {
class Metabuffer;
struct Wires;
}  // namespace metabuffer::rtl

namespace metabuffer::monitors {

/// Every rule that a bound machine is checked against, by the name that a violation has.
const std::vector<std::string>& machine_rules();

/// All monitors and scoreboards of a machine, bound to its wires from outside: a BusMonitor, an ArbiterMonitor, a
/// MemoryMonitor and a DviMonitor for each renderer, a ComposerMonitor and a FifoMonitor for each composer, a
/// PipelineMonitor and a DviMonitor for each display, a TmdsMonitor for each link with characters, one SwapLockMonitor
/// and one Scoreboard. The inside of a block that shows no wires has no monitor. A link whose clock drifts is watched at
/// that clock. To be made after the machine and before the simulation starts.
class MachineMonitors final : public sc_core::sc_module {
  public:
    /// Scenario, machine and log must outlive the simulation.
    MachineMonitors(const sc_core::sc_module_name& name, const Scenario& scenario, rtl::Metabuffer& machine,
                    ViolationLog& log);
    ~MachineMonitors() override;

    /// Compares what the monitors have counted with what the machine reports at the end of its run. To be called in
    /// the clock in which the run has finished. Rules: counters/bus, counters/composer, counters/display.
    void finish(const RunReport& report);

    const Scoreboard& scoreboard() const { return *scoreboard_; }
    const SwapLockMonitor& swap_lock() const { return *swap_lock_; }
    const BusMonitor& bus(std::size_t renderer) const { return *buses_[renderer]; }
    /// composer: renderer * displays + display, indices.
    const ComposerMonitor& composer(std::size_t composer) const { return *composers_[composer]; }
    const PipelineMonitor& pipeline(std::size_t display) const { return *pipelines_[display]; }
    /// Violations that were seen and not reported, since one of the same wire and frame was.
    std::int64_t unreported() const;

  private:
    void bind_bus(std::size_t renderer);
    void bind_arbiter(std::size_t renderer);
    void bind_memory(std::size_t renderer);
    void bind_link(std::size_t renderer);
    void bind_composer(std::size_t renderer, std::size_t display);
    void bind_fifo(std::size_t renderer, std::size_t display);
    void bind_pipeline(std::size_t display);
    void bind_output(std::size_t display);
    void bind_characters_in(std::size_t renderer);
    void bind_characters_out(std::size_t display);
    void bind_swap_lock();
    void finish_arbiter(const ArbiterMonitor& arbiter, const RendererCounters& counters, std::int64_t cycle);
    std::int64_t resets() const;
    void finish_bus(std::size_t renderer, const RendererCounters& counters, std::int64_t cycle);
    void finish_composer(std::size_t composer, const ComposerCounters& counters, std::int64_t cycle);
    void finish_display(std::size_t display, const DisplayCounters& counters, std::int64_t cycle);
    void finish_stalls(std::size_t display, const DisplayCounters& counters, std::int64_t cycle);

    const Scenario& scenario_;
    rtl::Metabuffer& machine_;
    ViolationLog& log_;
    std::size_t renderers_;
    std::size_t displays_;

    std::vector<std::unique_ptr<BusMonitor>> buses_;
    std::vector<std::unique_ptr<ArbiterMonitor>> arbiters_;    ///< null where there is none
    std::vector<std::unique_ptr<MemoryMonitor>> memories_;     ///< likewise
    std::vector<std::unique_ptr<ComposerMonitor>> composers_;  ///< renderer by renderer
    std::vector<std::unique_ptr<FifoMonitor>> fifos_;  ///< likewise; null for a composer without wires inside
    std::vector<std::unique_ptr<PipelineMonitor>> pipelines_;
    std::vector<std::unique_ptr<DviMonitor>> links_;        ///< inputs, then outputs
    std::vector<std::unique_ptr<TmdsMonitor>> characters_;  ///< likewise, of links with characters
    std::unique_ptr<SwapLockMonitor> swap_lock_;
    std::unique_ptr<Scoreboard> scoreboard_;
};

}  // namespace metabuffer::monitors
