#include "rtl/gated_clock.h"

#include "rtl/clocked.h"
#include "rtl/spawn_method.h"

namespace metabuffer::rtl {

void RisingClock::start_of_simulation() {
    spawn_method([this] { tick(); }, {&m_next_posedge_event, &risen_, &m_next_negedge_event});
    m_next_posedge_event.notify(sc_core::SC_ZERO_TIME);
}

void RisingClock::tick() {
    if (risen_.triggered()) {
        call_blocks();
    } else if (stopped_) {
        return;
    } else if (m_next_negedge_event.triggered()) {
        m_new_val = false;
        request_update();
    } else {
        rise();
    }
}

void RisingClock::rise() {
    m_next_posedge_event.notify(period());
    falls_ = falls_ || m_change_event_p != nullptr || m_negedge_event_p != nullptr;
    if (falls_) m_next_negedge_event.notify(m_negedge_time);
    m_new_val = true;
    if (!is_heard() && !sc_core::sc_pending_activity_at_current_time()) {
        m_cur_val = true;
        call_blocks();
        return;
    }
    m_cur_val = false;  // it may not have fallen since it rose
    request_update();
    if (!gated_.empty()) risen_.notify(sc_core::SC_ZERO_TIME);
}

void RisingClock::call_blocks() {
    for (GatedClock* const gated : gated_) gated->clock_edge();
}

GatedClock::GatedClock(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
    SC_METHOD(evaluate);
    sensitive << settles_;
    dont_initialize();
}

void GatedClock::end_of_elaboration() {
    auto& clock = dynamic_cast<sc_core::sc_clock&>(*clk_i.get_interface());
    period_picoseconds_ = static_cast<std::int64_t>(clock.period().value());
    if (auto* const rising = dynamic_cast<RisingClock*>(&clock)) {
        rising->drives(*this);
    } else {
        spawn_method([this] { clock_edge(); }, {&clk_i->posedge_event()});
    }
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
    if (has_listeners_) posedge_.notify();
}

}  // namespace metabuffer::rtl
