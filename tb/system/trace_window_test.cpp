#include "simulation/trace_window.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/errors.h"
#include "random_scenario.h"
#include "rtl/run.h"
#include "support/scenarios.h"
#include "support/scratch_directory.h"
#include "tlm/metabuffer.h"
#include "tlm/run.h"

// Which clocks a waveform shows. What the file then holds is tested with the program.
namespace metabuffer::test {
namespace {

using Kind = TraceWindow::Kind;

/// One of its frames takes longer than the run goes on between two checks for a window.
Scenario long_frames() {
    return with_renderer(small_scenario(256, 128),
                         renderer_of({PixelImage(256, 128)}, {segment_row({8, 4})}));
}

rtl::RunResult run_with(const Scenario& scenario, const TraceWindow& window, const ScratchDirectory& scratch,
                        const FindWindow& find_window = {}) {
    rtl::RunOptions options;
    // One block that does little, so that the file stays small.
    options.trace = rtl::TraceRequest{scratch / "window.vcd", window, {"swap_lock"}, "", find_window};
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
        const TraceWindow window = parse_trace_window(wanted.text);
        CHECK(window.kind == wanted.kind);
        CHECK(window.first == wanted.first);
        CHECK(window.last == wanted.last);
        CHECK(window.before_cycles == TraceWindow::kDefaultBeforeCycles);
        CHECK(window.after_cycles == TraceWindow::kDefaultAfterCycles);
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
        CHECK_THROWS_AS(parse_trace_window(wrong), InputError);
    }
}

TEST_CASE("trace window: a window of one clock shows that clock", "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
    window.kind = Kind::kCycles;
    window.first = window.last = 100;
    const rtl::RunResult result = run_with(long_frames(), window, scratch);
    INFO(result.trace_note);
    REQUIRE(result.traced);
    CHECK(result.traced->first == 100);
    CHECK(result.traced->last == 100);
}

TEST_CASE("trace window: once the waveform's first clock has run, nothing of it lies in TMPDIR", "[system]") {
    const ScratchDirectory scratch;
    const std::filesystem::path temporary = scratch / "temporary";
    std::filesystem::create_directory(temporary);
    setenv("TMPDIR", temporary.c_str(), 1);
    // It ends before the run looks at it from outside for the first time after that clock.
    const Scenario scenario =
        with_renderer(small_scenario(16, 8), renderer_of({PixelImage(16, 8)}, {segment_row({8, 4})}));
    TraceWindow window;
    window.kind = Kind::kCycles;
    window.last = 1'000'000;
    int frames_shown = 0;
    rtl::RunOptions options;
    options.trace = rtl::TraceRequest{scratch / "window.vcd", window, {"swap_lock"}, "", {}};
    options.on_frame_shown = [&](const DisplayedFrame&) {
        ++frames_shown;
        CHECK(std::filesystem::is_empty(temporary));
    };
    const rtl::RunResult result = rtl::run(scenario, options);
    REQUIRE(result.traced);
    CHECK(result.report.core_cycles < 20'000);
    CHECK(frames_shown == 1);
}

TEST_CASE("trace window: of a frame, from its STARTFRAME to its last pixel even if that comes late",
          "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
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

std::string as_text(const std::optional<CycleSpan>& range) {
    return range ? std::to_string(range->first) + " to " + std::to_string(range->last) : "never";
}

/// The machines' events themselves are compared wherever the levels are (tlm_run.h); here is how they are found.
TEST_CASE("trace window: level tlm finds the clocks that level rtl finds", "[system]") {
    constexpr std::uint64_t kMachines = 12;
    std::map<Kind, int> found;
    for (std::uint64_t seed = 1; seed <= kMachines; ++seed) {
        const Scenario scenario = random_level_scenario(seed);
        INFO("seed " << seed << ": " << describe(scenario));
        const std::string last = std::to_string(scenario.frames - 1);
        for (const std::string& text :
             {std::string("first-busready-drop"), std::string("first-starved-pixel"), "startframe:" + last,
              "frames:0-" + last}) {
            const TraceWindow window = parse_trace_window(text);
            const std::optional<CycleSpan> right = rtl::find_window(scenario, window);
            INFO(text);
            CHECK(as_text(tlm::find_window(scenario, window)) == as_text(right));
            found[window.kind] += right ? 1 : 0;
        }
    }
    for (const Kind kind :
         {Kind::kFrames, Kind::kStartFrame, Kind::kFirstBusreadyDrop, Kind::kFirstStarvedPixel}) {
        INFO(static_cast<int>(kind));
        CHECK(found[kind] > 0);
    }
}

TEST_CASE("trace window: level tlm is certain of an event when its frame has been shown", "[system]") {
    Scenario scenario = small_scenario(64, 32);
    // The bus is so slow that pixels starve in every frame.
    scenario.memory.page_words = 8;
    scenario.memory.page_miss_cycles = 40;
    const PixelImage image(64, 32);
    scenario = with_renderer(scenario, renderer_of({image, image, image}, {segment_row({64, 32})}));
    scenario.frames = 3;
    tlm::Metabuffer machine("metabuffer", scenario, tlm::Metabuffer::Options{});
    std::vector<std::int64_t> first_starved;
    machine.on_frame_shown(
        [&](const DisplayedFrame&) { first_starved.push_back(machine.first_starved_cycle()); });
    machine.on_finished([] { sc_core::sc_pause(); });
    while (!machine.finished()) sc_core::sc_start(1, sc_core::SC_MS);
    REQUIRE(first_starved.size() == 3);
    const FrameRecord first = machine.report().frames.at(0);
    CHECK(first_starved[0] >= first.start_cycle);
    CHECK(first_starved[0] <= first.end_cycle);
    CHECK(first_starved[2] == first_starved[0]);
}

TEST_CASE("trace window: a window that another level found is the same, without a warning", "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
    window.before_cycles = 3;
    window.after_cycles = 5;
    const rtl::RunResult result = run_with(long_frames(), window, scratch, tlm::find_window);
    INFO(result.trace_note);
    REQUIRE(result.traced);
    CHECK(result.traced->first == result.report.frames.at(0).start_cycle - 1 - 3);
    CHECK(result.traced->last == result.report.frames.at(0).start_cycle - 1 + 5);
    CHECK(result.trace_warning.empty());
}

TEST_CASE("trace window: a level that has the event at another clock is detected", "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
    window.before_cycles = 3;
    window.after_cycles = 5;
    const rtl::RunResult result =
        run_with(long_frames(), window, scratch, [](const Scenario&, const TraceWindow&) {
            return CycleSpan{100, 108};
        });
    REQUIRE(result.traced);
    CHECK(result.traced->first == 100);
    const std::int64_t startframe = result.report.frames.at(0).start_cycle - 1;
    CHECK(result.trace_warning ==
          "what the waveform should show is elsewhere at level rtl; use --trace-window cycles:" +
              std::to_string(startframe - 3) + "-" + std::to_string(startframe + 5));
}

TEST_CASE("trace window: a level that has an event which does not happen is detected", "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
    window.kind = Kind::kFirstStarvedPixel;
    const rtl::RunResult result =
        run_with(long_frames(), window, scratch, [](const Scenario&, const TraceWindow&) {
            return CycleSpan{100, 108};
        });
    CHECK(result.trace_warning == "what the waveform should show does not happen at level rtl");
}

TEST_CASE("trace window: a level that misses an event is detected", "[system]") {
    const ScratchDirectory scratch;
    const rtl::RunResult result = run_with(long_frames(), TraceWindow{}, scratch,
                                           [](const Scenario&, const TraceWindow&) { return std::nullopt; });
    CHECK_FALSE(result.traced);
    CHECK(result.trace_note.find("elsewhere at level rtl; use --trace-window cycles:") != std::string::npos);
    CHECK(result.trace_warning.empty());
}

}  // namespace
}  // namespace metabuffer::test
