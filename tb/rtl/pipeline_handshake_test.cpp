#include "rtl/pipeline_handshake.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>

#include "lockstep/lockstep.h"

namespace metabuffer::test::pipeline_handshake_test {
namespace {

using rtl::PipelineHandshake;

enum class Mode : std::uint8_t { kGlitch, kStall };

/// PIPEREADY and STARTFRAME of a composer by the rules of the header, from what the last edge has sampled.
class Handshake final : public Lockstep<PipelineHandshake> {
  public:
    Handshake(LockstepBench& bench, const char* name, Mode mode)
        : Lockstep(bench, name,
                   [mode](const char* dut, rtl::ClockGating) {
                       return std::make_unique<PipelineHandshake>(dut, mode == Mode::kStall);
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
