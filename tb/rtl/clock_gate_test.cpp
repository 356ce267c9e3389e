#include "rtl/clock_gate.h"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "lockstep/lockstep.h"
#include "rtl/block.h"
#include "support/random_seed.h"

namespace metabuffer::test::clock_gate_test {
namespace {

using rtl::ClockGate;
using rtl::ClockGating;
using rtl::EdgeCounter;
using rtl::GatedClock;

TEST_CASE("clock gate: at random it sleeps after the last of its idle edges in a row and opens once") {
    constexpr int kIdleEdges = ClockGate::kIdleEdges;
    REQUIRE(kIdleEdges > 1);
    Random random(random_seed(2208));
    ClockGate gate(ClockGating::kOn), always(ClockGating::kOff);
    int idle_edges = 0, sleeps = 0;
    for (int edge = 0; edge < 5000; ++edge) {
        const bool idle = !random.one_in(12);
        idle_edges = idle ? idle_edges + 1 : 0;
        REQUIRE_FALSE(always.idle_edge(idle));
        REQUIRE_FALSE(gate.opened());
        REQUIRE(gate.idle_edge(idle) == (idle_edges == kIdleEdges));
        REQUIRE_FALSE(gate.asleep());  // it is attached to no clock that could stand still
        if (idle_edges < kIdleEdges) continue;
        idle_edges = 0;
        ++sleeps;
        REQUIRE(gate.opened());
    }
    CHECK(sleeps > 50);
}

/// Adds its input to its sum at each edge, and sleeps while there is nothing to add.
class Adder final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};
    sc_core::sc_in<int> add_i{"add_i"};
    sc_core::sc_out<int> sum_o{"sum_o"};

    Adder(const sc_core::sc_module_name& name, ClockGating gating) : sc_core::sc_module(name), gate_(gating) {
        SC_METHOD(clock_edge);
        sensitive << clk_i.pos();
        dont_initialize();
    }
    SC_HAS_PROCESS(Adder);

    bool sleeps() const { return gate_.asleep(); }
    int edges = 0;             ///< at which it has run
    std::int64_t counted = 0;  ///< those that have passed then, by its counter

  private:
    void end_of_elaboration() override { gate_.attach(clk_i); }
    void clock_edge() {
        if (gate_.opened()) return;
        ++edges;
        counted += counter_.count();
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
    int edges = 0;

  private:
    void edge() { ++edges; }
};

/// Two adders and a follower that share a gated clock. The follower adds what a third adder, on the clock itself, changes
/// at the very edge. Without gating all are on the clock itself and never sleep. Besides there are clocks of blocks that do
/// not say whether they sleep.
class Adders final : public rtl::Block {
  public:
    static constexpr std::size_t kAdders = 4;
    static constexpr std::size_t kFree = 2, kFollower = 3;
    sc_core::sc_in<bool> clk_i{"clk_i"};
    sc_core::sc_vector<sc_core::sc_in<int>> add_i{"add_i", kFollower};
    sc_core::sc_vector<sc_core::sc_out<int>> sum_o{"sum_o", kAdders};
    GatedClock gated{"gated_clock"}, silent{"silent_clock"}, silent_link{"silent_link_clock"};
    EdgeProbe probe{"probe", gated}, silent_probe{"silent_probe", silent},
        silent_link_probe{"link_probe", silent_link};
    std::vector<std::unique_ptr<Adder>> adders;

    Adders(const sc_core::sc_module_name& name, ClockGating gating) : Block(name) {
        for (GatedClock* const clock : {&gated, &silent, &silent_link}) clock->clk_i(clk_i);
        silent.add([this] { return Block::sleeps(); });
        silent_link.add([this] { return link_sleeps(); });
        for (std::size_t i = 0; i < kAdders; ++i) {
            const bool on_gated = i != kFree && gating == ClockGating::kOn;
            adders.push_back(std::make_unique<Adder>(("adder_" + std::to_string(i)).c_str(),
                                                     on_gated ? ClockGating::kOn : ClockGating::kOff));
            Adder& adder = *adders.back();
            adder.sum_o(sum_o[i]);
            i == kFollower ? adder.add_i(sum_o[kFree]) : adder.add_i(add_i[i]);
            on_gated ? adder.clk_i(gated) : adder.clk_i(clk_i);
            if (on_gated) gated.add([&adder] { return adder.sleeps(); });
        }
    }

    void trace(sc_core::sc_trace_file* file) const override {
        for (std::size_t i = 0; i < kAdders; ++i) sc_core::sc_trace(file, sum_o[i], sum_o[i].name());
    }
};

class Reference final : public Lockstep<Adders> {
  public:
    explicit Reference(LockstepBench& bench)
        : Lockstep(bench, "adders", [](const char* dut, ClockGating gating) {
              return std::make_unique<Adders>(dut, gating);
          }) {
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
    }
    void expect() override {
        CHECK(dut().gated.read() == bench_.clk.read());
        for (std::size_t i = 0; i < sums_.size(); ++i) *sums_[i] = sums_due_[i];
    }
    void edge() override {
        ++edges_;
        const std::array<int, Adders::kAdders> add{*adds_[0], *adds_[1], *adds_[2], sums_due_[Adders::kFree]};
        bool passes = false;
        for (std::size_t i = 0; i < add.size(); ++i) {
            Run& run = runs_[i];
            if (run.asleep && add[i] == 0) continue;
            if (i != Adders::kFree) passes = true;
            ++run.edges;
            run.counted = edges_;
            run.idle_edges = add[i] == 0 ? run.idle_edges + 1 : 0;
            run.asleep = i != Adders::kFree && run.idle_edges == ClockGate::kIdleEdges;
            sums_due_[i] += add[i];
        }
        passed_ += passes ? 1 : 0;
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
        for (std::size_t i = 0; i < runs_.size(); ++i) {
            INFO("adder " << i << ", clock " << bench_.clock());
            CHECK(blocks.adders[i]->edges == runs_[i].edges);
            CHECK(blocks.adders[i]->counted == runs_[i].counted);
        }
        CHECK(blocks.probe.edges == passed_);
        CHECK(blocks.silent_probe.edges == edges_);
        CHECK(blocks.silent_link_probe.edges == edges_);
        CHECK(blocks.gated.read() == bench_.clk.read());
        CHECK(&blocks.gated.negedge_event() == &bench_.clk.negedge_event());
        CHECK(&blocks.gated.default_event() == &bench_.clk.value_changed_event());
    }

    std::vector<Input<int>*> adds_;
    std::vector<Output<int>*> sums_;
    std::array<int, Adders::kAdders> sums_due_{};
    std::array<Run, Adders::kAdders> runs_;
    int edges_ = 0, passed_ = 0;
};

TEST_CASE("gated clock: in lockstep with its reference it stands still only while all of its blocks sleep") {
    LockstepBench bench(2207);
    const Reference adders(bench);
    bench.clocks_to_pause = 30;
    bench.run(10'000, {{"the clock stood still", 500}});
}

}  // namespace
}  // namespace metabuffer::test::clock_gate_test
