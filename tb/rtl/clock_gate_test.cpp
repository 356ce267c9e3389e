#include "rtl/clock_gate.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "rtl/block.h"
#include "support/random_seed.h"

namespace metabuffer::test::clock_gate_test {
namespace {

using rtl::ClockGate;
using rtl::ClockGating;
using rtl::EdgeCounter;
using rtl::GatedClock;

/// Adds its input to its sum at each edge, and sleeps while there is nothing to add.
class Adder final : public rtl::Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};
    sc_core::sc_in<int> add_i{"add_i"};
    sc_core::sc_out<int> sum_o{"sum_o"};

    explicit Adder(const sc_core::sc_module_name& name, ClockGating gating = ClockGating::kOn)
        : Block(name), gate_(gating) {
        SC_METHOD(clock_edge);
        sensitive << clk_i.pos();
        dont_initialize();
    }
    SC_HAS_PROCESS(Adder);

    void trace(sc_core::sc_trace_file* file) const override { sc_core::sc_trace(file, sum_o, path("sum")); }
    bool sleeps() const override { return gate_.asleep(); }
    /// Edges at which it has run.
    int edges() const { return edges_; }
    /// Edges that have passed, by its counter.
    std::int64_t counted() const { return counted_; }

  private:
    void end_of_elaboration() override { gate_.attach(clk_i); }
    void clock_edge() {
        if (gate_.opened()) return;
        ++edges_;
        counted_ += counter_.count();
        const int add = add_i.read();
        sum_ += add;
        sum_o.write(sum_);
        if (gate_.idle_edge(add == 0)) {
            counter_.sleep();
            next_trigger(add_i.value_changed_event());
        }
    }

    ClockGate gate_;
    EdgeCounter counter_;
    int sum_ = 0;
    int edges_ = 0;
    std::int64_t counted_ = 0;
};

/// Counts the edges that a clock passes on.
class EdgeProbe final : public sc_core::sc_module {
  public:
    EdgeProbe(const sc_core::sc_module_name& name, const GatedClock& clock) : sc_core::sc_module(name) {
        SC_METHOD(edge);
        sensitive << clock.posedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(EdgeProbe);
    int edges() const { return edges_; }

  private:
    void edge() { ++edges_; }
    int edges_ = 0;
};

/// Two adders that share a gated clock, and for each a twin on the clock itself that never sleeps.
struct GateBench {
    static constexpr std::size_t kAdders = 2;
    ClockDomain& core;
    GatedClock gated;
    EdgeProbe probe;
    std::array<sc_core::sc_signal<int>, kAdders> add, sum, twin_sum;
    std::vector<std::unique_ptr<Adder>> adders, twins;
    std::vector<const Recording<int>*> sums, twin_sums;

    explicit GateBench(ClockedTestbench& bench)
        : core(bench.core), gated("gated_clock"), probe("probe", gated) {
        gated.clk_i(core.clk);
        for (std::size_t i = 0; i < kAdders; ++i) {
            adders.push_back(std::make_unique<Adder>(("adder_" + std::to_string(i)).c_str()));
            twins.push_back(
                std::make_unique<Adder>(("twin_" + std::to_string(i)).c_str(), ClockGating::kOff));
            adders[i]->clk_i(gated);
            twins[i]->clk_i(core.clk);
            adders[i]->add_i(add[i]);
            twins[i]->add_i(add[i]);
            adders[i]->sum_o(sum[i]);
            twins[i]->sum_o(twin_sum[i]);
            gated.add([this, i] { return adders[i]->sleeps(); });
            sums.push_back(&core.record(sum[i]));
            twin_sums.push_back(&core.record(twin_sum[i]));
            bench.trace(*adders[i]);
        }
    }
    /// Edge `clock` samples a number to add, and those after it 0.
    void give(std::size_t adder, int clock, int number) {
        core.drive(add[adder], clock, number);
        core.drive(add[adder], clock + 1, 0);
    }
    void check_sums(int clocks) const {
        for (std::size_t i = 0; i < kAdders; ++i) {
            for (int clock = 0; clock < clocks; ++clock) {
                INFO("adder " << i << ", clock " << clock);
                REQUIRE(sums[i]->at(clock) == twin_sums[i]->at(clock));
            }
        }
    }
};

TEST_CASE("clock gate: a method may sleep after a few idle edges in a row, and opens once") {
    const int edges = ClockGate::kIdleEdges;
    REQUIRE(edges > 1);
    ClockGate gate(ClockGating::kOn);
    for (int edge = 1; edge < edges; ++edge) CHECK_FALSE(gate.idle_edge(true));
    CHECK_FALSE(gate.idle_edge(false));  // they begin again
    for (int edge = 1; edge < edges; ++edge) CHECK_FALSE(gate.idle_edge(true));
    CHECK_FALSE(gate.asleep());
    CHECK_FALSE(gate.opened());
    CHECK(gate.idle_edge(true));
    CHECK_FALSE(gate.asleep());  // it is attached to no clock that could stand still
    CHECK(gate.opened());
    CHECK_FALSE(gate.opened());
    for (int edge = 1; edge < edges; ++edge) CHECK_FALSE(gate.idle_edge(true));
    CHECK(gate.idle_edge(true));
}

TEST_CASE("clock gate: with gating off a method never sleeps") {
    ClockGate gate(ClockGating::kOff);
    for (int edge = 0; edge < 100; ++edge) REQUIRE_FALSE(gate.idle_edge(true));
    CHECK_FALSE(gate.asleep());
}

TEST_CASE("edge counter: the edges that a method has slept through count when it runs again") {
    EdgeCounter counter;
    const auto run_to = [](int nanoseconds) {
        sc_core::sc_start(sc_core::sc_time(nanoseconds, sc_core::SC_NS) - sc_core::sc_time_stamp());
    };
    for (int edge = 0; edge < 5; ++edge) {
        if (edge > 0) run_to(10 * edge);
        CHECK(counter.count() == 1);
    }
    counter.sleep();
    run_to(110);
    CHECK(counter.count() == 7);  // 50, 60, ... 110
    run_to(120);
    CHECK(counter.count() == 1);
    counter.sleep();
    run_to(130);
    CHECK(counter.count() == 1);  // woken before the next edge
    counter.sleep();
    run_to(10'000);
    CHECK(counter.count() == 987);
}

TEST_CASE("gated clock: it stands still only while all of its blocks sleep") {
    ClockedTestbench bench;
    GateBench dut(bench);
    const int idle = ClockGate::kIdleEdges;
    bench.core.drive(dut.add[0], 0, 1);  // busy until edge 39
    bench.core.drive(dut.add[0], 40, 0);
    bench.run_through(39);
    const int busy = dut.probe.edges();
    CHECK(busy == bench.core.clock() + 1 + bench.core.reset_clocks());  // every edge, though one block sleeps
    CHECK(dut.adders[0]->edges() == busy);
    CHECK(dut.adders[1]->edges() == idle);
    bench.run_through(39 + idle);
    CHECK(dut.probe.edges() == busy + idle);
    bench.run_through(200);
    CHECK(dut.probe.edges() == busy + idle);
    CHECK(dut.adders[0]->edges() == busy + idle);
    dut.check_sums(200);
}

TEST_CASE("gated clock: it never stands still for a block that does not say that it sleeps") {
    class Plain final : public rtl::Block {
      public:
        explicit Plain(const sc_core::sc_module_name& name) : Block(name) {}
        void trace(sc_core::sc_trace_file* /*file*/) const override {}
    };
    ClockedTestbench bench;
    const Plain plain("plain");
    GatedClock gated("gated_clock"), link("gated_link_clock");
    const EdgeProbe probe("probe", gated), link_probe("link_probe", link);
    gated.clk_i(bench.core.clk);
    link.clk_i(bench.core.clk);
    gated.add([&plain] { return plain.sleeps(); });
    link.add([&plain] { return plain.link_sleeps(); });
    bench.run_through(40);
    CHECK(probe.edges() == 41 + bench.core.reset_clocks());
    CHECK(link_probe.edges() == probe.edges());
}

TEST_CASE("gated clock: an input between two edges starts it again, for the very next edge") {
    ClockedTestbench bench;
    GateBench dut(bench);
    dut.give(1, 100, 7);
    bench.run_through(99);
    const int stood_at = dut.probe.edges();
    bench.run_through(100);
    CHECK(dut.probe.edges() == stood_at + 1);
    CHECK(dut.adders[1]->edges() == ClockGate::kIdleEdges + 1);
    CHECK(dut.adders[0]->edges() == ClockGate::kIdleEdges);  // it sleeps on
    CHECK(dut.sums[1]->at(99) == 0);
    CHECK(dut.sums[1]->at(100) == 7);
    bench.run_through(200);
    dut.check_sums(200);
}

TEST_CASE("gated clock: a block that is woken before the clock has stopped misses no edge") {
    ClockedTestbench bench;
    GateBench dut(bench);
    // Pauses of all lengths around the one after which a block sleeps and the one after which the clock stands still.
    int clock = 0;
    for (int pause = 1; pause < 30; ++pause) {
        dut.give(static_cast<std::size_t>(pause % 2), clock, pause);
        clock += pause;
    }
    bench.run_through(clock + 20);
    dut.check_sums(clock + 20);
}

TEST_CASE(
    "gated clock: a block on it sees at an edge what one on the clock itself sees, before any signal "
    "changes") {
    ClockedTestbench bench;
    GateBench dut(bench);
    // The sums change at the very edges at which these add them up.
    Adder gated("follower", ClockGating::kOn), twin("follower_twin", ClockGating::kOff);
    sc_core::sc_signal<int> sum, twin_sum;
    gated.clk_i(dut.gated);
    twin.clk_i(bench.core.clk);
    gated.add_i(dut.twin_sum[0]);
    twin.add_i(dut.twin_sum[0]);
    gated.sum_o(sum);
    twin.sum_o(twin_sum);
    dut.gated.add([&gated] { return gated.sleeps(); });
    const auto& sums = bench.core.record(sum);
    const auto& twin_sums = bench.core.record(twin_sum);
    dut.give(0, 50, 3);
    dut.give(0, 60, -3);
    dut.give(0, 120, 5);
    bench.run_through(140);
    CHECK(sums.at(50) == 0);
    CHECK(sums.at(51) == 3);
    for (int clock = 0; clock < 140; ++clock) REQUIRE(sums.at(clock) == twin_sums.at(clock));
}

TEST_CASE("gated clock: it reads as the clock it is made of") {
    ClockedTestbench bench;
    GateBench dut(bench);
    bench.run_through(60);  // it stands still
    CHECK(dut.gated.read() == bench.core.clk.read());
    CHECK(&dut.gated.negedge_event() == &bench.core.clk.negedge_event());
    CHECK(&dut.gated.default_event() == &bench.core.clk.value_changed_event());
}

TEST_CASE("gated clock: at random its blocks and their counters agree with blocks that never sleep") {
    const auto seed = random_seed(2207);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    constexpr int kClocks = 4000;
    ClockedTestbench bench;
    GateBench dut(bench);
    for (std::size_t i = 0; i < GateBench::kAdders; ++i) {
        for (int clock = 0; clock < kClocks; clock += random.between(1, random.one_in(2) ? 3 : 40)) {
            dut.give(i, clock, random.between(1, 9));
        }
        dut.give(i, kClocks + 5, 1);  // both run at this edge
    }
    bench.run_through(kClocks + 5);
    dut.check_sums(kClocks + 6);
    for (std::size_t i = 0; i < GateBench::kAdders; ++i) {
        CHECK(dut.adders[i]->edges() < dut.twins[i]->edges());
        CHECK(dut.adders[i]->counted() == dut.twins[i]->edges());
    }
    CHECK(dut.probe.edges() < dut.twins[0]->edges());
}

}  // namespace
}  // namespace metabuffer::test::clock_gate_test
