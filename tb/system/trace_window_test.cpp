#include "rtl/trace_window.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <optional>

#include "host/errors.h"
#include "rtl/run.h"
#include "support/scenarios.h"
#include "support/scratch_directory.h"

// Which clocks a waveform shows. What the file then holds is tested with the program.
namespace metabuffer::test {
namespace {

using Kind = rtl::TraceWindow::Kind;

/// A frame of it takes longer than the run goes on between two looks for a window.
Scenario long_frames() {
    return with_renderer(small_scenario(256, 128),
                         renderer_of({PixelImage(256, 128)}, {segment_row({8, 4})}));
}

rtl::RunResult run_with(const Scenario& scenario, const rtl::TraceWindow& window,
                        const ScratchDirectory& scratch) {
    rtl::RunOptions options;
    // One block that does little, so that the file stays small.
    options.trace = rtl::TraceRequest{scratch / "window.vcd", window, {"swap_lock"}};
    return rtl::run(scenario, options);
}

struct ReadWindow {
    const char* text;
    Kind kind;
    std::int64_t first;
    std::int64_t last;
};

TEST_CASE("trace window: what each text asks for, up to the largest numbers", "[system]") {
    const std::vector<ReadWindow> right{
        {"all", Kind::kAll, 0, 0},
        {"first-busready-drop", Kind::kFirstBusreadyDrop, 0, 0},
        {"first-starved-pixel", Kind::kFirstStarvedPixel, 0, 0},
        {"cycles:0-0", Kind::kCycles, 0, 0},
        {"cycles:7-1000000000000000", Kind::kCycles, 7, 1'000'000'000'000'000},
        {"frames:3", Kind::kFrames, 3, 3},
        {"frames:3-3", Kind::kFrames, 3, 3},
        {"frames:0-1000000", Kind::kFrames, 0, 1'000'000},
        {"startframe:0", Kind::kStartFrame, 0, 0},
        {"startframe:1000000", Kind::kStartFrame, 1'000'000, 1'000'000},
    };
    for (const ReadWindow& wanted : right) {
        INFO(wanted.text);
        const rtl::TraceWindow window = rtl::parse_trace_window(wanted.text);
        CHECK(window.kind == wanted.kind);
        CHECK(window.first == wanted.first);
        CHECK(window.last == wanted.last);
        CHECK(window.before_cycles == rtl::TraceWindow::kDefaultBeforeCycles);
        CHECK(window.after_cycles == rtl::TraceWindow::kDefaultAfterCycles);
    }
    for (const char* wrong : {"",
                              "All",
                              "all:",
                              "all:1",
                              "cycles",
                              "cycles:",
                              "cycles:7",
                              "cycles:7-",
                              "cycles:-7",
                              "cycles:7-6",
                              "cycles:0-1000000000000001",
                              "cycles:1-2-3",
                              "cycles:1- 2",
                              "frames:",
                              "frames:-1",
                              "frames:4-3",
                              "frames:0-1000001",
                              "frames:1000001",
                              "frames:+1",
                              "frames:1x",
                              "startframe:1-2",
                              "startframe:1-1",
                              "startframe:1000001",
                              "startframe",
                              "first-starved-pixel:1",
                              "frames:99999999999999999999"}) {
        INFO(wrong);
        CHECK_THROWS_AS(rtl::parse_trace_window(wrong), InputError);
    }
}

TEST_CASE("trace window: a window of one clock shows that clock", "[system]") {
    const ScratchDirectory scratch;
    rtl::TraceWindow window;
    window.kind = Kind::kCycles;
    window.first = window.last = 100;
    const rtl::RunResult result = run_with(long_frames(), window, scratch);
    INFO(result.trace_note);
    REQUIRE(result.traced);
    CHECK(result.traced->first == 100);
    CHECK(result.traced->last == 100);
}

TEST_CASE("trace window: of a frame, from its STARTFRAME to its last pixel even if that is long in coming",
          "[system]") {
    const ScratchDirectory scratch;
    rtl::TraceWindow window;
    window.kind = Kind::kFrames;
    window.before_cycles = 3;
    window.after_cycles = 5;
    const rtl::RunResult result = run_with(long_frames(), window, scratch);
    INFO(result.trace_note);
    REQUIRE(result.traced);
    // The top composer starts a clock before its first pixel, and raises STARTFRAME with it.
    CHECK(result.traced->first == result.report.frames.at(0).start_cycle - 1 - 3);
    CHECK(result.traced->last == result.report.frames.at(0).end_cycle + 5);
}

}  // namespace
}  // namespace metabuffer::test
