#include "monitors/arbiter_monitor.h"

#include <algorithm>

namespace metabuffer::monitors {

ArbiterMonitor::ArbiterMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
                               ViolationLog& log)
    : sc_core::sc_module(name),
      pending_i("pending_i", static_cast<std::size_t>(scenario.displays.count())),
      ready_i("ready_i", pending_i.size()),
      deadline_i("deadline_i", goes_by_deadlines(scenario.bus.arbitration) ? pending_i.size() : 0),
      grant_i("grant_i", pending_i.size()),
      arbiter_("bus_arbiter_" + std::to_string(renderer + 1)),
      policy_(arbitration_row(scenario.bus.arbitration)),
      bus_(scenario.bus),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      reporter_(log) {}

void ArbiterMonitor::violate(const char* rule, const char* signal, std::int64_t edge,
                             const std::string& detail) {
    reporter_.report(rule, rule, arbiter_ + '.' + signal, edge, frame_, detail);
}

void ArbiterMonitor::restart() {
    frame_ = -1;
    slots_.clear();
    rows_ = slot_ = 0;
    decided_ = false;
    chosen_.reset();
}

void ArbiterMonitor::clock_edge() {
    const std::int64_t edge = rtl::clock_edge_number(core_period_picoseconds_);
    if (reset_i.read()) {
        restart();
    } else if (start_i.read()) {
        start_frame(edge);
    } else if (take_i.read()) {
        check_answer(edge);
    }
    if (reset_i.read() || start_i.read() || take_i.read()) {
        clocked_.stay_awake();
    }
}

void ArbiterMonitor::start_frame(std::int64_t edge) {
    const rtl::FrontTable& table = table_i.read();
    ++frame_;
    slots_ = table.slots;
    rows_ = table.rows.size();
    slot_ = 0;
    decided_ = false;
    decides_from_ = edge + 1 + bus_.build_cycles(slots_.size());
}

// ---- what the lines say ----

std::size_t ArbiterMonitor::lines_high() const {
    return static_cast<std::size_t>(std::count_if(
        grant_i.begin(), grant_i.end(), [](const sc_core::sc_in<bool>& line) { return line.read(); }));
}

/// The row whose line is high; there must be one.
std::size_t ArbiterMonitor::granted_row() const {
    const auto line = std::find_if(grant_i.begin(), grant_i.end(),
                                   [](const sc_core::sc_in<bool>& grant) { return grant.read(); });
    return static_cast<std::size_t>(line - grant_i.begin());
}

// ---- what the policy would choose ----

/// Nothing if no row is chosen: the bus asks again at the next clock.
std::optional<ArbiterMonitor::Choice> ArbiterMonitor::choice() const {
    return policy_.proof == BufferProof::kDeadlines ? choice_by_deadline() : choice_by_slot();
}

std::optional<ArbiterMonitor::Choice> ArbiterMonitor::choice_by_slot() const {
    for (std::size_t passed = 0; passed < slots_.size(); ++passed) {
        const auto row = static_cast<std::size_t>(slots_[(slot_ + passed) % slots_.size()]);
        if (usable(row)) return Choice{row, passed, false};
        if (policy_.idle_slots == IdleSlots::kLost) return Choice{row, 0, true};
    }
    return std::nullopt;
}

std::optional<ArbiterMonitor::Choice> ArbiterMonitor::choice_by_deadline() const {
    std::optional<Choice> first;
    for (std::size_t row = 0; row < rows_; ++row) {
        if (usable(row) && (!first || deadline_i[row].read() < deadline_i[first->row].read())) {
            first = Choice{row, 0, false};
        }
    }
    return first;
}

// ---- the answer ----

/// Notes what is decided on at this edge; false while the answer to it is on its way.
bool ArbiterMonitor::answer_due(std::int64_t edge) {
    if (edge < decides_from_) return false;
    if (!decided_) {
        requests_.assign(rows_, false);
        for (std::size_t row = 0; row < rows_; ++row) requests_[row] = usable(row);
        chosen_ = policy_.proof == BufferProof::kNone ? std::nullopt : choice();
        const bool nobody = std::find(requests_.begin(), requests_.end(), true) == requests_.end();
        if (!chosen_ && nobody && !lost_i.read()) return true;
        decided_ = true;
        due_ = edge + bus_.grant_cycles;
    }
    return edge == due_;
}

void ArbiterMonitor::check_answer(std::int64_t edge) {
    const std::size_t high = lines_high();
    if (high != (grant_valid_i.read() ? 1U : 0U)) {
        violate("arbiter/one-hot", "grant", edge,
                std::to_string(high) + " grant lines are high, and GRANT_VALID is " +
                    (grant_valid_i.read() ? "high" : "low"));
        decided_ = false;
        return;
    }
    const bool answered = grant_valid_i.read() || lost_i.read();
    const bool due = answer_due(edge);
    if (!due || search_i.read()) {
        if (due || answered || !search_i.read()) {
            violate("arbiter/search", "search", edge,
                    std::string(due ? "SEARCH is high when the answer is due"
                                    : "an answer, or a low SEARCH, before the answer is due"));
            decided_ = false;
        }
        return;
    }
    if (grant_valid_i.read() && !check_request(granted_row(), edge)) {
        decided_ = false;
        return;
    }
    if (policy_.proof != BufferProof::kNone) {
        check_choice(edge);
    }
    take_answer();
}

bool ArbiterMonitor::check_request(std::size_t row, std::int64_t edge) {
    if (row < rows_ && requests_[row]) {
        return true;
    }
    violate("arbiter/request", "grant", edge,
            "a grant for row " + std::to_string(row + 1) + ", which has no pixels left or no room for them");
    return false;
}

void ArbiterMonitor::check_choice(std::int64_t edge) {
    const bool grants = chosen_ && !chosen_->lost;
    const bool loses = chosen_ && chosen_->lost;
    if (grant_valid_i.read() != grants || lost_i.read() != loses ||
        (grants && granted_row() != chosen_->row)) {
        violate(
            "arbiter/order", "grant", edge,
            std::string("the answer is ") +
                (grant_valid_i.read() ? "row " + std::to_string(granted_row() + 1)
                                      : (lost_i.read() ? "a lost slot" : "nobody")) +
                ", the policy's choice " +
                (grants ? "row " + std::to_string(chosen_->row + 1) : (loses ? "a lost slot" : "nobody")));
        return;
    }
    if (grants && recovered_i.read() != chosen_->recovered) {
        violate("arbiter/recovered", "recovered", edge,
                std::to_string(recovered_i.read()) + " slots passed over, not " +
                    std::to_string(chosen_->recovered));
    }
    if (slot_i.read() != slot_) {
        violate(
            "arbiter/slot", "slot", edge,
            "the slot pointer stands at " + std::to_string(slot_i.read()) + ", not " + std::to_string(slot_));
    }
}

/// Goes on from the arbiter's answer, so that one mistake is reported once.
void ArbiterMonitor::take_answer() {
    decided_ = false;
    if (!grant_valid_i.read() && !lost_i.read()) {
        return;
    }
    const std::size_t passed = grant_valid_i.read() ? recovered_i.read() : 0;
    grants_ += grant_valid_i.read() ? 1 : 0;
    lost_slots_ += lost_i.read() ? 1 : 0;
    recovered_slots_ += static_cast<std::int64_t>(passed);
    if (!slots_.empty()) {
        slot_ = (slot_i.read() + passed + 1) % slots_.size();
    }
}

}  // namespace metabuffer::monitors
