#include "monitors/pipeline_monitor.h"

#include <array>
#include <catch2/catch.hpp>
#include <set>

#include "rule_table.h"
#include "support/scenarios.h"

namespace metabuffer::test::pipeline_monitor_test {

// Two stages and an output framebuffer, played by the test: each rule is broken once.
namespace {

constexpr int kRaster = 4 * 2;
constexpr int kStart = 10;  ///< STARTFRAME of the upper stage is sampled
constexpr int kEnd = 80;

/// The clocks that sample a wire high.
using Clocks = std::set<int>;

Clocks clocks(int first, int end) {
    Clocks all;
    for (int clock = first; clock < end; ++clock) all.insert(clock);
    return all;
}

struct PipelineBench : ClockedRuleBench {
    Scenario scenario = small_scenario(4, 2);
    sc_core::sc_signal<bool> column_stall{"COLUMNSTALL"};
    sc_core::sc_signal<bool> startframe_1{"STARTFRAME_1"};
    sc_core::sc_signal<bool> startframe_2{"STARTFRAME_2"};
    sc_core::sc_signal<rtl::PipePixel> pipe_1{"PIPE_1"};
    sc_core::sc_signal<rtl::PipePixel> pipe_2{"PIPE_2"};
    sc_core::sc_signal<bool> pipeready{"PIPEREADY"};
    std::unique_ptr<monitors::PipelineMonitor> monitor;

    // A frame by the rules. The lower stage works a clock after the upper one, and the output framebuffer reads
    // STARTFRAME from it.
    std::array<Clocks, 2> startframe;
    std::array<Clocks, 2> valid;
    Clocks ready;
    Clocks stall;

    /// The frame starts `later`. The column stands still for the clocks of `stalls` from 14 on: what edge 14 samples is
    /// sampled again.
    PipelineBench(const sc_core::sc_module_name& name, ClockedTestbench& testbench,
                  StarvationMode mode = StarvationMode::kGlitch, int stalls = 0, int later = 0)
        : ClockedRuleBench(name, testbench),
          ready(clocks(5, kStart + later + 2)),
          stall(clocks(14, 14 + stalls)) {
        scenario.composer.on_starvation = mode;
        scenario.renderers.resize(2);
        monitor = std::make_unique<monitors::PipelineMonitor>("monitor", scenario, 0, log);
        monitor->clk_i(bench.core.clk);
        monitor->reset_i(bench.reset);
        monitor->column_stall_i(column_stall);
        monitor->startframe_o[0](startframe_1);
        monitor->startframe_o[1](startframe_2);
        monitor->pipe_o[0](pipe_1);
        monitor->pipe_o[1](pipe_2);
        monitor->pipeready_i(pipeready);
        for (int stage = 0; stage < 2; ++stage) {
            const int start = kStart + later + stage;
            startframe[static_cast<std::size_t>(stage)] = {start};
            valid[static_cast<std::size_t>(stage)] = clocks(start + 1, start + 1 + kRaster + stalls);
        }
        bench.core.each_clock([this](int clock) {
            column_stall.write(stall.count(clock) > 0);
            startframe_1.write(startframe[0].count(clock) > 0);
            startframe_2.write(startframe[1].count(clock) > 0);
            pipe_1.write(rtl::PipePixel{Pixel(), valid[0].count(clock) > 0, false});
            pipe_2.write(rtl::PipePixel{Pixel(), valid[1].count(clock) > 0, false});
            pipeready.write(ready.count(clock) > 0);
        });
    }
};

/// A clock is put into both stages.
void put(std::array<Clocks, 2>& stages, int clock) {
    stages[0].insert(clock);
    stages[1].insert(clock + 1);
}
void check_one_frame(const PipelineBench& bench) { CHECK(bench.monitor->frames_taken() == 1); }

}  // namespace

TEST_CASE("pipeline monitor: its rules in a table", "[monitors]") {
    ClockedRuleTable<PipelineBench> rules;
    rules.of();
    rules.row("a frame by the rules", {}, {}, check_one_frame);
    rules.row("STARTFRAME that a stage holds back", {{"pipeline/skew", "STARTFRAME_2", kStart + 1}, kOthers},
              [](auto& bench) { bench.startframe[1] = {}; });
    rules.row("a pixel that a stage adds", {{"pipeline/skew", "PIPE_2", kStart + 1}, kOthers},
              [](auto& bench) { bench.valid[1].insert(kStart + 1); });
    rules.row("a pixel that a stage drops",
              {{"pipeline/skew", "PIPE_2", kStart + 5, 0}, {"pipeline/bubble", "PIPE_2", kStart + 5, 0}},
              [](auto& bench) { bench.valid[1].erase(kStart + 5); });
    rules.row("a bubble in the raster", {{"pipeline/bubble", "PIPE_2", kStart + 5, 0}}, [](auto& bench) {
        bench.valid[0].erase(kStart + 4);
        bench.valid[1].erase(kStart + 5);
    });
    rules.row("a pixel after the raster", {{"pipeline/outside", "PIPE_2", kStart + 2 + kRaster, 0}},
              [](auto& bench) { put(bench.valid, kStart + 1 + kRaster); });
    rules.row("a pixel together with STARTFRAME", {{"pipeline/outside", "PIPE_2", kStart + 1}},
              [](auto& bench) { put(bench.valid, kStart); });
    rules.row("STARTFRAME in a frame", {{"pipeline/frame", "STARTFRAME_2", kStart + 1 + kRaster, 0}},
              [](auto& bench) { put(bench.startframe, kStart + kRaster); });
    rules.row("PIPEREADY of the output framebuffer taken back",
              {{"pipeready/framebuffer", "PIPEREADY", 8, 0}}, [](auto& bench) { bench.ready.erase(8); });
    rules.row("PIPEREADY of the output framebuffer in a frame",
              {{"pipeready/framebuffer", "PIPEREADY", kStart + 2, 0}},
              [](auto& bench) { bench.ready.insert(kStart + 2); });

    rules.of(StarvationMode::kStall, 2);
    rules.row("a column that stands still", {}, {}, check_one_frame);
    rules.row("a stage that moves while its column stands still", {{"pipeline/skew", "PIPE_1", 15, 0}},
              [](auto& bench) { bench.valid[0].erase(15); });
    rules.row("a stall does not count as pixels", {{"pipeline/outside", "PIPE_2", kStart + 2 + kRaster, 0}},
              [](auto& bench) { bench.stall = {}; });
    rules.row(
        "the clocks of COLUMNSTALL with no frame count too, and while the monitor sleeps", {},
        [](auto& bench) {
            // The first stall is longer than the monitor goes on checking where nothing moves.
            for (const int clock : clocks(28, 40)) bench.stall.insert(clock);
            for (const int clock : clocks(60, 63)) bench.stall.insert(clock);
        },
        [](const auto& bench) { CHECK(bench.monitor->stalled_cycles() == 2 + 12 + 3); });

    rules.of(StarvationMode::kStall, 0, 2);
    rules.row(
        "STARTFRAME stands still with the column", {},
        [](auto& bench) {
            bench.startframe[0] = {kStart, kStart + 1, kStart + 2};
            bench.stall = {kStart, kStart + 1};
        },
        check_one_frame);
    // The monitor sleeps where nothing moves, and must not take the old stall for that of the frame's start.
    rules.of(StarvationMode::kStall, 0, 18);
    rules.row(
        "a stall that ends while nothing is on the way", {},
        [](auto& bench) {
            bench.ready.merge(clocks(0, 5));
            bench.stall = clocks(0, 12);
        },
        check_one_frame);
    rules.run_and_check(kEnd);
}

}  // namespace metabuffer::test::pipeline_monitor_test
