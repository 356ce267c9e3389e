#include "rtl/clocked.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "lockstep/lockstep.h"
#include "rtl/block.h"
#include "rtl/gated_clock.h"
#include "rtl/spawn_method.h"

namespace metabuffer::test::clocked_test {
namespace {

using rtl::Clocked;
using rtl::ClockGating;
using rtl::GatedClock;

/// Adds its inputs to its sum at each edge, and sleeps while there is nothing to add.
class Adder final : public rtl::Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};
    sc_core::sc_in<int> add_i{"add_i"};
    sc_core::sc_in<int> event_add_i{"event_add_i"};  ///< no Wire: only an event tells of a change
    sc_core::sc_in<int> unread_i{"unread_i"};
    sc_core::sc_out<int> sum_o{"sum_o"};

    explicit Adder(const sc_core::sc_module_name& name) : Block(name) {
        clocked_.reads({add_i, event_add_i});
    }

    void trace(sc_core::sc_trace_file* /*file*/) const override {}
    int edges = 0;             ///< at which it has run
    std::int64_t counted = 0;  ///< those that have passed then
    std::int64_t passed() const { return counted + clocked_.edges_asleep(); }

  private:
    void clock_edge() {
        ++edges;
        counted += 1 + clocked_.slept_edges();
        const int add = add_i.read() + event_add_i.read();
        if (add_i.read() == 0 && event_add_i.read() == 0) return;
        sum_ += add;
        sum_o.write(sum_);
        clocked_.stay_awake();
    }

    int sum_ = 0;
    Clocked clocked_{*this, clk_i, &Adder::clock_edge};
};

/// Two adders and a follower that share a gated clock. The follower adds what a third adder, on the clock itself, changes
/// at the very edge. Without gating all are on the clock itself and never sleep.
class Adders final : public rtl::Block {
  public:
    static constexpr std::size_t kAdders = 4;
    static constexpr std::size_t kFree = 2, kFollower = 3;
    sc_core::sc_in<bool> clk_i{"clk_i"};
    sc_core::sc_vector<sc_core::sc_in<int>> add_i{"add_i", kFollower};
    sc_core::sc_vector<sc_core::sc_in<int>> event_add_i{"event_add_i", kAdders};
    sc_core::sc_vector<sc_core::sc_out<int>> sum_o{"sum_o", kAdders};
    sc_core::sc_signal<int> restless{"restless"};  ///< changes at each edge, and wakes nobody
    GatedClock gated{"gated_clock"};
    std::vector<std::unique_ptr<Adder>> adders;

    Adders(const sc_core::sc_module_name& name, sc_core::sc_clock& clock, ClockGating gating) : Block(name) {
        gated.clk_i(clock);
        for (std::size_t i = 0; i < kAdders; ++i) {
            adders.push_back(std::make_unique<Adder>(("adder_" + std::to_string(i)).c_str()));
            Adder& adder = *adders.back();
            adder.sum_o(sum_o[i]);
            adder.event_add_i(event_add_i[i]);
            adder.unread_i(restless);
            i == kFollower ? adder.add_i(sum_o[kFree]) : adder.add_i(add_i[i]);
            i != kFree&& gating == ClockGating::kOn ? adder.clk_i(gated) : adder.clk_i(clock);
        }
    }

    void trace(sc_core::sc_trace_file* file) const override {
        for (std::size_t i = 0; i < kAdders; ++i) sc_core::sc_trace(file, sum_o[i], sum_o[i].name());
    }
};

using Signals = sc_core::sc_vector<sc_core::sc_signal<int>>;

class Reference final : public Lockstep<Adders> {
  public:
    Reference(LockstepBench& bench, Signals& event_adds)
        : Lockstep(bench, "adders",
                   [&](const char* dut, ClockGating gating) {
                       auto adders = std::make_unique<Adders>(dut, bench.clk, gating);
                       adders->event_add_i(event_adds);
                       return adders;
                   }),
          event_adds_(event_adds) {
        for (std::size_t i = 0; i < Adders::kFollower; ++i) adds_.push_back(&in(&Adders::add_i, i));
        for (std::size_t i = 0; i < Adders::kAdders; ++i) sums_.push_back(&out(&Adders::sum_o, i));
    }

    void stimulate() override {
        check_clocks();
        Random& random = bench_.random;
        for (std::size_t i = 0; i < adds_.size(); ++i) {
            const bool comes = random.one_in(bench_.pausing() ? 40 : 6);
            *adds_[i] = comes ? random.between(1, 9) : 0;
            // What the follower adds is often nothing again.
            if (i == Adders::kFree && sums_due_[i] != 0) *adds_[i] = random.one_in(2) ? -sums_due_[i] : 0;
        }
        for (std::size_t i = 0; i < event_adds_.size(); ++i) {
            const bool comes = i != Adders::kFree && random.one_in(bench_.pausing() ? 40 : 9);
            event_adds_[i].write(comes ? 1 : 0);
        }
    }
    void expect() override {
        dut().restless.write(bench_.clock());
        for (std::size_t i = 0; i < sums_.size(); ++i) *sums_[i] = sums_due_[i];
    }
    void edge() override {
        ++edges_;
        std::array<int, Adders::kAdders> add{*adds_[0], *adds_[1], *adds_[2], sums_due_[Adders::kFree]};
        for (std::size_t i = 0; i < add.size(); ++i) add[i] += event_adds_[i].read();
        bool passes = false;
        for (std::size_t i = 0; i < add.size(); ++i) {
            Run& run = runs_[i];
            if (run.asleep && add[i] == 0) continue;
            if (i != Adders::kFree) passes = true;
            ++run.edges;
            run.counted = edges_;
            run.idle_edges = add[i] == 0 ? run.idle_edges + 1 : 0;
            run.asleep = i != Adders::kFree && run.idle_edges == Clocked::kIdleEdges;
            sums_due_[i] += add[i];
        }
        stood_still_ = !passes;
        bench_.happened["the clock stood still"] += passes ? 0 : 1;
    }
    void reset() override { edge(); }

  private:
    /// What each adder has done, with gating on.
    struct Run {
        int edges = 0, counted = 0, idle_edges = 0;
        bool asleep = false;
    };
    void check_clocks() const {
        const Adders& blocks = dut();
        std::size_t asleep = 0;
        for (std::size_t i = 0; i < runs_.size(); ++i) {
            INFO("adder " << i << ", clock " << bench_.clock());
            CHECK(blocks.adders[i]->edges == runs_[i].edges);
            CHECK(blocks.adders[i]->counted == runs_[i].counted);
            CHECK(blocks.adders[i]->passed() == edges_);
            // The free adder wakes the follower at the very edge.
            asleep += runs_[i].asleep && !(i == Adders::kFollower && sums_due_[Adders::kFree] != 0) ? 1 : 0;
        }
        CHECK(blocks.gated.sleepers() == asleep);
        if (stood_still_ && sums_due_[Adders::kFree] == 0) CHECK(blocks.gated.stands_still());
        CHECK(blocks.gated.read() == bench_.clk.read());
        CHECK(&blocks.gated.negedge_event() == &bench_.clk.negedge_event());
        CHECK(&blocks.gated.default_event() == &bench_.clk.value_changed_event());
    }

    std::vector<Input<int>*> adds_;
    Signals& event_adds_;
    std::vector<Output<int>*> sums_;
    std::array<int, Adders::kAdders> sums_due_{};
    std::array<Run, Adders::kAdders> runs_;
    int edges_ = 0;
    bool stood_still_ = false;
};

TEST_CASE("gated clock: in lockstep with its reference it stands still only while all of its blocks sleep") {
    LockstepBench bench(2207);
    Signals event_adds("event_adds", Adders::kAdders);
    const Reference adders(bench, event_adds);
    bench.clocks_to_pause = 30;
    bench.run(10'000, {{"the clock stood still", 500}});
}

TEST_CASE("rising clock: it falls from the next rise on that comes after somebody waits for a fall") {
    rtl::RisingClock clock("clock", sc_core::sc_time(10.0, sc_core::SC_NS));
    std::vector<double> rises, falls;
    const auto note = [&](std::vector<double>& at, const sc_core::sc_event& edge) {
        const auto add = [&clock, &rises, &at] {
            at.push_back(sc_core::sc_time_stamp() / sc_core::sc_time(1.0, sc_core::SC_NS));
            CHECK(clock.posedge() == (&at == &rises));
        };
        rtl::spawn_method(add, {&edge});
    };
    note(rises, clock.posedge_event());
    sc_core::sc_start(22.0, sc_core::SC_NS);
    note(falls, clock.negedge_event());
    sc_core::sc_start(25.0, sc_core::SC_NS);
    CHECK(rises == std::vector<double>{0.0, 10.0, 20.0, 30.0, 40.0});
    CHECK(falls == std::vector<double>{35.0, 45.0});
}

TEST_CASE("rising clock: an edge sees what changes at the very time of the clock's rise") {
    const sc_core::sc_time period(10.0, sc_core::SC_NS);
    rtl::RisingClock clock("clock", period);
    GatedClock gated("gated_clock");
    gated.clk_i(clock);
    rtl::Wire<int> add("add"), sum("sum"), nothing("nothing");
    Adder adder("adder");
    adder.clk_i(gated);
    adder.add_i(add);
    adder.event_add_i(nothing);
    adder.unread_i(nothing);
    adder.sum_o(sum);
    sc_core::sc_event changes;
    rtl::spawn_method([&] { add.write(add.read() + 1); }, {&changes});
    // The edges at 0 and 20 have their times for themselves.
    for (const double at : {10.0, 30.0, 40.0}) {
        changes.notify(sc_core::sc_time(at, sc_core::SC_NS) - sc_core::sc_time_stamp());
        sc_core::sc_start(sc_core::sc_time(at + 1.0, sc_core::SC_NS) - sc_core::sc_time_stamp());
    }
    CHECK(adder.edges == 5);
    CHECK(sum.read() == 0 + 1 + 1 + 2 + 3);
}

TEST_CASE("rising clock: a process on the gated clock finds it at its edge") {
    rtl::RisingClock clock("clock", sc_core::sc_time(10.0, sc_core::SC_NS));
    GatedClock gated("gated_clock");
    gated.clk_i(clock);
    int rises = 0;
    rtl::spawn_method([&] { rises += gated.posedge() && gated.event() ? 1 : 0; }, {&gated.posedge_event()});
    sc_core::sc_start(21.0, sc_core::SC_NS);
    CHECK(rises == 3);
}

TEST_CASE("wire: a process that waits for an edge of it runs at each") {
    rtl::Wire<bool> wire("wire", false);
    int rises = 0, falls = 0;
    rtl::spawn_method([&rises] { ++rises; }, {&wire.posedge_event()});
    rtl::spawn_method([&falls] { ++falls; }, {&wire.negedge_event()});
    for (const bool value : {true, true, false, true}) {
        wire.write(value);
        sc_core::sc_start(1.0, sc_core::SC_NS);
    }
    CHECK(rises == 2);
    CHECK(falls == 1);
}

}  // namespace
}  // namespace metabuffer::test::clocked_test
