#include "tlm/schedule_trace.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "host/errors.h"
#include "host/output_file.h"

namespace metabuffer::tlm {
namespace {

using Json = nlohmann::ordered_json;

// A track is a thread of a process to the viewers.
constexpr int kBuses = 1;
constexpr int kBuffers = 2;
constexpr int kDisplays = 3;
// Threads have other numbers than processes: a viewer takes a thread with its process's number for the main thread and
// puts it first.
constexpr int kFirstThread = 100;

constexpr std::string_view kNextEvent = ",\n";
constexpr std::string_view kLineEnd = "\n";

constexpr int bus_thread(int renderer) { return kFirstThread + renderer; }
constexpr int pipeline_thread(int display) { return kFirstThread + 2 * display - 1; }
constexpr int screen_thread(int display) { return kFirstThread + 2 * display; }

/// Names come from the user's file and need not be UTF-8: invalid bytes are replaced, not refused.
std::string json_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// What stands between the quotes of a JSON string.
std::string escaped(const std::string& text) {
    const std::string quoted = json_text(text);
    return quoted.substr(1, quoted.size() - 2);
}

std::int64_t nanoseconds_of(std::int64_t cycle, std::int64_t period_picoseconds) {
    return (cycle * period_picoseconds + 500) / 1000;
}

/// With three decimals.
std::string microseconds(std::int64_t nanoseconds) {
    std::string text = std::to_string(nanoseconds);
    if (text.size() < 4) text.insert(0, 4 - text.size(), '0');
    return text.insert(text.size() - 3, ".");
}

}  // namespace

/// The file as it grows, behind a buffer. The first failure is kept for finish(); what comes after it is lost.
class ScheduleTrace::Output {
  public:
    explicit Output(const std::filesystem::path& target) : file_(target) {}

    template <typename... Parts>
    void write(const Parts&... parts) {
        (append(parts), ...);
        if (buffer_.size() >= kBufferBytes) flush();
    }

    void put_in_place() {
        flush();
        if (failure_) throw OutputError(*failure_);
        file_.put_in_place();
    }

  private:
    static constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

    void append(std::string_view text) { buffer_ += text; }
    void append(std::int64_t number) { buffer_ += std::to_string(number); }

    void flush() {
        try {
            if (!failure_) file_.write(buffer_);
        } catch (const OutputError& error) {
            failure_ = error.what();
        }
        buffer_.clear();
    }

    OutputFile file_;
    std::string buffer_;
    std::optional<std::string> failure_;
};

void ScheduleTrace::check_name(const std::filesystem::path& file) {
    if (file.extension() != ".json") {
        throw InputError("--trace " + file.string() + ": a schedule must end in .json");
    }
}

ScheduleTrace::ScheduleTrace(const std::filesystem::path& file, const Scenario& scenario)
    : scenario_name_(scenario.name),
      core_mhz_(scenario.clocks.core_mhz),
      period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      displays_(scenario.displays.count()),
      levels_(scenario.renderers.size() * static_cast<std::size_t>(displays_)) {
    check_name(file);
    output_ = std::make_unique<Output>(file);
    for (const Renderer& renderer : scenario.renderers) {
        counter_names_.push_back(R"({"ph":"C","pid":)" + std::to_string(kBuffers) + R"(,"name":"renderer )" +
                                 escaped(renderer.name) + ", display ");
    }
    write_tracks(scenario);
}

ScheduleTrace::~ScheduleTrace() = default;

void ScheduleTrace::write_tracks(const Scenario& scenario) {
    // Perfetto knows a trace by its first characters: {"
    output_->write(R"({"displayTimeUnit":"ns","traceEvents":[)");
    std::string_view separator = kLineEnd;
    const auto describe = [&](const char* key, int process, int thread, const std::string& argument) {
        output_->write(separator, R"({"ph":"M","pid":)", process);
        if (thread != 0) output_->write(R"(,"tid":)", thread);
        output_->write(R"(,"name":")", key, R"(","args":{)", argument, "}}");
        separator = kNextEvent;
    };
    const auto name = [](const std::string& text) { return R"("name":")" + text + "\""; };
    const auto sort_index = [](int index) { return R"("sort_index":)" + std::to_string(index); };
    const auto describe_process = [&](int process, const char* text) {
        describe("process_name", process, 0, name(text));
        describe("process_sort_index", process, 0, sort_index(process));
    };
    const auto describe_thread = [&](int process, int thread, const std::string& text) {
        describe("thread_name", process, thread, name(text));
        describe("thread_sort_index", process, thread, sort_index(thread));
    };

    describe_process(kBuses, "buses");
    describe_process(kBuffers, "composer buffers");
    describe_process(kDisplays, "displays");
    int number = 0;
    for (const Renderer& renderer : scenario.renderers) {
        describe_thread(kBuses, bus_thread(++number), escaped(renderer.name));
    }
    for (int display = 1; display <= displays_; ++display) {
        const std::string text = "display " + std::to_string(display);
        describe_thread(kDisplays, pipeline_thread(display), text);
        describe_thread(kDisplays, screen_thread(display), text + " screen");
    }
}

void ScheduleTrace::show_only(CycleSpan window) { window_ = window; }

CycleSpan ScheduleTrace::in_window(CycleSpan span) const {
    if (!window_) return span;
    return {std::max(span.first, window_->first), std::min(span.last, window_->last)};
}

std::optional<CycleSpan> ScheduleTrace::finish(std::int64_t core_cycles) {
    const CycleSpan run{0, core_cycles - 1};
    const CycleSpan shown = in_window(run);
    if (shown.cycles() > 0) {
        // A buffer that is not used again is not reported any more.
        for (int renderer = 1; renderer <= static_cast<int>(counter_names_.size()); ++renderer) {
            for (int display = 1; display <= displays_; ++display) {
                const Level& last = level(renderer, display);
                if (last.is_before) write_level(renderer, display, window_->first, last.reported);
            }
        }
    }
    if (window_ && (shown.cycles() <= 0 || is_empty_)) return std::nullopt;
    Json facts = {{"scenario", scenario_name_},
                  {"level", "tlm"},
                  {"core_mhz", core_mhz_},
                  {"core_period_ps", period_picoseconds_},
                  {"core_cycles", core_cycles}};
    if (window_) {
        facts["window_first_cycle"] = shown.first;
        facts["window_last_cycle"] = shown.last;
    }
    // No line end after it: Perfetto reads a large file in pieces and refuses a piece that comes after the last brace.
    output_->write(kLineEnd, R"(],"otherData":)", json_text(facts), "}");
    output_->put_in_place();
    return shown;
}

void ScheduleTrace::write_slice(Slice kind, int number, int process, int thread, CycleSpan span,
                                std::initializer_list<std::int64_t> arguments) {
    const CycleSpan shown = in_window(span);
    if (shown.cycles() <= 0) return;
    is_empty_ = false;
    const SliceRow& row = row_of(kSliceTable, kind);
    const std::int64_t start = nanoseconds_of(shown.first, period_picoseconds_);
    const std::int64_t end = nanoseconds_of(shown.last + 1, period_picoseconds_);
    output_->write(kNextEvent, R"({"ph":"X","pid":)", process, R"(,"tid":)", thread, R"(,"ts":)",
                   microseconds(start), R"(,"dur":)", microseconds(end - start), R"(,"name":")");
    const std::size_t at = row.name.find_first_of("DF");
    output_->write(row.name.substr(0, at));
    if (at != std::string_view::npos) output_->write(number, row.name.substr(at + 1));
    output_->write("\",");
    if (!row.colour_name.empty()) output_->write(R"("cname":")", row.colour_name, "\",");
    output_->write(R"("args":{"first_cycle":)", shown.first);
    if (shown.cycles() < span.cycles()) {
        output_->write(R"(,"whole_first_cycle":)", span.first, R"(,"whole_last_cycle":)", span.last);
    }
    const std::string_view* name = row.arguments.data();
    for (const std::int64_t argument : arguments) output_->write(",\"", *name++, "\":", argument);
    output_->write("}}");
}

void ScheduleTrace::bus(int renderer, const BusSpan& span) {
    static constexpr std::array<Slice, kBusUseTable.size()> kKinds{
        Slice::kBeats,      Slice::kTable,       Slice::kPageMiss, Slice::kRefresh,
        Slice::kLinkWrites, Slice::kArbitration, Slice::kPoll,     Slice::kLostSlot};  // by BusUse
    // The number of slots is not in the name, so that both names can be searched and counted.
    const Slice kind =
        span.recovered_slots > 0 ? Slice::kRecoveredBeats : kKinds.at(static_cast<std::size_t>(span.use));
    const auto write = [&](int number, std::initializer_list<std::int64_t> arguments) {
        write_slice(kind, number, kBuses, bus_thread(renderer), span.cycles, arguments);
    };
    if (span.use == BusUse::kBusy) {
        write(span.display, {span.frame, span.first_pixel, span.pixels, span.recovered_slots});
    } else if (span.use == BusUse::kTable) {
        write(span.frame, {span.frame});
    } else if (span.use == BusUse::kPageMiss) {
        write(0, {span.word_address, span.display});
    } else {
        write(0, {});
    }
}

void ScheduleTrace::buffer_level(int renderer, int display, std::int64_t cycle, int held_pixels) {
    Level& of_buffer = level(renderer, display);
    of_buffer.is_before = window_ && cycle < window_->first;
    of_buffer.reported = held_pixels;
    if (of_buffer.is_before || (window_ && cycle > window_->last)) return;
    write_level(renderer, display, cycle, held_pixels);
}

void ScheduleTrace::write_level(int renderer, int display, std::int64_t cycle, int held_pixels) {
    Level& of_buffer = level(renderer, display);
    if (of_buffer.written == held_pixels) return;
    of_buffer.written = held_pixels;
    if (window_ && cycle > window_->first) is_empty_ = false;
    // No clock among the arguments: each argument of a counter is drawn.
    output_->write(kNextEvent, counter_names_[static_cast<std::size_t>(renderer - 1)], display, R"(","ts":)",
                   microseconds(nanoseconds_of(cycle, period_picoseconds_)), R"(,"args":{"pixels":)",
                   held_pixels, "}}");
}

void ScheduleTrace::composited(int display, int frame, CycleSpan span) {
    write_slice(Slice::kComposite, frame, kDisplays, pipeline_thread(display), span, {frame});
}

void ScheduleTrace::column_stall(int display, int frame, CycleSpan span) {
    write_slice(Slice::kStall, frame, kDisplays, pipeline_thread(display), span, {frame});
}

void ScheduleTrace::shown(int display, int frame, CycleSpan span) {
    write_slice(Slice::kShows, frame, kDisplays, screen_thread(display), span, {frame});
}

}  // namespace metabuffer::tlm
