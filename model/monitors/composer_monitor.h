#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <systemc>
#include <utility>

#include "monitors/composer_observer.h"
#include "monitors/fault_window.h"
#include "monitors/rule_reporter.h"
#include "monitors/violation.h"
#include "rtl/block.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// Watches one composer (box C; sections 4 and 5.2 to 5.4 of the paper): compares everything that it drives with what a
/// ComposerObserver expects. The ports have the names of the composer's, but all are inputs. Changes nothing.
///
/// Rules: composer/pixel, composer/lost, composer/busready, composer/tableready, composer/stall, composer/occupancy,
/// composer/table, pipeline/raster, pipeline/startframe, pipeline/freeze, pipeready/prefetched, pipeready/below,
/// pipeready/taken-back, pipeready/startframe, pipeready/late, pipeready/unready; docs/monitors.md says what each
/// means.
/// While a fault of the scenario may hold a handshake low, the handshake is not checked to be high; while a fault may
/// raise STALL, STALL is not checked to be low. A violation's cycle is the edge that samples the wrong value: the waveform
/// shows it from the edge before on.
class ComposerMonitor final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<bool> pipemaster_i{"pipemaster_i"};
    sc_core::sc_in<rtl::BusBeat> bus_i{"bus_i"};  ///< as this composer sees it
    sc_core::sc_in<bool> busready_o{"busready_o"};
    sc_core::sc_in<bool> tableready_o{"tableready_o"};
    sc_core::sc_in<bool> startframe_i{"startframe_i"};
    sc_core::sc_in<bool> startframe_o{"startframe_o"};
    sc_core::sc_in<rtl::PipePixel> pipe_i{"pipe_i"};
    sc_core::sc_in<rtl::PipePixel> pipe_o{"pipe_o"};
    sc_core::sc_in<bool> pipeready_i{"pipeready_i"};
    sc_core::sc_in<bool> pipeready_o{"pipeready_o"};
    sc_core::sc_in<bool> column_stall_i{"column_stall_i"};
    sc_core::sc_in<bool> stall_o{"stall_o"};

    /// renderer, display: indices, from 0.
    ComposerMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer, int display,
                    ViolationLog& log);

    const ComposerObserver& observer() const { return observer_; }
    /// Called for each raster pixel that starves, at the edge that composites it.
    void on_starved_pixel(std::function<void(const StarvedPixel&)> callback) {
        observer_.on_starved_pixel(std::move(callback));
    }
    /// Derived from outside; renderer and display are set.
    const ComposerCounters& counters() const { return observer_.counters(); }
    /// Violations that were seen and not reported, since one of the same wire and frame was.
    std::int64_t unreported() const { return reporter_.unreported(); }

  private:
    void end_of_elaboration() override;
    void clock_edge();
    void check_outputs(std::int64_t cycle);
    void check_pipe(std::int64_t cycle);
    void check_pipeready(std::int64_t cycle);
    void check_wire(const char* rule, bool seen, bool expected, const std::string& signal, std::int64_t cycle,
                    std::int64_t frame, const char* why);
    void observe(const ComposerInputs& inputs, std::int64_t cycle);

    std::string composer_;  ///< "composer 2, 1: "
    std::int64_t core_period_picoseconds_;
    ComposerObserver observer_;
    RuleReporter reporter_;

    FaultWindows busready_holds_;
    FaultWindows tableready_holds_;
    FaultWindows pipeready_holds_;
    FaultWindows stall_holds_;
    bool seen_reset_ = false;        ///< the values on the outputs are defined
    bool pipeready_before_ = false;  ///< own PIPEREADY as sampled one edge ago
    bool startframe_read_ = false;   ///< a frame has started at the last edge
    int pixel_x_ = 0;                ///< raster position of the pixel on pipe_o
    int pixel_y_ = 0;

    std::string busready_name_;
    std::string tableready_name_;
    std::string startframe_name_;
    std::string pipe_name_;
    std::string pipeready_name_;
    std::string stall_name_;
    std::string bus_name_;
    rtl::Clocked clocked_{*this, clk_i, &ComposerMonitor::clock_edge};
};

}  // namespace metabuffer::monitors
