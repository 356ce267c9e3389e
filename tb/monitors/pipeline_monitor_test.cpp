#include "monitors/pipeline_monitor.h"

#include <array>
#include <catch2/catch.hpp>
#include <set>
#include <utility>

#include "clocked_testbench.h"
#include "support/scenarios.h"
#include "violations.h"

namespace metabuffer::test::pipeline_monitor_test {

// Two stages and an output framebuffer, played by the test: each rule is broken once.
namespace {

constexpr int kRaster = 4 * 2;
constexpr int kStart = 10;  ///< STARTFRAME of the upper stage is sampled
constexpr int kEnd = 40;

Scenario pipeline_scenario(StarvationMode mode = StarvationMode::kGlitch) {
    Scenario scenario = small_scenario(4, 2);
    scenario.composer.on_starvation = mode;
    scenario.renderers.resize(2);
    return scenario;
}

/// The clocks that sample a wire high.
using Clocks = std::set<int>;

Clocks clocks(int first, int end) {
    Clocks all;
    for (int clock = first; clock < end; ++clock) all.insert(clock);
    return all;
}

struct PipelineBench {
    ClockedTestbench bench;
    Scenario scenario;
    Violations violations{bench.core};
    sc_core::sc_signal<bool> column_stall{"COLUMNSTALL"};
    sc_core::sc_signal<bool> startframe_1{"STARTFRAME_1"};
    sc_core::sc_signal<bool> startframe_2{"STARTFRAME_2"};
    sc_core::sc_signal<rtl::PipePixel> pipe_1{"PIPE_1"};
    sc_core::sc_signal<rtl::PipePixel> pipe_2{"PIPE_2"};
    sc_core::sc_signal<bool> pipeready{"PIPEREADY"};
    monitors::PipelineMonitor monitor;

    // A frame by the rules. The lower stage works a clock after the upper one, and the output framebuffer reads
    // STARTFRAME from it.
    std::array<Clocks, 2> startframe{{{kStart}, {kStart + 1}}};
    std::array<Clocks, 2> valid{
        {clocks(kStart + 1, kStart + 1 + kRaster), clocks(kStart + 2, kStart + 2 + kRaster)}};
    Clocks ready = clocks(5, kStart + 2);
    Clocks stall;

    explicit PipelineBench(Scenario with = pipeline_scenario())
        : scenario(std::move(with)), monitor("monitor", scenario, 0, violations.log) {
        monitor.clk_i(bench.core.clk);
        monitor.reset_i(bench.reset);
        monitor.column_stall_i(column_stall);
        monitor.startframe_o[0](startframe_1);
        monitor.startframe_o[1](startframe_2);
        monitor.pipe_o[0](pipe_1);
        monitor.pipe_o[1](pipe_2);
        monitor.pipeready_i(pipeready);
        bench.core.each_clock([this](int clock) {
            const auto high = [clock](const Clocks& all) { return all.count(clock) > 0; };
            column_stall.write(high(stall));
            startframe_1.write(high(startframe[0]));
            startframe_2.write(high(startframe[1]));
            pipe_1.write(rtl::PipePixel{Pixel(), high(valid[0]), false});
            pipe_2.write(rtl::PipePixel{Pixel(), high(valid[1]), false});
            pipeready.write(high(ready));
        });
    }

    /// A clock is taken out of, or put into, both stages.
    void in_both(std::array<Clocks, 2>& stages, int clock, bool high) {
        for (int stage = 0; stage < 2; ++stage) {
            Clocks& all = stages[static_cast<std::size_t>(stage)];
            high ? static_cast<void>(all.insert(clock + stage)) : static_cast<void>(all.erase(clock + stage));
        }
    }
    void run() { bench.run_through(kEnd); }
};

}  // namespace

TEST_CASE("pipeline monitor: a frame by the rules breaks none", "[monitors]") {
    PipelineBench bench;
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.frames_taken() == 1);
}

TEST_CASE("pipeline monitor: STARTFRAME that a stage holds back", "[monitors]") {
    PipelineBench bench;
    bench.startframe[1] = {};
    bench.run();
    bench.violations.check_first("pipeline/skew", "STARTFRAME_2", kStart + 1, -1);
}

TEST_CASE("pipeline monitor: a pixel that a stage adds", "[monitors]") {
    PipelineBench bench;
    bench.valid[1].insert(kStart + 1);
    bench.run();
    bench.violations.check_first("pipeline/skew", "PIPE_2", kStart + 1, -1);
}

TEST_CASE("pipeline monitor: a pixel that a stage drops", "[monitors]") {
    PipelineBench bench;
    bench.valid[1].erase(kStart + 5);
    bench.run();
    bench.violations.check_first("pipeline/skew", "PIPE_2", kStart + 5, 0);
    CHECK(bench.violations.list.at(1).rule == "pipeline/bubble");
}

TEST_CASE("pipeline monitor: a bubble in the raster", "[monitors]") {
    PipelineBench bench;
    bench.in_both(bench.valid, kStart + 4, false);
    bench.run();
    bench.violations.check_only("pipeline/bubble", "PIPE_2", kStart + 5, 0);
}

TEST_CASE("pipeline monitor: a pixel after the raster", "[monitors]") {
    PipelineBench bench;
    bench.in_both(bench.valid, kStart + 1 + kRaster, true);
    bench.run();
    bench.violations.check_only("pipeline/outside", "PIPE_2", kStart + 2 + kRaster, 0);
}

TEST_CASE("pipeline monitor: a pixel together with STARTFRAME", "[monitors]") {
    PipelineBench bench;
    bench.in_both(bench.valid, kStart, true);
    bench.run();
    bench.violations.check_only("pipeline/outside", "PIPE_2", kStart + 1, -1);
}

TEST_CASE("pipeline monitor: STARTFRAME in a frame", "[monitors]") {
    PipelineBench bench;
    bench.in_both(bench.startframe, kStart + kRaster, true);
    bench.run();
    bench.violations.check_only("pipeline/frame", "STARTFRAME_2", kStart + 1 + kRaster, 0);
}

TEST_CASE("pipeline monitor: PIPEREADY of the output framebuffer taken back", "[monitors]") {
    PipelineBench bench;
    bench.ready.erase(8);
    bench.run();
    bench.violations.check_only("pipeready/framebuffer", "PIPEREADY", 8, 0);
}

TEST_CASE("pipeline monitor: PIPEREADY of the output framebuffer in a frame", "[monitors]") {
    PipelineBench bench;
    bench.ready.insert(kStart + 2);
    bench.run();
    bench.violations.check_only("pipeready/framebuffer", "PIPEREADY", kStart + 2, 0);
}

namespace {

/// The column stands still at edges 14 and 15: what edge 14 samples is sampled again at 15 and 16.
struct StalledBench : PipelineBench {
    StalledBench() : PipelineBench(pipeline_scenario(StarvationMode::kStall)) {
        stall = {14, 15};
        valid = {{clocks(kStart + 1, kStart + 3 + kRaster), clocks(kStart + 2, kStart + 4 + kRaster)}};
    }
};

}  // namespace

TEST_CASE("pipeline monitor: a column that stands still breaks no rule", "[monitors]") {
    StalledBench bench;
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.frames_taken() == 1);
}

TEST_CASE("pipeline monitor: counts the clocks of COLUMNSTALL, with no frame there too") {
    StalledBench bench;
    const auto stall = [&bench](int first, int clocks) {
        for (int clock = first; clock < first + clocks; ++clock) bench.stall.insert(clock);
    };
    stall(kEnd - 12, 12);  // longer than the monitor goes on checking where nothing moves
    stall(kEnd + 20, 3);   // while it sleeps
    bench.bench.run_through(kEnd + 40);
    bench.violations.check_none();
    CHECK(bench.monitor.stalled_cycles() == 2 + 12 + 3);
}

TEST_CASE("pipeline monitor: a stall that ends while nothing is on the way breaks no rule later on") {
    PipelineBench bench(pipeline_scenario(StarvationMode::kStall));
    // The monitor sleeps where nothing moves, and must not take the old stall for that of the frame's start.
    constexpr int kLater = 18;
    for (auto* stages : {&bench.startframe, &bench.valid}) {
        for (Clocks& all : *stages) {
            Clocks later;
            for (const int clock : all) later.insert(clock + kLater);
            all = later;
        }
    }
    bench.ready = clocks(0, kStart + kLater + 2);
    bench.stall = clocks(0, 12);
    bench.run();
    bench.violations.check_none();
    CHECK(bench.monitor.frames_taken() == 1);
}

TEST_CASE("pipeline monitor: a stage that moves while its column stands still", "[monitors]") {
    StalledBench bench;
    bench.valid[0].erase(15);
    bench.run();
    bench.violations.check_first("pipeline/skew", "PIPE_1", 15, 0);
}

TEST_CASE("pipeline monitor: a stall does not count as pixels", "[monitors]") {
    StalledBench bench;
    bench.stall = {};
    bench.run();
    bench.violations.check_only("pipeline/outside", "PIPE_2", kStart + 2 + kRaster, 0);
}

}  // namespace metabuffer::test::pipeline_monitor_test
