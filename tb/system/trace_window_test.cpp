#include "rtl/trace_window.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <optional>

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
