#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "datapath/arbitration/arbitration_policy.h"
#include "rtl/block.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

class VerilatedContext;
class VerilatedBusArbiter;

namespace metabuffer::rtl {

/// The bus arbiter of tb/verilog/bus_arbiter.sv, verilated, in the place of model/rtl's: the same ports with the same
/// meaning and timing, which are written at that class.
///
/// Raises /metabuffer/bus_arbiter/size at elaboration if the scenario has more displays than the module was verilated
/// for.
class BusArbiter final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<bool> start_i{"start_i"};
    sc_core::sc_in<FrontTable> table_i{"table_i"};
    sc_core::sc_in<bool> take_i{"take_i"};
    sc_core::sc_vector<sc_core::sc_in<bool>> pending_i;
    sc_core::sc_vector<sc_core::sc_in<bool>> ready_i;
    sc_core::sc_vector<sc_core::sc_in<std::uint64_t>> deadline_i;  ///< only under a policy that uses it
    sc_core::sc_vector<sc_core::sc_out<bool>> grant_o;
    sc_core::sc_out<bool> grant_valid_o{"grant_valid_o"};
    sc_core::sc_out<bool> search_o{"search_o"};
    sc_core::sc_out<bool> lost_o{"lost_o"};
    sc_core::sc_out<std::uint16_t> recovered_o{"recovered_o"};
    sc_core::sc_out<std::uint16_t> slot_o{"slot_o"};

    /// lines: number of displays.
    BusArbiter(const sc_core::sc_module_name& name, const BusConfig& bus, int lines);
    ~BusArbiter() override;
    SC_HAS_PROCESS(BusArbiter);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    void process();
    void clock_edge();
    void drive_table();
    void drive_requests();
    void drive_outputs();

    std::unique_ptr<VerilatedContext> context_;
    std::unique_ptr<VerilatedBusArbiter> verilated_;
    std::uint64_t granted_ = 0;  ///< grant lines as they were written last, line 0 lowest
};

}  // namespace metabuffer::rtl
