#include "rtl/bus_arbiter.h"

#include <algorithm>

#include "datapath/arbitration/arbitration_table.h"
#include "rtl/register.h"
#include "rtl/wires.h"

namespace metabuffer::rtl {
namespace {

/// A raster has at most 2^32 positions.
constexpr int kDeadlineBits = 32;

}  // namespace

BusArbiter::BusArbiter(const sc_core::sc_module_name& name, const BusConfig& bus, int lines)
    : Block(name),
      pending_i("pending_i", static_cast<std::size_t>(lines)),
      ready_i("ready_i", static_cast<std::size_t>(lines)),
      deadline_i("deadline_i", goes_by_deadlines(bus.arbitration) ? static_cast<std::size_t>(lines) : 0),
      grant_o("grant_o", static_cast<std::size_t>(lines)),
      bus_(bus),
      policy_(make_policy(bus.arbitration)),
      build_wait_(registers_, "build_wait", most_slots(lines)) {
    clocked_.evaluates(&BusArbiter::answer, {});
    for (std::size_t line = 0; line < pending_i.size(); ++line) {
        clocked_.evaluates_with({pending_i[line], ready_i[line]});
    }
    for (auto& deadline : deadline_i) {
        clocked_.evaluates_with({deadline});
    }
}

void BusArbiter::reset() {
    requests_.clear();
    policy_->start_frame({}, 0);
    registers_.reset();
    drive_slot();
}

void BusArbiter::clock_edge() {
    const bool decides = bus_.grant_cycles > 0 && !answer_stands();
    if (start_i.read()) {
        const FrontTable& table = table_i.read();
        requests_.assign(table.rows.size(), BusRequest{});
        policy_->start_frame(table.slots, table.rows.size());
        build_wait_.start(bus_.build_cycles(table.slots.size()));
    } else if (build_wait_.running()) {
        build_wait_.pass();
    } else if (!take_i.read() || (!decides && grant_.kind == BusGrant::Kind::kPoll)) {
        return;  // an answer that grants nothing changes nothing
    } else if (decides) {
        decide();
    } else {
        policy_->take(grant_);
        found_ = false;
    }
    clocked_.stay_awake();  // the policy has a state of its own
    drive_slot();
}

void BusArbiter::drive_slot() { slot_o.write(static_cast<std::uint16_t>(policy_->slot())); }

/// Called at an edge at which the bus waits for an answer.
void BusArbiter::decide() {
    if (found_) {
        search_wait_.pass();
    } else if (candidate_.kind != BusGrant::Kind::kPoll) {
        found_ = true;
        found_grant_ = candidate_;
        search_wait_.start(bus_.grant_cycles - 1);
    }
}

void BusArbiter::answer() {
    candidate_ = BusGrant{};
    if (!requests_.empty() && !build_wait_.running()) {
        for (std::size_t row = 0; row < requests_.size(); ++row) {
            requests_[row].pending = pending_i[row].read();
            requests_[row].ready = ready_i[row].read();
            if (deadline_i.size() > 0) {
                requests_[row].deadline = static_cast<std::int64_t>(deadline_i[row].read());
            }
        }
        candidate_ = policy_->grant(requests_);
    }
    grant_ = bus_.grant_cycles == 0 ? candidate_ : answer_stands() ? found_grant_ : BusGrant{};
    search_o.write(build_wait_.running() || (bus_.grant_cycles > 0 && !answer_stands() &&
                                             (found_ || candidate_.kind != BusGrant::Kind::kPoll)));
    const bool granted = grant_.kind == BusGrant::Kind::kBurst;
    drive_grant(granted ? grant_.row : kNoRow);
    grant_valid_o.write(granted);
    lost_o.write(grant_.kind == BusGrant::Kind::kLost);
    recovered_o.write(static_cast<std::uint16_t>(grant_.recovered_slots));
}

void BusArbiter::drive_grant(int row) {
    if (row == granted_row_) {
        return;
    }
    if (granted_row_ != kNoRow) {
        grant_o[static_cast<std::size_t>(granted_row_)].write(false);
    }
    if (row != kNoRow) {
        grant_o[static_cast<std::size_t>(row)].write(true);
    }
    granted_row_ = row;
}

void BusArbiter::trace(sc_core::sc_trace_file* file) const {
    for (std::size_t line = 0; line < pending_i.size(); ++line) {
        sc_core::sc_trace(file, pending_i[line].port(), path(numbered("pending", line).c_str()));
        sc_core::sc_trace(file, ready_i[line].port(), path(numbered("ready", line).c_str()));
        sc_core::sc_trace(file, grant_o[line].port(), path(numbered("grant", line).c_str()));
    }
    for (std::size_t line = 0; line < deadline_i.size(); ++line) {
        trace_number(file, deadline_i[line].read(), path(numbered("deadline", line).c_str()), kDeadlineBits);
    }
    sc_core::sc_trace(file, start_i.port(), path("start"));
    sc_core::sc_trace(file, take_i.port(), path("take"));
    sc_core::sc_trace(file, grant_valid_o.port(), path("grant_valid"));
    sc_core::sc_trace(file, search_o.port(), path("search"));
    registers_.trace(file, path(""));
    sc_core::sc_trace(file, lost_o.port(), path("lost"));
    const int slot_bits = bits_for(most_slots(static_cast<int>(pending_i.size())) - 1);
    sc_core::sc_trace(file, recovered_o.read(), path("recovered"), slot_bits);
    sc_core::sc_trace(file, slot_o.read(), path("slot"), slot_bits);
}

}  // namespace metabuffer::rtl
