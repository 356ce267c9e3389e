#pragma once

#include <cstdint>
#include <memory>

#include "report/composer_record.h"
#include "rtl/block.h"
#include "rtl/fifo_wires.h"
#include "rtl/signals.h"

class VerilatedContext;
class VerilatedComposer;

namespace metabuffer::rtl {

/// The composer of tb/verilog/composer.sv, verilated, in the place of model/rtl's: the same ports with the same
/// meaning, timing and errors, which are written at that class and its parts. What is not a pin of the composer
/// (counters, frame spans, what it waits for) is derived here from the status outputs of the SystemVerilog module.
///
/// Raises /metabuffer/composer/protocol as model/rtl's composer does, and at elaboration /metabuffer/composer/size
/// if the scenario needs a larger memory than the module was verilated with, /metabuffer/composer/smoothing if it wants
/// smoothing and the module was verilated with a window of one row.
class Composer final : public Block, public ComposerRecord {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<bool> pipemaster_i{"pipemaster_i"};
    sc_core::sc_in<BusBeat> bus_i{"bus_i"};
    sc_core::sc_out<bool> busready_o{"busready_o"};
    sc_core::sc_out<bool> tableready_o{"tableready_o"};
    sc_core::sc_in<bool> startframe_i{"startframe_i"};
    sc_core::sc_out<bool> startframe_o{"startframe_o"};
    sc_core::sc_in<PipePixel> pipe_i{"pipe_i"};
    sc_core::sc_out<PipePixel> pipe_o{"pipe_o"};
    sc_core::sc_in<bool> pipeready_i{"pipeready_i"};
    sc_core::sc_out<bool> pipeready_o{"pipeready_o"};
    sc_core::sc_in<bool> column_stall_i{"column_stall_i"};
    sc_core::sc_out<bool> stall_o{"stall_o"};

    Composer(const sc_core::sc_module_name& name, const Scenario& scenario, int display);
    ~Composer() override;

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// Its FIFO is inside the module, without wires in SystemC.
    FifoWires* fifo_wires() { return nullptr; }

  private:
    /// The status outputs before an edge, as a counter needs them after it.
    struct Before {
        bool running = false;
        int x = 0;
        int y = 0;
    };

    void configure(const Scenario& scenario, int display);
    void clock_edge();
    void drive_inputs();
    void drive_outputs();
    void count(const Before& before);
    void count_frame(const Before& before, std::int64_t cycle);
    void report_protocol_error() const;
    bool idle(bool was_running) const;

    bool stall_mode_;
    std::int64_t core_period_picoseconds_;
    bool pipemaster_ = false;  ///< the strap, which the module has read in reset
    std::unique_ptr<VerilatedContext> context_;
    std::unique_ptr<VerilatedComposer> verilated_;
    Clocked clocked_{*this, clk_i, &Composer::clock_edge};
};

}  // namespace metabuffer::rtl
