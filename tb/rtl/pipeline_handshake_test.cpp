#include "rtl/pipeline_handshake.h"

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "clocked_testbench.h"
#include "lockstep/lockstep.h"
#include "support/random_seed.h"

namespace metabuffer::test::pipeline_handshake_test {
namespace {

using rtl::PipelineHandshake;

enum class Strap : std::uint8_t { kRelay, kMaster };
enum class Mode : std::uint8_t { kGlitch, kStall };
using Clocks = std::vector<int>;

/// A composer's handshakes between the one above, the one below and the composer's own parts, all played by the test.
struct HandshakeBench {
    ClockDomain& core;
    sc_core::sc_signal<bool> pipemaster, column_stall, startframe_in, startframe_out, below, above, fetched,
        running, start;
    PipelineHandshake dut;
    const Recording<bool>& startframes;  ///< what stands after each edge
    const Recording<bool>& pipereadies;
    const Recording<bool>& aboves;  ///< PIPEREADY as each edge samples it
    const Recording<bool>& starts;  ///< the same of start_o

    explicit HandshakeBench(ClockedTestbench& bench, Strap strap = Strap::kRelay, Mode mode = Mode::kGlitch,
                            const std::string& name = "pipeline_handshake")
        : core(bench.core),
          pipemaster((name + "_pipemaster").c_str(), strap == Strap::kMaster),
          dut(name.c_str(), mode == Mode::kStall),
          startframes(core.record(startframe_out)),
          pipereadies(core.record(above)),
          aboves(core.record_sampled(above)),
          starts(core.record_sampled(start)) {
        dut.clk_i(core.clk);
        dut.reset_i(bench.reset);
        dut.pipemaster_i(pipemaster);
        dut.column_stall_i(column_stall);
        dut.startframe_i(startframe_in);
        dut.startframe_o(startframe_out);
        dut.pipeready_i(below);
        dut.pipeready_o(above);
        dut.fetched_i(fetched);
        dut.running_i(running);
        dut.start_o(start);
        bench.trace(dut);
    }
    /// Edges first, first + 1, ... last sample the wire high.
    void hold(sc_core::sc_signal<bool>& wire, int first, int last) {
        core.drive(wire, first, true);
        core.drive(wire, last + 1, false);
    }
};

TEST_CASE("pipeline handshake: PIPEREADY rises after the edge that sees PIPEREADY from below") {
    ClockedTestbench bench;
    HandshakeBench dut(bench);
    bench.core.drive(dut.fetched, 2, true);
    bench.core.drive(dut.below, 20, true);  // after a pause in which the block sleeps
    bench.run_through(24);
    CHECK(dut.pipereadies.rises() == Clocks{20});
    CHECK(dut.aboves.rises() == Clocks{21});
    CHECK(dut.starts.high().empty());
    CHECK(dut.startframes.high().empty());
}

TEST_CASE(
    "pipeline handshake: with PIPEREADY from below, PIPEREADY follows a fetched frame in the same clock") {
    ClockedTestbench bench;
    HandshakeBench dut(bench);
    bench.core.drive(dut.below, 3, true);
    bench.core.drive(dut.fetched, 30, true);
    bench.run_through(34);
    CHECK(dut.aboves.rises() == Clocks{30});
}

TEST_CASE("pipeline handshake: PIPEREADY is not taken back before STARTFRAME, whatever falls") {
    ClockedTestbench bench;
    HandshakeBench dut(bench);
    dut.hold(dut.below, 3, 5);
    dut.hold(dut.fetched, 3, 8);
    bench.core.pulse(dut.startframe_in, 40);
    bench.run_through(50);
    CHECK(dut.pipereadies.high() == clock_range(3, 40));
}

TEST_CASE(
    "pipeline handshake: neither a fetched frame alone nor PIPEREADY from below alone raises PIPEREADY") {
    ClockedTestbench bench;
    HandshakeBench dut(bench);
    dut.hold(dut.fetched, 3, 5);
    dut.hold(dut.below, 6, 8);  // edge 8 has seen it when a frame is fetched again, too late
    dut.hold(dut.fetched, 10, 12);
    bench.run_through(20);
    CHECK(dut.pipereadies.high().empty());
    CHECK(dut.aboves.high().empty());
}

TEST_CASE("pipeline handshake: STARTFRAME starts a frame in its own clock and is relayed a clock later") {
    ClockedTestbench bench;
    HandshakeBench dut(bench);
    dut.hold(dut.below, 3, 20);
    dut.hold(dut.fetched, 3, 20);
    bench.core.pulse(dut.startframe_in, 20);
    dut.hold(dut.running, 21, 30);
    bench.run_through(40);
    CHECK(dut.starts.high() == Clocks{20});
    CHECK(dut.startframes.high() == Clocks{20});  // the composer below samples it at edge 21
    CHECK(dut.pipereadies.falls() == Clocks{20});
}

TEST_CASE("pipeline handshake: the PIPEMASTER answers its own PIPEREADY with STARTFRAME, a clock later") {
    ClockedTestbench bench;
    HandshakeBench dut(bench, Strap::kMaster);
    dut.hold(dut.below, 10, 14);
    bench.core.drive(dut.fetched, 3, true);
    bench.core.pulse(dut.startframe_in, 5);  // it has nobody above
    dut.hold(dut.running, 12, 30);
    bench.run_through(40);
    CHECK(dut.pipereadies.high() == Clocks{10});
    CHECK(dut.starts.high() == Clocks{11});
    CHECK(dut.startframes.high() == Clocks{11});
}

TEST_CASE("pipeline handshake: PIPEREADY of the frame just ended is not taken for the next one's") {
    ClockedTestbench bench;
    HandshakeBench dut(bench);
    bench.core.drive(dut.fetched, 2, true);
    bench.core.pulse(dut.startframe_in, 10);
    dut.hold(dut.running, 11, 20);
    dut.hold(dut.below, 15, 20);  // the frame's last edge still sees it
    dut.hold(dut.below, 30, 31);
    bench.run_through(40);
    CHECK(dut.aboves.rises() == Clocks{31});
    CHECK(dut.pipereadies.rises() == Clocks{30});
}

TEST_CASE(
    "pipeline handshake: PIPEREADY for the next frame comes one clock after the frame, at the earliest") {
    ClockedTestbench bench;
    HandshakeBench dut(bench, Strap::kMaster);
    bench.core.drive(dut.fetched, 2, true);
    dut.hold(dut.running, 3, 20);
    bench.core.drive(dut.below, 4, true);
    bench.run_through(22);
    CHECK(dut.pipereadies.rises() == Clocks{21});
    CHECK(dut.startframes.rises() == Clocks{22});
}

TEST_CASE("pipeline handshake: what changes from clock to clock is seen as it stands at last") {
    ClockedTestbench bench;
    std::vector<std::unique_ptr<HandshakeBench>> duts;
    for (int changes = 2; changes <= 16; changes += 2) {
        for (const bool below_changes : {true, false}) {
            const std::string name = (below_changes ? "below_" : "running_") + std::to_string(changes);
            duts.push_back(std::make_unique<HandshakeBench>(bench, Strap::kMaster, Mode::kGlitch, name));
            HandshakeBench& dut = *duts.back();
            bench.core.drive(dut.below, 3, true);
            bench.core.drive(dut.fetched, below_changes ? 20 + changes : 21, true);
            for (int change = 1; change <= changes; ++change) {
                if (below_changes) {
                    bench.core.drive(dut.below, 20 + change, change % 2 == 0);
                } else {
                    bench.core.drive(dut.running, 20 + change, change % 2 != 0);
                }
            }
            bench.core.drive(dut.running, 22 + changes, true);  // the frame that starts
        }
    }
    bench.run_through(45);
    for (std::size_t i = 0; i < duts.size(); ++i) {
        const int last_change = 22 + 2 * static_cast<int>(i / 2);
        INFO(duts[i]->dut.name());
        CHECK(duts[i]->pipereadies.at(last_change));
        CHECK(duts[i]->startframes.rises() == Clocks{last_change + 1});
    }
}

TEST_CASE("pipeline handshake: in stall mode STARTFRAME stands still while COLUMNSTALL is high") {
    ClockedTestbench bench;
    HandshakeBench relay(bench, Strap::kRelay, Mode::kStall, "relay");
    HandshakeBench master(bench, Strap::kMaster, Mode::kStall, "master");
    HandshakeBench glitch(bench, Strap::kRelay, Mode::kGlitch, "glitch");
    for (HandshakeBench* dut : {&relay, &master, &glitch}) {
        dut->hold(dut->column_stall, 11, 30);  // each time long enough for an idle block to sleep
        dut->hold(dut->column_stall, 32, 50);
        bench.core.drive(dut->fetched, 2, true);
    }
    relay.hold(relay.startframe_in, 12, 31);  // a register above stands still, too
    glitch.hold(glitch.startframe_in, 12, 12);
    bench.core.pulse(master.below, 10);
    relay.hold(relay.running, 32, 70);
    master.hold(master.running, 32, 70);
    glitch.hold(glitch.running, 13, 70);
    bench.run_through(70);
    CHECK(relay.startframes.high() == clock_range(31, 51));
    CHECK(master.pipereadies.high() == clock_range(10, 31));
    CHECK(master.starts.high() == clock_range(11, 32));
    CHECK(master.startframes.high() == clock_range(31, 51));
    CHECK(glitch.startframes.high() == Clocks{12});  // nothing ever raises it there, so it is not read
}

TEST_CASE("pipeline handshake: reset leaves what power-up leaves and reads the strap again") {
    ClockedTestbench bench;
    HandshakeBench ready(bench, Strap::kRelay, Mode::kStall, "ready");
    HandshakeBench starting(bench, Strap::kRelay, Mode::kStall, "starting");
    HandshakeBench seen(bench, Strap::kRelay, Mode::kStall, "seen");
    HandshakeBench strapped(bench, Strap::kRelay, Mode::kStall, "strapped");
    bench.core.drive(bench.reset, 10, true);
    bench.core.drive(bench.reset, 12, false);
    for (HandshakeBench* dut : {&ready, &starting, &seen, &strapped}) bench.core.drive(dut->fetched, 2, true);
    ready.hold(ready.below, 4, 9);
    bench.core.pulse(starting.startframe_in, 9);
    bench.core.drive(seen.fetched, 2, false);
    seen.hold(seen.below, 4, 11);  // the edges in reset do not see it
    bench.core.drive(seen.fetched, 12, true);
    bench.core.drive(strapped.pipemaster, 5, true);
    bench.core.pulse(strapped.startframe_in, 7);
    bench.core.pulse(strapped.below, 14);
    bench.run_through(20);
    CHECK(ready.pipereadies.high() == clock_range(4, 10));
    CHECK(starting.startframes.high() == Clocks{9});
    CHECK(starting.aboves.high().empty());
    CHECK(seen.aboves.high().empty());
    // It was a relay until the reset and is the PIPEMASTER since.
    CHECK(strapped.startframes.high() == Clocks{7, 15});
}

TEST_CASE("pipeline handshake: a reset wakes a block that sleeps, and it reads the strap") {
    ClockedTestbench bench;
    HandshakeBench dut(bench, Strap::kRelay, Mode::kStall, "strapped");
    bench.core.drive(dut.fetched, 2, true);
    bench.core.drive(dut.pipemaster, 5, true);
    bench.core.drive(bench.reset, 40, true);
    bench.core.drive(bench.reset, 42, false);
    bench.core.pulse(dut.below, 50);
    bench.run_through(60);
    CHECK(dut.startframes.high() == Clocks{51});
}

// ---- in lockstep ----

/// PIPEREADY and STARTFRAME of a composer by the rules of the header, from what the last edge has sampled.
class Handshake final : public Lockstep<PipelineHandshake> {
  public:
    Handshake(LockstepBench& bench, const char* name, Mode mode)
        : Lockstep(bench, name,
                   [mode](const char* dut, rtl::ClockGating gating) {
                       return std::make_unique<PipelineHandshake>(dut, mode == Mode::kStall, gating);
                   }),
          mode_(mode) {
        wires_.add(pipemaster_, 100);
        wires_.add(stall_, 4);
        wires_.add(startframe_in_, 4);
        wires_.add(below_, 4);
        wires_.add(fetched_, 4);
        wires_.add(running_, 6);
    }

    void stimulate() override { wires_.stimulate(bench_); }
    void expect() override {
        // A PIPEREADY from below that the last edge of a frame has sampled belongs to that frame.
        const bool ready = !running_ && !was_running_ && !sent_ && (was_ready_ || (fetched_ && was_below_));
        pipeready_ = ready;
        start_ = !running_ && (master_ ? ready : startframe_in_.value());
        startframe_ = sent_;
    }
    void edge() override {
        was_running_ = running_;
        was_below_ = below_;
        was_ready_ = pipeready_;
        if (mode_ == Mode::kGlitch || !stall_) sent_ = start_;
        bench_.happened["PIPEREADY outlasts its reasons"] += was_ready_ && !(fetched_ && below_) ? 1 : 0;
        bench_.happened["STARTFRAME"] += sent_ ? 1 : 0;
    }
    void reset() override {
        was_running_ = was_below_ = was_ready_ = sent_ = false;
        master_ = pipemaster_;
    }

  private:
    Mode mode_;
    Input<bool>& pipemaster_ = in(&PipelineHandshake::pipemaster_i);
    Input<bool>& stall_ = in(&PipelineHandshake::column_stall_i);
    Input<bool>& startframe_in_ = in(&PipelineHandshake::startframe_i);
    Output<bool>& startframe_ = out(&PipelineHandshake::startframe_o);
    Input<bool>& below_ = in(&PipelineHandshake::pipeready_i);
    Output<bool>& pipeready_ = out(&PipelineHandshake::pipeready_o);
    Input<bool>& fetched_ = in(&PipelineHandshake::fetched_i);
    Input<bool>& running_ = in(&PipelineHandshake::running_i);
    Output<bool>& start_ = out(&PipelineHandshake::start_o);
    FreeWires wires_;
    bool master_ = false;
    // As the last edge has sampled them, and STARTFRAME.
    bool was_running_ = false, was_below_ = false, was_ready_ = false, sent_ = false;
};

TEST_CASE("pipeline handshake: in lockstep with its reference") {
    LockstepBench bench(2203);
    bench.clocks_to_pause = 20;
    const Handshake glitch(bench, "glitch", Mode::kGlitch);
    const Handshake stall(bench, "stall", Mode::kStall);
    bench.run(150'000, {{"PIPEREADY outlasts its reasons", 300}, {"STARTFRAME", 1000}});
}

}  // namespace
}  // namespace metabuffer::test::pipeline_handshake_test
