#include "simulation/trace_window.h"

#include <sysc/tracing/sc_tracing_ids.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "formats/stored_image.h"
#include "host/errors.h"
#include "random_scenario.h"
#include "rtl/metabuffer.h"
#include "rtl/run.h"
#include "support/lines.h"
#include "support/scenarios.h"
#include "support/scratch_directory.h"
#include "tlm/metabuffer.h"
#include "tlm/run.h"

// Which clocks a waveform shows. What the file then holds is tested with the program.
namespace metabuffer::test::trace_window_test {
namespace {

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using Kind = TraceWindow::Kind;

/// One of its frames takes longer than the run goes on between two checks for a window.
Scenario long_frames() {
    return with_renderer(small_scenario(256, 128),
                         renderer_of({PixelImage(256, 128)}, {segment_row({8, 4})}));
}

rtl::RunResult run_with(const Scenario& scenario, const TraceWindow& window, const ScratchDirectory& scratch,
                        const std::optional<WindowEvent>& event = {}) {
    rtl::RunOptions options;
    // One block that does little, so that the file stays small.
    options.trace = rtl::TraceRequest{scratch / "window.vcd", window, {"swap_lock"}, "", event};
    return rtl::run(scenario, options);
}

/// Ends before the run is looked at from outside for the second time.
Scenario short_run() {
    return with_renderer(small_scenario(16, 8), renderer_of({PixelImage(16, 8)}, {segment_row({8, 4})}));
}

/// From now on TMPDIR is this folder.
std::filesystem::path own_temporary_folder(const ScratchDirectory& scratch) {
    std::filesystem::path folder = scratch / "temporary";
    std::filesystem::create_directory(folder);
    setenv("TMPDIR", folder.c_str(), 1);
    return folder;
}

/// A waveform of these clocks.
rtl::TraceRequest waveform_of(const ScratchDirectory& scratch, std::int64_t first, std::int64_t last) {
    TraceWindow window;
    window.kind = Kind::kCycles;
    window.first = first;
    window.last = last;
    return {scratch / "window.vcd", window, {"swap_lock"}, "", {}};
}

/// Calls a function at each core clock of a machine, with the clock's number.
class AtEachClock final : public sc_core::sc_module {
  public:
    AtEachClock(const sc_core::sc_module_name& name, rtl::Metabuffer& machine,
                std::function<void(std::int64_t cycle)> call)
        : sc_core::sc_module(name), machine_(machine), call_(std::move(call)) {
        SC_METHOD(clock_edge);
        sensitive << machine.core_clk().posedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(AtEachClock);

  private:
    void clock_edge() { call_(machine_.core_cycle()); }

    rtl::Metabuffer& machine_;
    std::function<void(std::int64_t)> call_;
};

/// Runs it with a call at each core clock.
rtl::RunResult run_with_call(const Scenario& scenario, rtl::RunOptions options,
                             const std::function<void(std::int64_t cycle)>& call) {
    std::unique_ptr<AtEachClock> caller;
    options.on_built = [&](rtl::Metabuffer& machine) {
        caller = std::make_unique<AtEachClock>("at_each_clock", machine, call);
    };
    return rtl::run(scenario, options);
}

/// The text of the error of that type that ends a run.
template <typename Error, typename Run>
std::string error_of(Run run) {
    try {
        run();
    } catch (const Error& error) {
        return error.what();
    }
    return "no such error";
}

std::size_t open_descriptors() {
    const std::filesystem::directory_iterator all("/proc/self/fd");
    return static_cast<std::size_t>(std::distance(begin(all), end(all)));
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
        {"first-recovered-slot", Kind::kFirstRecoveredSlot, 0, 0},
        {"cycles:0-0", Kind::kCycles, 0, 0},
        {"cycles:7-1000000000000000", Kind::kCycles, 7, 1'000'000'000'000'000},
        {"frames:3", Kind::kFrames, 3, 3},
        {"frames:3-3", Kind::kFrames, 3, 3},
        {"frames:0-999999", Kind::kFrames, 0, 999'999},
        {"startframe:0", Kind::kStartFrame, 0, 0},
        {"startframe:999999", Kind::kStartFrame, 999'999, 999'999},
    };
    for (const ReadWindow& wanted : right) {
        INFO(wanted.text);
        const TraceWindow window = parse_trace_window(wanted.text);
        CHECK(window.text == wanted.text);
        CHECK(window.kind == wanted.kind);
        CHECK(window.first == wanted.first);
        CHECK(window.last == wanted.last);
        CHECK(window.before_cycles == TraceWindow::kDefaultBeforeCycles);
        CHECK(window.after_cycles == TraceWindow::kDefaultAfterCycles);
    }
    std::istringstream list(
        "All all: all:1 cycles cycles: cycles:5 cycles:7- cycles:-7 cycles:7-6 cycles:0-1000000000000001 "
        "cycles:1-2-3 "
        "frame:0 frames frames: frames:-1 frames:4-3 frames:a frames:0-1000000 frames:1000000 frames:+1 "
        "frames:1x "
        "frames:99999999999999999999 startframe:1-2 startframe:1-1 startframe:x startframe:1000000 "
        "startframe "
        "first-starved-pixel:1 first-busready-drop:1 first-recovered-slot:1 first_starved_pixel "
        "99999999999999999999");
    std::vector<std::string> refused{std::istream_iterator<std::string>(list), {}};
    refused.insert(refused.end(),
                   {"", "cycles:7", "cycles:9-8", "cycles:1- 2", "startframe:0-1", "frames:2-1"});
    for (const std::string& wrong : refused) {
        INFO(wrong);
        CHECK_THROWS_AS(parse_trace_window(wrong), InputError);
        CHECK_THROWS_WITH(parse_trace_window(wrong),
                          Contains("first-busready-drop") && Contains("cycles:A-B"));
    }
}

TEST_CASE("trace window: it begins with the run at the earliest and has no end beyond the last number",
          "[system]") {
    constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();
    TraceWindow window;
    window.before_cycles = 200;
    window.after_cycles = 2000;
    CHECK(window.around({200, 300}).first == 0);
    CHECK(window.around({201, 300}).first == 1);
    CHECK(window.around({199, 300}).first == 0);
    CHECK(window.around({201, 300}).last == 2300);
    window.after_cycles = kForever;
    for (const std::int64_t last : {0, 1, 2, 300}) {
        INFO(last);
        CHECK(window.around({0, last}).last == kForever);
    }
}

/// Instead of a machine: what is known of its events.
struct KnownEvents {
    std::int64_t startframe_cycle = ComposerRecord::kNever;
    std::int64_t frame_end = ComposerRecord::kNever;
    std::int64_t busready_drop = ComposerRecord::kNever;
    std::int64_t starved = ComposerRecord::kNever;

    std::int64_t recovered = ComposerRecord::kNever;

    MachineEvent startframe(int frame) const { return {frame == 3 ? startframe_cycle : 1000, 1, 1}; }
    std::int64_t frame_end_cycle(int frame) const { return frame == 4 ? frame_end : 1000; }
    MachineEvent first_busready_drop() const { return {busready_drop, 1, 2}; }
    MachineEvent first_starved() const { return {starved, 2, 1}; }
    MachineEvent first_recovered_slot() const { return {recovered, 2, 2}; }
};

std::string as_text(const std::optional<WindowEvent>& event) {
    if (!event) return "never";
    return std::to_string(event->start.cycle) + " to " + std::to_string(event->last_cycle) + " in " +
           std::to_string(event->start.renderer) + "," + std::to_string(event->start.display);
}

TEST_CASE("trace window: each kind has its own event, and none before that has happened", "[system]") {
    const auto event = [](const char* window, const KnownEvents& known) {
        return as_text(event_of(parse_trace_window(window), known));
    };
    const KnownEvents all{10, 20, 30, 40, 50};
    CHECK(event("frames:3-4", all) == "10 to 20 in 1,1");
    CHECK(event("startframe:3", all) == "10 to 10 in 1,1");
    CHECK(event("first-busready-drop", all) == "30 to 30 in 1,2");
    CHECK(event("first-starved-pixel", all) == "40 to 40 in 2,1");
    CHECK(event("first-recovered-slot", all) == "50 to 50 in 2,2");
    CHECK(event("all", all) == "never");
    CHECK(event("cycles:3-4", all) == "never");

    const KnownEvents at_the_first_clock{0, 0, 0, 0, 0};
    KnownEvents frame_begun;
    frame_begun.startframe_cycle = 10;
    CHECK(event("frames:3-4", frame_begun) == "never");
    for (const char* const window : {"frames:3-4", "startframe:3", "first-busready-drop",
                                     "first-starved-pixel", "first-recovered-slot"}) {
        INFO(window);
        CHECK(event(window, {}) == "never");
        CHECK_THAT(event(window, at_the_first_clock), StartsWith("0 to 0 in"));
    }
}

TEST_CASE("trace window: of events in one clock the first is that of the first renderer, then display",
          "[system]") {
    const MachineEvent never;
    const MachineEvent later{7, 1, 1};
    const MachineEvent sooner{6, 2, 2};
    for (const auto& [one, other, first] :
         std::vector<std::array<MachineEvent, 3>>{{never, sooner, sooner},
                                                  {later, sooner, sooner},
                                                  {MachineEvent{6, 2, 1}, sooner, MachineEvent{6, 2, 1}},
                                                  {MachineEvent{6, 1, 3}, sooner, MachineEvent{6, 1, 3}}}) {
        for (const MachineEvent& found : {earlier(one, other), earlier(other, one)}) {
            CHECK(found.cycle == first.cycle);
            CHECK(found.renderer == first.renderer);
            CHECK(found.display == first.display);
        }
    }
    CHECK_FALSE(earlier(never, never).happened());
}

TEST_CASE("trace window: a waveform whose name ends in nothing known is refused", "[system]") {
    const ScratchDirectory scratch;
    rtl::RunOptions options;
    options.trace = waveform_of(scratch, 0, 10);
    options.trace->file = scratch / "window.txt";
    CHECK(error_of<InputError>([&] { rtl::run(short_run(), options); }) ==
          "--trace " + options.trace->file.string() + ": a waveform file must end in .vcd or .fst");
    CHECK(scratch.names().empty());
}

TEST_CASE("trace window: a run without a waveform says nothing of one", "[system]") {
    const ScratchDirectory scratch;
    rtl::RunOptions options;
    options.trace = waveform_of(scratch, 0, 10);
    options.trace->window.kind = Kind::kStartFrame;
    options.trace->event = WindowEvent{{10, 1, 1}, 10};
    options.trace.reset();  // what it asked for before counts no more
    const rtl::RunResult result = rtl::run(short_run(), options);
    CHECK_FALSE(result.traced);
    CHECK(result.trace_note.empty());
    CHECK(result.trace_warning.empty());
    CHECK(result.simulation_seconds > 0.0);
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
    CHECK(result.trace_note.empty());
}

TEST_CASE("trace window: core_cycle n stands at n clocks in all of the file, also for the first values",
          "[system]") {
    const ScratchDirectory scratch;
    const Scenario scenario = long_frames();
    const std::int64_t period = clock_period_picoseconds(scenario.clocks.core_mhz);
    rtl::RunOptions options;
    options.trace = waveform_of(scratch, 100, 103);
    rtl::run(scenario, options);
    std::string identifier;
    std::int64_t time = 0;  // what readers take it for before the first stamp
    std::vector<std::int64_t> cycles;
    for (const std::string& line : lines_of_file(scratch / "window.vcd")) {
        std::istringstream stream(line);
        const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
        if (words.size() > 4 && words[0] == "$var" && words[4] == "core_cycle") identifier = words[3];
        if (words.size() == 1 && words[0][0] == '#') time = std::stoll(words[0].substr(1));
        if (words.size() != 2 || words[1] != identifier) continue;
        cycles.push_back(std::stoll(words[0].substr(1), nullptr, 2));
        CHECK(time == cycles.back() * period);
    }
    CHECK(cycles == std::vector<std::int64_t>{100, 101, 102, 103});
}

TEST_CASE("trace window: once the waveform's first clock has run, nothing of it lies in TMPDIR", "[system]") {
    const ScratchDirectory scratch;
    const std::filesystem::path temporary = own_temporary_folder(scratch);
    int frames_shown = 0;
    rtl::RunOptions options;
    // It ends before the run looks at it from outside for the first time after that clock.
    options.trace = waveform_of(scratch, 0, 1'000'000);
    options.on_frame_shown = [&](const DisplayedFrame&) {
        ++frames_shown;
        CHECK(std::filesystem::is_empty(temporary));
    };
    const rtl::RunResult result = rtl::run(short_run(), options);
    REQUIRE(result.traced);
    CHECK(result.report.core_cycles < 20'000);
    CHECK(frames_shown == 1);
    CHECK(std::filesystem::exists(options.trace->file));
}

/// In the window's second clock nothing of its waveform lies in TMPDIR any more.
void check_second_clock(std::int64_t last) {
    const ScratchDirectory scratch;
    const std::filesystem::path temporary = own_temporary_folder(scratch);
    rtl::RunOptions options;
    options.trace = waveform_of(scratch, 100, last);
    int seen = 0;
    const rtl::RunResult result = run_with_call(short_run(), options, [&](std::int64_t cycle) {
        if (cycle == 100) CHECK_FALSE(std::filesystem::is_empty(temporary));
        if (cycle != 101) return;
        ++seen;
        CHECK(std::filesystem::is_empty(temporary));
    });
    CHECK(seen == 1);
    REQUIRE(result.traced);
    CHECK(result.traced->last == last);
}

TEST_CASE("trace window: in the second clock of a long window nothing of it lies in TMPDIR", "[system]") {
    check_second_clock(200);
}

TEST_CASE("trace window: in the second clock of a window of two nothing of it lies in TMPDIR", "[system]") {
    check_second_clock(101);
}

TEST_CASE("trace window: a pipe that is gone before the waveform begins is an error of one line",
          "[system]") {
    const ScratchDirectory scratch;
    const std::filesystem::path temporary = own_temporary_folder(scratch);
    rtl::RunOptions options;
    options.trace = waveform_of(scratch, 100, 200);
    const auto run = [&] {
        run_with_call(short_run(), options, [&](std::int64_t cycle) {
            if (cycle == 50) std::filesystem::remove_all(temporary);
        });
    };
    CHECK(error_of<OutputError>(run) ==
          "cannot write '" + options.trace->file.string() + "': the pipe to its process cannot be opened");
    CHECK(scratch.names().empty());
}

/// An error of that message type at a core clock ends the run as it is. Nothing stays open, and no waveform is left.
void check_error(const std::string& type, std::int64_t at_cycle,
                 const std::optional<std::pair<std::int64_t, std::int64_t>>& window) {
    const ScratchDirectory scratch;
    rtl::RunOptions options;
    if (window) options.trace = waveform_of(scratch, window->first, window->second);
    const std::size_t open_before = open_descriptors();
    const auto run = [&] {
        run_with_call(short_run(), options, [&](std::int64_t cycle) {
            if (cycle == at_cycle) SC_REPORT_ERROR(type.c_str(), "told to fail");
        });
    };
    CHECK_THAT(error_of<sc_core::sc_report>(run), Contains("told to fail"));
    CHECK(open_descriptors() == open_before);
    CHECK(scratch.names().empty());
}

constexpr const char* kOtherError = "/metabuffer/test";

TEST_CASE("trace window: an error before the window ends the run as it is", "[system]") {
    check_error(kOtherError, 50, {{100, 200}});
}

TEST_CASE("trace window: an error in the window's first clock ends the run as it is", "[system]") {
    check_error(kOtherError, 100, {{100, 200}});
}

TEST_CASE("trace window: an error in the window closes the waveform and ends the run as it is", "[system]") {
    check_error(kOtherError, 150, {{100, 200}});
}

/// A host may write a waveform of its own, too.
TEST_CASE("trace window: an error of another waveform is not taken for one of this run's", "[system]") {
    check_error(sc_core::SC_ID_TRACING_FOPEN_FAILED_, 50, {});
}

TEST_CASE("trace window: an error of another waveform in the window is not taken for one of this run's",
          "[system]") {
    check_error(sc_core::SC_ID_TRACING_FOPEN_FAILED_, 150, {{100, 200}});
}

TEST_CASE("trace window: of a frame, from its STARTFRAME to its last pixel even if that comes late",
          "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
    window.kind = Kind::kFrames;
    window.before_cycles = 3;
    window.after_cycles = 5;
    const rtl::RunResult result =
        run_with(long_frames(), window, scratch, rtl::find_event(long_frames(), window).event);
    INFO(result.trace_note);
    REQUIRE(result.traced);
    // The top composer starts a clock before its first pixel, and raises STARTFRAME with it.
    CHECK(result.traced->first == result.report.frames.at(0).start_cycle - 1 - 3);
    CHECK(result.traced->last == result.report.frames.at(0).end_cycle + 5);
}

/// The machines' events themselves are compared wherever the levels are (tlm_run.h); here is how they are found.
TEST_CASE("trace window: level tlm finds the clocks that level rtl finds", "[system][repeat]") {
    constexpr std::uint64_t kMachines = 12;
    std::map<Kind, int> found;
    for (std::uint64_t seed = 1; seed <= kMachines; ++seed) {
        const Scenario scenario = random_level_scenario(seed);
        INFO("seed " << seed << ": " << describe(scenario));
        const std::string last = std::to_string(scenario.frames - 1);
        for (const std::string& text :
             {std::string("first-busready-drop"), std::string("first-starved-pixel"),
              std::string("first-recovered-slot"), "startframe:" + last, "frames:0-" + last}) {
            const TraceWindow window = parse_trace_window(text);
            const WindowSearch right = rtl::find_event(scenario, window);
            const WindowSearch sooner = tlm::find_event(scenario, window);
            INFO(text);
            CHECK(as_text(sooner.event) == as_text(right.event));
            if (!right.event) CHECK(sooner.whole_run == right.whole_run);
            found[window.kind] += right.event ? 1 : 0;
        }
    }
    for (const Kind kind : {Kind::kFrames, Kind::kStartFrame, Kind::kFirstBusreadyDrop,
                            Kind::kFirstStarvedPixel, Kind::kFirstRecoveredSlot}) {
        INFO(static_cast<int>(kind));
        CHECK(found[kind] > 0);
    }
}

TEST_CASE("trace window: level tlm finds clocks without reading an image", "[system]") {
    Scenario unread = short_run();
    unread.renderers.front().images.front() = std::make_shared<const StoredImage>(
        ImageSize{16, 8}, []() -> PixelImage { throw InputError("it cannot be read"); });
    const TraceWindow window = parse_trace_window("startframe:0");
    const WindowSearch right = rtl::find_event(short_run(), window);
    REQUIRE(right.event);
    CHECK(as_text(tlm::find_event(unread, window).event) == as_text(right.event));
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
    std::vector<std::int64_t> ends;
    machine.on_frame_shown([&](const DisplayedFrame& shown) {
        first_starved.push_back(machine.first_starved().cycle);
        ends.push_back(machine.frame_end_cycle(shown.frame));
    });
    machine.on_finished([] { sc_core::sc_pause(); });
    while (!machine.finished()) sc_core::sc_start(1, sc_core::SC_MS);
    REQUIRE(first_starved.size() == 3);
    const FrameRecord first = machine.report().frames.at(0);
    CHECK(first_starved[0] >= first.start_cycle);
    CHECK(first_starved[0] <= first.end_cycle);
    CHECK(first_starved[2] == first_starved[0]);
    for (std::size_t frame = 0; frame < ends.size(); ++frame) {
        CHECK(ends[frame] == machine.report().frames.at(frame).end_cycle);
    }
}

TEST_CASE("trace window: a window that another level found is shown, without a warning", "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
    window.before_cycles = 3;
    window.after_cycles = 5;
    const rtl::RunResult result =
        run_with(long_frames(), window, scratch, tlm::find_event(long_frames(), window).event);
    INFO(result.trace_note);
    REQUIRE(result.traced);
    CHECK(result.traced->first == result.report.frames.at(0).start_cycle - 1 - 3);
    CHECK(result.traced->last == result.report.frames.at(0).start_cycle - 1 + 5);
    CHECK(result.trace_warning.empty());
}

TEST_CASE("trace window: a search that has the event at another clock is detected", "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
    window.before_cycles = 3;
    window.after_cycles = 5;
    const rtl::RunResult result = run_with(long_frames(), window, scratch, WindowEvent{{103, 1, 1}, 103});
    REQUIRE(result.traced);
    CHECK(result.traced->first == 100);
    const std::int64_t startframe = result.report.frames.at(0).start_cycle - 1;
    CHECK(result.trace_warning ==
          "what the waveform should show is elsewhere at level rtl; use --trace-window cycles:" +
              std::to_string(startframe - 3) + "-" + std::to_string(startframe + 5));
}

TEST_CASE("trace window: a search that has the event's end right and its beginning wrong is detected",
          "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
    window.kind = Kind::kFrames;
    std::optional<WindowEvent> event = rtl::find_event(long_frames(), window).event;
    REQUIRE(event);
    const CycleSpan right = window.around(event->cycles());
    ++event->start.cycle;
    const rtl::RunResult result = run_with(long_frames(), window, scratch, event);
    CHECK(result.trace_warning ==
          "what the waveform should show is elsewhere at level rtl; use --trace-window cycles:" +
              std::to_string(right.first) + "-" + std::to_string(right.last));
}

TEST_CASE("trace window: what would happen behind the run's end is no event of it", "[system]") {
    for (const char* const window : {"startframe:1", "frames:1", "frames:0-1"}) {
        INFO(window);
        for (const auto find_event : {rtl::find_event, tlm::find_event}) {
            const WindowSearch search = find_event(short_run(), parse_trace_window(window));
            CHECK_FALSE(search.event);
            CHECK(search.whole_run);
        }
    }
    // Composers take nothing for a while, and then a frame could start.
    Scenario held_up = short_run();
    Fault fault;
    fault.kind = FaultKind::kBusreadyLow;
    fault.display = 1;
    fault.cycles = 10'000;
    held_up.faults.push_back(fault);
    const TraceWindow startframe = parse_trace_window("startframe:0");
    const auto found = rtl::find_event(held_up, startframe).event;
    REQUIRE(found);
    CHECK(found->start.cycle > 10'000);
    CHECK(found->start.cycle < 13'000);
    // Before that the watchdog ends the run.
    held_up.watchdog_cycles = 2000;
    const WindowSearch cut_short = rtl::find_event(held_up, startframe);
    CHECK_FALSE(cut_short.event);
    CHECK_FALSE(cut_short.whole_run);
}

TEST_CASE("trace window: a search that has an event which does not happen is detected", "[system]") {
    const ScratchDirectory scratch;
    TraceWindow window;
    window.kind = Kind::kFirstStarvedPixel;
    const rtl::RunResult result = run_with(long_frames(), window, scratch, WindowEvent{{103, 1, 1}, 103});
    CHECK(result.trace_warning == "what the waveform should show does not happen at level rtl");
}

TEST_CASE("trace window: a search that misses an event is detected", "[system]") {
    const ScratchDirectory scratch;
    const rtl::RunResult result = run_with(long_frames(), TraceWindow{}, scratch);
    CHECK_FALSE(result.traced);
    CHECK(result.trace_note.find("elsewhere at level rtl; use --trace-window cycles:") != std::string::npos);
    CHECK(result.trace_warning.empty());
}

}  // namespace
}  // namespace metabuffer::test::trace_window_test
