#include "rtl/gated_clock.h"

#include "rtl/clocked.h"
#include "rtl/spawn_method.h"

namespace metabuffer::rtl {

void RisingClock::start_of_simulation() {
    spawn_method([this] { tick(); }, {&m_next_posedge_event, &m_next_negedge_event});
    m_next_posedge_event.notify(sc_core::SC_ZERO_TIME);
}

void RisingClock::tick() {
    if (stopped_) return;
    const bool falls = m_next_negedge_event.triggered();
    m_cur_val = falls;  // without a fall in between it is low all the same when it rises again
    m_new_val = !falls;
    request_update();
    if (falls) return;
    m_next_posedge_event.notify(period());
    falls_ = falls_ || m_change_event_p != nullptr || m_negedge_event_p != nullptr;
    if (falls_) m_next_negedge_event.notify(m_negedge_time);
}

GatedClock::GatedClock(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
    SC_METHOD(evaluate);
    sensitive << settles_;
    dont_initialize();
}

void GatedClock::end_of_elaboration() {
    const auto& clock = dynamic_cast<const sc_core::sc_clock&>(*clk_i.get_interface());
    period_picoseconds_ = static_cast<std::int64_t>(clock.period().value());
}

std::int64_t GatedClock::edge() const {
    return static_cast<std::int64_t>(sc_core::sc_time_stamp().value()) / period_picoseconds_;
}

void GatedClock::add(const EdgeCall& call) { calls_.push_back(call); }

void GatedClock::start_of_simulation() {
    awake_.resize((calls_.size() + kWordBits - 1) / kWordBits);
    for (EdgeCall& call : calls_) {
        call.clocked->call_ = &call;
        wake(call);
    }
}

void GatedClock::wake(const EdgeCall& call) {
    const auto index = static_cast<std::size_t>(&call - calls_.data());
    awake_[index / kWordBits] |= std::uint64_t{1} << index % kWordBits;
    ++awake_methods_;
    if (stands_still_) {
        start_again_.notify(sc_core::SC_ZERO_TIME);
    }
}

void GatedClock::settle(Clocked& method) {
    if (settling_.empty()) settles_.notify(sc_core::SC_ZERO_TIME);
    settling_.push_back(&method);
}

/// One process for all, since starting one takes as long as what a small block does.
void GatedClock::evaluate() {
    for (Clocked* const method : settling_) method->evaluate();
    settling_.clear();
}

void GatedClock::clock_edge() {
    if (stands_still_) {
        stands_still_ = false;  // called between two edges
        return;
    }
    EdgeCall* calls = calls_.data();
    for (std::uint64_t& word : awake_) {
        for (std::uint64_t left = word; left != 0; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            if (!calls[bit].execute()) {
                word &= ~(std::uint64_t{1} << bit);
                --awake_methods_;
            }
        }
        calls += kWordBits;
    }
    if (has_listeners_) {
        posedge_.notify();
    } else if (awake_methods_ == 0) {
        stands_still_ = true;
        next_trigger(start_again_);
    }
}

}  // namespace metabuffer::rtl
