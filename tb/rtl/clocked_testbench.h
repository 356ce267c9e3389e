#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <systemc>
#include <utility>
#include <vector>

#include "rtl/block.h"
#include "rtl/gated_clock.h"
#include "support/trace_switch.h"

namespace metabuffer::test {

/// The values of one signal, clock by clock. Clock n is the n-th rising edge that sees reset low, from 0; the
/// edges in reset are -1, -2, ... For an input of the device under test at(n) is what edge n samples, for an
/// output it is what stands after edge n, until edge n + 1.
template <typename Value>
class Recording {
  public:
    const Value& at(int clock) const {
        const int index = clock - first_clock_;
        if (index < 0 || index >= static_cast<int>(values_.size())) {
            throw std::out_of_range("clock " + std::to_string(clock) + " was not recorded");
        }
        return values_[static_cast<std::size_t>(index)];
    }
    int first_clock() const { return first_clock_; }
    /// One past the last clock recorded.
    int end_clock() const { return first_clock_ + static_cast<int>(values_.size()); }

    /// The clocks, reset apart, at which the value meets a condition.
    std::vector<int> clocks_where(const std::function<bool(const Value&)>& condition) const {
        std::vector<int> clocks;
        for (int clock = 0; clock < end_clock(); ++clock) {
            if (condition(at(clock))) clocks.push_back(clock);
        }
        return clocks;
    }
    /// The clocks at which a wire is high.
    std::vector<int> high() const {
        return clocks_where([](const Value& value) { return static_cast<bool>(value); });
    }
    /// The clocks at which a wire is high and was low one clock earlier.
    std::vector<int> rises() const { return changes(true); }
    std::vector<int> falls() const { return changes(false); }

    void start_at(int first_clock) { first_clock_ = first_clock; }
    void push(const Value& value) { values_.push_back(value); }

  private:
    std::vector<int> changes(bool to) const {
        std::vector<int> clocks;
        for (int clock = 0; clock < end_clock(); ++clock) {
            if (static_cast<bool>(at(clock)) == to && static_cast<bool>(at(clock - 1)) != to) {
                clocks.push_back(clock);
            }
        }
        return clocks;
    }

    int first_clock_ = 0;
    std::deque<Value> values_;  // not a vector: one of bool has no elements to refer to
};

/// low, low + 1, ... high - 1.
inline std::vector<int> clock_range(int low, int high) {
    std::vector<int> clocks;
    for (int clock = low; clock < high; ++clock) clocks.push_back(clock);
    return clocks;
}

/// One clock of a testbench and its test driver. The driver works at the falling edge: it records what the
/// rising edge before it has left, then drives what the next one will sample.
class ClockDomain final : public sc_core::sc_module {
  public:
    sc_core::sc_clock clk;
    rtl::GatedClock gated_clk{"gated_clk"};

    ClockDomain(const sc_core::sc_module_name& name, std::int64_t period_picoseconds)
        : sc_core::sc_module(name),
          clk("clk", sc_core::sc_time(static_cast<double>(period_picoseconds), sc_core::SC_PS)),
          period_picoseconds_(period_picoseconds) {
        gated_clk.clk_i(clk);
        SC_METHOD(falling_edge);
        sensitive << clk.negedge_event();
        dont_initialize();
        SC_METHOD(rising_edge);
        sensitive << clk.posedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(ClockDomain);

    std::int64_t period_picoseconds() const { return period_picoseconds_; }
    /// The last rising edge whose outcome has been recorded.
    int clock() const { return clock_; }
    /// Rising edges in reset.
    int reset_clocks() const { return reset_clocks_; }

    /// Records a signal from reset on.
    template <typename Value>
    const Recording<Value>& record(const sc_core::sc_signal<Value>& signal) {
        auto recording = std::make_shared<Recording<Value>>();
        samplers_.push_back([recording, &signal] { recording->push(signal.read()); });
        starters_.push_back([recording](int first_clock) { recording->start_at(first_clock); });
        kept_.push_back(recording);
        return *recording;
    }

    /// Records what each edge samples, of a combinational wire too: at(n) is the value just before edge n.
    template <typename Value>
    const Recording<Value>& record_sampled(const sc_core::sc_signal<Value>& signal) {
        auto recording = std::make_shared<Recording<Value>>();
        edge_samplers_.push_back([recording, &signal] { recording->push(signal.read()); });
        starters_.push_back([recording](int first_clock) { recording->start_at(first_clock); });
        kept_.push_back(recording);
        return *recording;
    }

    /// Edge `clock` is the first to sample `value`.
    template <typename Value>
    void drive(sc_core::sc_signal<Value>& signal, int clock, const std::decay_t<Value>& value) {
        script_[clock].push_back([&signal, value] { signal.write(value); });
    }
    /// The wire is high at edge `clock` and at no other.
    void pulse(sc_core::sc_signal<bool>& signal, int clock) {
        drive(signal, clock, true);
        drive(signal, clock + 1, false);
    }

    /// Calls a driver before each edge with the edge's number, from 0. It reads the present values and writes those
    /// that the edge must sample.
    void each_clock(std::function<void(int)> driver) { drivers_.push_back(std::move(driver)); }

    /// The first `reset_clocks` edges are in reset.
    void set_reset_clocks(int reset_clocks) {
        reset_clocks_ = reset_clocks;
        clock_ = -reset_clocks - 1;
        for (const auto& start : starters_) start(-reset_clocks);
    }

  private:
    void rising_edge() {
        for (const auto& sample : edge_samplers_) sample();
    }
    void falling_edge() {
        ++clock_;
        for (const auto& sample : samplers_) sample();
        const int next = clock_ + 1;
        if (next < 0) return;
        if (const auto entry = script_.find(next); entry != script_.end()) {
            for (const auto& write : entry->second) write();
        }
        for (const auto& driver : drivers_) driver(next);
    }

    std::int64_t period_picoseconds_;
    int reset_clocks_ = 0;
    int clock_ = 0;
    std::vector<std::function<void()>> samplers_;
    std::vector<std::function<void()>> edge_samplers_;
    std::vector<std::function<void(int)>> starters_;
    std::vector<std::shared_ptr<void>> kept_;
    std::map<int, std::vector<std::function<void()>>> script_;
    std::vector<std::function<void(int)>> drivers_;
};

/// The receiver's clock at which its logic sees, behind two registers, a change by the sender's edge `clock`. The
/// receiver's first edge after that captures the change, and its next edge sees it.
inline int seen_at(const ClockDomain& sender, int clock, const ClockDomain& receiver) {
    const std::int64_t time = (clock + std::int64_t{sender.reset_clocks()}) * sender.period_picoseconds();
    const std::int64_t capturing_edge = time / receiver.period_picoseconds() + 1;
    return static_cast<int>(capturing_edge) - receiver.reset_clocks() + 1;
}

/// Clock, reset and waveform of a testbench: the devices under test are built around it, driven and recorded
/// through its clock domains, and the checks read the recordings.
///
///     ClockedTestbench bench;
///     sc_core::sc_signal<bool> request, answer;
///     Device device("device");
///     device.clk_i(bench.core.clk);
///     device.reset_i(bench.reset);
///     ...
///     const auto& answers = bench.core.record(answer);
///     bench.core.pulse(request, 16);
///     bench.run_through(20);
///     CHECK_FALSE(answers.at(16));
///     CHECK(answers.at(17));
class ClockedTestbench {
  public:
    static constexpr std::int64_t kCorePeriodPicoseconds = 10'000;

    sc_core::sc_signal<bool> reset{"reset", true};
    ClockDomain core;

    explicit ClockedTestbench(std::int64_t core_period_picoseconds = kCorePeriodPicoseconds)
        : core("core", core_period_picoseconds) {}

    /// A second clock. Its first rising edge is at time 0, like that of all clocks.
    ClockDomain& add_clock(const char* name, std::int64_t period_picoseconds) {
        others_.push_back(std::make_unique<ClockDomain>(name, period_picoseconds));
        return *others_.back();
    }

    /// With METABUFFER_TRACE set, the block's signals go into the test's waveform.
    void trace(const rtl::Block& block) { traced_.push_back(&block); }

    /// Runs until the outcome of core clock `clock` has been recorded.
    void run_through(int clock) {
        if (trace_ == nullptr) start();
        const std::int64_t edge = clock + std::int64_t{core.reset_clocks()};
        const std::int64_t wanted = edge * core.period_picoseconds() + core.period_picoseconds() / 2 + 1;
        const auto now = static_cast<std::int64_t>(sc_core::sc_time_stamp().value());
        if (wanted > now) {
            sc_core::sc_start(sc_core::sc_time(static_cast<double>(wanted - now), sc_core::SC_PS));
        }
    }

  private:
    static constexpr int kResetClocks = 2;

    /// Reset stays until every domain has seen it for some clocks, and falls between two core edges.
    void start() {
        std::int64_t slowest = core.period_picoseconds();
        for (const auto& domain : others_) slowest = std::max(slowest, domain->period_picoseconds());
        const auto clocks = static_cast<int>((kResetClocks * slowest + core.period_picoseconds() - 1) /
                                             core.period_picoseconds());
        const std::int64_t release = clocks * core.period_picoseconds() - core.period_picoseconds() / 2;
        core.set_reset_clocks(clocks);
        for (const auto& domain : others_) {
            domain->set_reset_clocks(static_cast<int>(release / domain->period_picoseconds()) + 1);
        }
        core.drive(reset, 0, false);
        // A port's signal can be followed once all ports are bound.
        sc_core::sc_start(sc_core::SC_ZERO_TIME);
        trace_ = std::make_unique<TraceSwitch>();
        trace_->add(core.clk, "core_clk");
        for (const auto& domain : others_) trace_->add(domain->clk, std::string(domain->name()) + "_clk");
        trace_->add(reset, "reset");
        for (const rtl::Block* block : traced_) trace_->add(*block);
    }

    std::vector<std::unique_ptr<ClockDomain>> others_;
    std::vector<const rtl::Block*> traced_;
    std::unique_ptr<TraceSwitch> trace_;
};

}  // namespace metabuffer::test
