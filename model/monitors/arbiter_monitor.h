#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <systemc>
#include <vector>

#include "datapath/arbitration/arbitration_table.h"
#include "monitors/rule_reporter.h"
#include "monitors/violation.h"
#include "rtl/block.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// Checks a bus arbiter (section 5.3 of the paper) from outside: its request lines and its answers, at each edge of the
/// core clock at which the bus receives an answer. The monitor goes through slots and deadlines one by one. For a policy
/// without a proof, order and slots are not checked.
///
/// Rules; at each edge only the first broken one is reported:
/// - arbiter/one-hot: as many grant lines are high as GRANT_VALID says, one or none
/// - arbiter/search: an answer comes grant_cycles after the edge at which some row could be granted, and none before
///   the slot table is built; SEARCH is high until then
/// - arbiter/request: a grant is for a row that has pixels left and whose composer took a slot when it was decided
/// - arbiter/order: the grant, or the lost slot, is the policy's choice
/// - arbiter/recovered: RECOVERED is the number of slots that were passed over
/// - arbiter/slot: the slot pointer is one past the slot that was granted or lost last
class ArbiterMonitor final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<bool> start_i{"start_i"};
    sc_core::sc_in<rtl::FrontTable> table_i{"table_i"};
    sc_core::sc_in<bool> take_i{"take_i"};
    sc_core::sc_vector<sc_core::sc_in<bool>> pending_i;
    sc_core::sc_vector<sc_core::sc_in<bool>> ready_i;
    sc_core::sc_vector<sc_core::sc_in<std::uint64_t>> deadline_i;  ///< only under a policy that goes by it
    sc_core::sc_vector<sc_core::sc_in<bool>> grant_i;
    sc_core::sc_in<bool> grant_valid_i{"grant_valid_i"};
    sc_core::sc_in<bool> search_i{"search_i"};
    sc_core::sc_in<bool> lost_i{"lost_i"};
    sc_core::sc_in<std::uint16_t> recovered_i{"recovered_i"};
    sc_core::sc_in<std::uint16_t> slot_i{"slot_i"};

    /// renderer: index, from 0.
    ArbiterMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
                   ViolationLog& log);

    /// Answers that the bus has received: grants and lost slots.
    std::int64_t grants() const { return grants_; }
    std::int64_t lost_slots() const { return lost_slots_; }
    std::int64_t recovered_slots() const { return recovered_slots_; }
    /// Violations that were not reported, since one of the same rule and frame was.
    std::int64_t unreported() const { return reporter_.unreported(); }

  private:
    /// The policy's choice.
    struct Choice {
        std::size_t row = 0;
        std::size_t recovered = 0;
        bool lost = false;
    };

    void clock_edge();
    void restart();
    void start_frame(std::int64_t edge);
    void check_answer(std::int64_t edge);
    bool check_request(std::size_t row, std::int64_t edge);
    void check_choice(std::int64_t edge);
    void take_answer();
    std::size_t lines_high() const;
    std::size_t granted_row() const;
    bool usable(std::size_t row) const { return pending_i[row].read() && ready_i[row].read(); }
    std::optional<Choice> choice() const;
    std::optional<Choice> choice_by_slot() const;
    std::optional<Choice> choice_by_deadline() const;
    bool answer_due(std::int64_t edge);
    void violate(const char* rule, const char* signal, std::int64_t edge, const std::string& detail);

    std::string arbiter_;  ///< "bus_arbiter_1"
    const ArbitrationRow& policy_;
    BusConfig bus_;
    std::int64_t core_period_picoseconds_;

    RuleReporter reporter_;

    std::int64_t frame_ = -1;  ///< on the bus
    std::vector<int> slots_;   ///< the row that owns each slot
    std::size_t rows_ = 0;
    std::size_t slot_ = 0;           ///< that is checked first
    std::int64_t decides_from_ = 0;  ///< the first edge at which the slot table is ready
    // An answer that takes clocks.
    bool decided_ = false;
    std::int64_t due_ = 0;  ///< the edge at which it must come
    std::vector<bool> requests_;
    std::optional<Choice> chosen_;

    std::int64_t grants_ = 0;
    std::int64_t lost_slots_ = 0;
    std::int64_t recovered_slots_ = 0;
    rtl::Clocked clocked_{*this, clk_i, &ArbiterMonitor::clock_edge};
};

}  // namespace metabuffer::monitors
