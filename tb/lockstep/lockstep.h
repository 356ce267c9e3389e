#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <systemc>
#include <type_traits>
#include <utility>
#include <vector>

#include "lockstep/pin.h"
#include "rtl/block.h"
#include "rtl/gated_clock.h"
#include "rtl/wire.h"
#include "support/random_seed.h"
#include "support/trace_switch.h"

namespace metabuffer::test {

class LockstepBench;
class LockstepBlock;

/// Inputs that no protocol binds. Each changes at random. At the beginning of a pause one of them changes from clock to
/// clock, which a block must not take for one that stands, and the last time another one changes with it. Then they
/// stand, and now and then one changes alone, which must wake a block that sleeps.
class FreeWires {
  public:
    /// It changes once in so many clocks.
    void add(Input<bool>& wire, int clocks_to_change) { wires_.push_back({&wire, clocks_to_change}); }
    /// Call it from stimulate().
    void stimulate(LockstepBench& bench);

  private:
    struct Wire {
        Input<bool>* input;
        int clocks_to_change;
        void change() const { *input = !*input; }
    };
    const Wire& any(LockstepBench& bench) const;

    std::vector<Wire> wires_;
    bool paused_ = false;
    const Wire* restless_ = nullptr;
    int restless_clocks_ = 0;
};

/// Clock and reset of blocks that run in lockstep with their references. At each edge every output must have the value
/// that its reference gives it. The first edge at which one has not ends the run and fails the test: it prints the seed,
/// the clock, and every pin at the last edges.
///
///     LockstepBench bench(2203);
///     Handshake relay(bench, "relay", ...);  // a Lockstep, below
///     bench.run(3000, {{"a frame started", 20}});
///
/// Clock 0 is the first edge that samples reset low.
class LockstepBench final : public sc_core::sc_module {
  public:
    sc_core::sc_clock clk{"clk", sc_core::sc_time(10.0, sc_core::SC_NS)};
    rtl::GatedClock gated_clk{"gated_clk"};
    rtl::Wire<bool> reset{"reset", true};
    Random random;
    /// What the stimuli have brought about, counted by the references.
    std::map<std::string, std::int64_t> happened;
    /// Counted by the bench, at each edge: the methods on the gated clock that sleep.
    static constexpr const char* kAsleep = "a method slept";
    /// Once in so many clocks the blocks are reset, for two to four edges; 0: at the beginning only.
    int clocks_to_reset = 400;
    /// Once in so many clocks comes a pause, so long that a block which has nothing to do sleeps in it.
    int clocks_to_pause = 60;

    /// For stimuli at random: the test's own seed, see random_seed().
    explicit LockstepBench(std::uint64_t default_seed);
    /// For stimuli that are written down: no pauses, and one reset only, at the beginning.
    LockstepBench() : LockstepBench(0) { clocks_to_reset = clocks_to_pause = 0; }
    SC_HAS_PROCESS(LockstepBench);

    /// The coming edge samples reset high.
    bool in_reset() const { return reset_edges_ > 0; }
    /// The stimuli are to be at rest.
    bool pausing() const { return pause_ > 0; }
    int clock() const { return clock_; }

    /// Runs to the end of clock `clocks` - 1. least: what must have happened so often, or the stimulus is too tame.
    void run(int clocks, const std::map<std::string, std::int64_t>& least = {});
    /// The same, with a check after every so many clocks: of what an edge leaves in the blocks and no pin shows.
    void run(int clocks, int clocks_to_check, const std::function<void()>& check,
             const std::map<std::string, std::int64_t>& least);

  private:
    friend class LockstepBlock;
    void falling_edge();
    void rising_edge();

    std::uint64_t seed_;
    std::vector<LockstepBlock*> blocks_;
    std::unique_ptr<TraceSwitch> trace_;
    static constexpr int kFirstClock = -2;
    int clock_ = kFirstClock;  ///< the edge that comes next, or is executed
    int reset_edges_ = -kFirstClock;
    int pause_ = 0;
    std::deque<bool> resets_;  ///< as the last edges have sampled it
    std::string failure_;
};

/// What a bench does with each of its blocks at an edge.
class LockstepBlock {
  public:
    LockstepBlock(const LockstepBlock&) = delete;
    LockstepBlock& operator=(const LockstepBlock&) = delete;

    // A block's reference and stimulus. They are called in this order, with the inputs as they are then.

    /// Assigns the inputs that the coming edge samples. An input that is not assigned stands.
    virtual void stimulate() {}
    /// Assigns to each output what is due there as the coming edge samples it: from the reference's registers and, of
    /// a combinational output, from the inputs.
    virtual void expect() = 0;
    /// The edge, with reset low: the reference's registers change.
    virtual void edge() {}
    /// The edge, with reset high.
    virtual void reset() {}

  protected:
    /// Ends the run: something besides the pins is wrong, such as the reports that the block has raised.
    void fail(const std::string& what);

    explicit LockstepBlock(LockstepBench& bench) : bench_(bench) { bench.blocks_.push_back(this); }
    virtual ~LockstepBlock() = default;

    LockstepBench& bench_;
    std::vector<std::unique_ptr<LockstepPin>> pins_;

  private:
    friend class LockstepBench;
    virtual void trace(TraceSwitch& trace) const = 0;
    virtual const char* block_name() const = 0;
    virtual bool has_reset() const = 0;
    /// What is wrong, and the last edges at every pin, one line each.
    std::string picture(const std::string& what) const;
};

template <typename Dut, typename = void>
constexpr bool kHasClock = false;
template <typename Dut>
constexpr bool kHasClock<Dut, std::void_t<decltype(&Dut::clk_i)>> = true;
template <typename Dut, typename = void>
constexpr bool kHasReset = false;
template <typename Dut>
constexpr bool kHasReset<Dut, std::void_t<decltype(&Dut::reset_i)>> = true;

/// A block that is in lockstep with its reference, twice: once on a gated clock, once on the clock itself. Both get the same inputs.
/// A test derives a class from it that has the reference's registers, and as members the pins that it uses:
///
///     class Handshake final : public Lockstep<rtl::PipelineHandshake> {
///         ...
///         Input<bool>& running_ = in(&rtl::PipelineHandshake::running_i);
///         Output<bool>& start_ = out(&rtl::PipelineHandshake::start_o);
///     };
///
/// Every pin must be among them but clk_i and reset_i, or be bound by the factory. The outputs of a block without a reset
/// are judged from the first edge on, which samples inputs that are low or empty.
template <typename Dut>
class Lockstep : public LockstepBlock {
  public:
    /// Makes the block; it may bind pins that are no part of the test. gating: that of clocks besides clk_i.
    using Factory = std::function<std::unique_ptr<Dut>(const char* name, rtl::ClockGating gating)>;

    Lockstep(LockstepBench& bench, const std::string& name, const Factory& factory)
        : LockstepBlock(bench), name_(name) {
        duts_.push_back(factory(name.c_str(), rtl::ClockGating::kOn));
        duts_.push_back(factory((name + "_ungated").c_str(), rtl::ClockGating::kOff));
        for (const auto& dut : duts_) {
            if constexpr (kHasReset<Dut>) dut->reset_i(bench.reset);
        }
        if constexpr (kHasClock<Dut>) {
            duts_.front()->clk_i(bench.gated_clk);
            duts_.back()->clk_i(bench.clk);
        }
    }

    template <typename Port>
    Input<typename Port::data_type>& in(Port Dut::*port) {
        return in_part<typename Port::data_type>([port](Dut & dut) -> auto& { return dut.*port; });
    }
    template <typename Port>
    Output<typename Port::data_type>& out(Port Dut::*port) {
        return out_part<typename Port::data_type>([port](Dut & dut) -> auto& { return dut.*port; });
    }
    template <typename Ports, typename Value = typename Ports::element_type::data_type>
    Input<Value>& in(Ports Dut::*ports, std::size_t index) {
        return in_part<Value>([ ports, index ](Dut & dut) -> auto& { return (dut.*ports)[index]; });
    }
    template <typename Ports, typename Value = typename Ports::element_type::data_type>
    Output<Value>& out(Ports Dut::*ports, std::size_t index) {
        return out_part<Value>([ ports, index ](Dut & dut) -> auto& { return (dut.*ports)[index]; });
    }
    /// A pin of a part of the block, which a function finds: `in_part<int>([](Dut& dut) -> auto& { return ...; })`.
    template <typename Value, typename Port>
    Input<Value>& in_part(const Port& port) {
        return add_pin<Input<Value>>(port);
    }
    template <typename Value, typename Port>
    Output<Value>& out_part(const Port& port) {
        return add_pin<Output<Value>>(port);
    }

  protected:
    /// The one with clock gating.
    Dut& dut() { return *duts_.front(); }
    const Dut& dut() const { return *duts_.front(); }

  private:
    void trace(TraceSwitch& trace) const override { trace.add(dut()); }
    const char* block_name() const override { return name_.c_str(); }
    bool has_reset() const override { return kHasReset<Dut>; }

    template <typename Pin, typename Port>
    Pin& add_pin(const Port& port) {
        auto pin = std::make_unique<Pin>(static_cast<sc_core::sc_port_base&>(port(dut())).basename());
        for (const auto& dut : duts_) pin->bind(port(*dut));
        Pin& added = *pin;
        pins_.push_back(std::move(pin));
        return added;
    }

    std::string name_;
    std::vector<std::unique_ptr<Dut>> duts_;
};

}  // namespace metabuffer::test
