#include "lockstep/lockstep.h"

#include <catch2/catch.hpp>
#include <iomanip>
#include <sstream>

namespace metabuffer::test {

void FreeWires::stimulate(LockstepBench& bench) {
    constexpr int kIdleEdges = rtl::Clocked::kIdleEdges;
    constexpr int kClocksToLoneChange = 12;
    const bool begins = bench.pausing() && !paused_;
    paused_ = bench.pausing();
    if (!paused_) {
        for (const Wire& wire : wires_) {
            if (bench.random.one_in(wire.clocks_to_change)) wire.change();
        }
        return;
    }
    if (begins) {
        restless_ = &any(bench);
        // Often it comes to rest at the very edge at which a block that takes it for one that stands would sleep.
        restless_clocks_ = bench.random.one_in(2) ? kIdleEdges : bench.random.between(0, 2 * kIdleEdges);
    }
    if (restless_clocks_ > 0) {
        restless_->change();
        if (--restless_clocks_ == 0) any(bench).change();
    } else if (bench.random.one_in(kClocksToLoneChange)) {
        any(bench).change();
    }
}

const FreeWires::Wire& FreeWires::any(LockstepBench& bench) const {
    return wires_[static_cast<std::size_t>(bench.random.between(0, static_cast<int>(wires_.size()) - 1))];
}

LockstepBench::LockstepBench(std::uint64_t default_seed)
    : sc_core::sc_module(sc_core::sc_module_name("lockstep")),
      random(random_seed(default_seed)),
      seed_(random_seed(default_seed)) {
    gated_clk.clk_i(clk);
    SC_METHOD(falling_edge);
    sensitive << clk.negedge_event();
    dont_initialize();
    SC_METHOD(rising_edge);
    sensitive << clk.posedge_event();
    dont_initialize();
}

void LockstepBench::run(int clocks, const std::map<std::string, std::int64_t>& least) {
    if (trace_ == nullptr) {
        sc_core::sc_start(sc_core::SC_ZERO_TIME);  // a port's signal can be traced once all ports are bound
        trace_ = std::make_unique<TraceSwitch>();
        trace_->add(clk, "clk");
        trace_->add(reset, "reset");
        for (const LockstepBlock* block : blocks_) block->trace(*trace_);
    }
    // To a quarter of a clock behind the last edge.
    const sc_core::sc_time end = (clocks - 1 - kFirstClock + 0.25) * clk.period();
    if (end > sc_core::sc_time_stamp()) sc_core::sc_start(end - sc_core::sc_time_stamp());
    INFO("METABUFFER_SEED=" << seed_);
    if (!failure_.empty()) FAIL(failure_);
    SUCCEED();
    for (const auto& [what, times] : least) {
        INFO(what);
        CHECK(happened[what] >= times);
    }
}

void LockstepBench::run(int clocks, int clocks_to_check, const std::function<void()>& check,
                        const std::map<std::string, std::int64_t>& least) {
    for (int checked = clocks_to_check; checked < clocks; checked += clocks_to_check) {
        run(checked);
        check();
    }
    run(clocks, least);
}

/// Half a clock before an edge: what it samples is driven.
void LockstepBench::falling_edge() {
    constexpr int kShortestPause = 10;
    constexpr int kLongestPause = 60;
    ++clock_;
    if (pause_ > 0) {
        --pause_;
    } else if (clocks_to_pause > 0 && random.one_in(clocks_to_pause)) {
        pause_ = random.between(kShortestPause, kLongestPause);
    }
    if (reset_edges_ > 0) {
        --reset_edges_;
    } else if (clocks_to_reset > 0 && random.one_in(clocks_to_reset)) {
        reset_edges_ = random.between(2, 4);
    }
    reset.write(in_reset());
    for (LockstepBlock* block : blocks_) {
        block->stimulate();
        for (const auto& pin : block->pins_) pin->drive();
    }
}

void LockstepBench::rising_edge() {
    happened[kAsleep] += static_cast<std::int64_t>(gated_clk.sleepers());
    resets_.push_back(in_reset());
    if (resets_.size() > LockstepPin::kEdgesShown) resets_.pop_front();
    for (LockstepBlock* block : blocks_) {
        block->expect();
        const LockstepPin* wrong = nullptr;
        for (const auto& pin : block->pins_) {
            if (!pin->sample() && wrong == nullptr) wrong = pin.get();
        }
        // What stands before the first edge in reset has no meaning.
        const bool judged = clock_ > kFirstClock || !block->has_reset();
        if (wrong != nullptr && judged) block->fail(wrong->name() + " is wrong");
        if (in_reset()) {
            block->reset();
        } else {
            block->edge();
        }
    }
    if (!failure_.empty()) sc_core::sc_stop();
}

void LockstepBlock::fail(const std::string& what) {
    if (bench_.failure_.empty()) bench_.failure_ = picture(what);
}

std::string LockstepBlock::picture(const std::string& what) const {
    constexpr int kNameWidth = 24;
    std::ostringstream text;
    text << block_name() << ": " << what << " at clock " << bench_.clock_ << '\n' << std::left;
    text << std::setw(kNameWidth) << "from clock"
         << bench_.clock_ + 1 - static_cast<int>(bench_.resets_.size()) << '\n';
    text << std::setw(kNameWidth) << "reset_i" << LockstepPin::edges(bench_.resets_) << '\n';
    for (const auto& pin : pins_) text << std::setw(kNameWidth) << pin->name() << pin->picture() << '\n';
    return text.str();
}

}  // namespace metabuffer::test
