#pragma once

#include <cstdint>
#include <functional>
#include <queue>
#include <systemc>
#include <tuple>
#include <vector>

#include "tlm/column_time.h"
#include "tlm/cycle.h"

namespace metabuffer::tlm {

/// What a decider decides next, and when. It names the core clocks of its decisions itself.
struct Decision {
    std::int64_t cycle = kUnknownCycle;
    bool is_certain = false;  ///< it depends on nothing that another one may still bring about
};

/// The decisions of a machine's buses, in order of time. An event of the kernel for each of them would take longer than
/// they do. So those that come before the kernel's next event are taken at once, at a clock of the agenda's own; and as
/// long as a decider is certain, it goes on before another one has its turn.
class Agenda final : public sc_core::sc_module {
  public:
    /// horizon: the last clock up to which the run certainly lasts. No decider goes on beyond it.
    Agenda(const sc_core::sc_module_name& name, const ClockDomain& core,
           std::function<std::int64_t()> horizon);
    SC_HAS_PROCESS(Agenda);

    /// Called at the clock of a decision; returns the next one.
    using Decider = std::function<Decision(std::int64_t cycle)>;
    /// Returns its number.
    std::size_t add(Decider decider);
    /// The decider's next decision, in place of one that it has named before.
    void schedule(std::size_t number, std::int64_t cycle);
    /// The present core clock. All decisions of earlier clocks have been taken.
    std::int64_t now() const { return is_running_ ? cycle_ : core_.edge_at(now_picoseconds()); }

  private:
    struct Entry {
        std::int64_t cycle;
        std::size_t number;
        friend bool operator>(const Entry& a, const Entry& b) {
            return std::tie(a.cycle, a.number) > std::tie(b.cycle, b.number);
        }
    };

    void run();
    bool forget_replaced();
    bool is_within_horizon(std::int64_t cycle);

    ClockDomain core_;
    sc_core::sc_event wake_;
    std::vector<Decider> deciders_;
    std::vector<std::int64_t> next_cycles_;  ///< by decider; other entries of it do not count
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> entries_;
    bool is_running_ = false;
    std::int64_t cycle_ = 0;
    std::function<std::int64_t()> horizon_;
    std::int64_t known_horizon_ = -1;
};

}  // namespace metabuffer::tlm
