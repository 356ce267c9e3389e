#include "tlm/schedule_trace.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/errors.h"
#include "support/file_size_limit.h"
#include "support/random_seed.h"
#include "support/scratch_directory.h"

using namespace metabuffer;
using test::ScratchDirectory;
using tlm::BusSpan;
using tlm::ScheduleTrace;
namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

/// Two renderers on two displays.
Scenario machine(double core_mhz = 100.0) {
    Scenario scenario;
    scenario.name = "machine";
    scenario.displays.columns = 2;
    scenario.clocks.core_mhz = core_mhz;
    scenario.renderers.resize(2);
    scenario.renderers[0].name = "ball";
    scenario.renderers[1].name = "sea";
    return scenario;
}

BusSpan poll(std::int64_t first_cycle, std::int64_t last_cycle) {
    return {BusUse::kPoll, {first_cycle, last_cycle}};
}

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// The text of a trace of what `observe` reports.
template <typename Observe>
std::string text_of(const Scenario& scenario, Observe observe) {
    const ScratchDirectory scratch;
    ScheduleTrace trace(scratch / "schedule.json", scenario);
    observe(trace);
    trace.finish(123'456'789'012);
    CHECK(scratch.names() == std::vector<std::string>{"schedule.json"});
    return content(scratch / "schedule.json");
}

/// Its events but the descriptions of tracks, in the order of the file.
std::vector<Json> events_of(const std::string& text) {
    const Json trace = Json::parse(text);
    std::vector<Json> events;
    for (const Json& event : trace["traceEvents"]) {
        if (event["ph"] != "M") events.push_back(event);
    }
    return events;
}

template <typename Observe>
std::vector<Json> events_of(const Scenario& scenario, Observe observe) {
    return events_of(text_of(scenario, observe));
}

/// Name, time and pixels of each level.
std::vector<Json> levels_of(const std::vector<Json>& events) {
    std::vector<Json> levels;
    for (const Json& event : events) {
        if (event["ph"] == "C") levels.push_back({event["name"], event["ts"], event["args"]["pixels"]});
    }
    return levels;
}

/// As Perfetto reads ts and dur: each is rounded to nanoseconds on its own.
std::int64_t viewer_nanoseconds(const Json& microseconds) {
    return std::llround(microseconds.get<double>() * 1000.0);
}

/// The message of the exception of that type, "" if there is none.
template <typename Error, typename Action>
std::string failure_of(Action action) {
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("a schedule describes its tracks, has an event of each kind on a line, and says what the run was",
          "[schedule]") {
    // Perfetto knows a trace by its first two characters, and none may follow the last brace. Threads have other numbers
    // than processes.
    CHECK(text_of(machine(), [](ScheduleTrace& trace) {
              trace.bus(1, {BusUse::kTable, {100, 104}, 7});
              trace.bus(1, {BusUse::kBusy, {111, 142}, 7, 2, 1024, 64});
              trace.bus(1, {BusUse::kBusy, {143, 158}, 7, 1, 0, 32, 3});
              trace.bus(1, {BusUse::kPageMiss, {159, 164}, 7, 2, 0, 0, 0, 4096});
              trace.bus(1, {BusUse::kRefresh, {165, 176}});
              trace.bus(1, {BusUse::kWrite, {177, 184}});
              trace.bus(1, {BusUse::kGrant, {185, 186}});
              trace.bus(1, poll(187, 187));
              trace.bus(2, {BusUse::kLost, {200, 231}});
              trace.composited(2, 4, {300, 499});
              trace.column_stall(2, 4, {350, 359});
              trace.shown(2, 4, {400, 799});
              trace.buffer_level(2, 1, 500, 64);
          }) == R"({"displayTimeUnit":"ns","traceEvents":[
{"ph":"M","pid":1,"name":"process_name","args":{"name":"buses"}},
{"ph":"M","pid":1,"name":"process_sort_index","args":{"sort_index":1}},
{"ph":"M","pid":2,"name":"process_name","args":{"name":"composer buffers"}},
{"ph":"M","pid":2,"name":"process_sort_index","args":{"sort_index":2}},
{"ph":"M","pid":3,"name":"process_name","args":{"name":"displays"}},
{"ph":"M","pid":3,"name":"process_sort_index","args":{"sort_index":3}},
{"ph":"M","pid":1,"tid":101,"name":"thread_name","args":{"name":"ball"}},
{"ph":"M","pid":1,"tid":101,"name":"thread_sort_index","args":{"sort_index":101}},
{"ph":"M","pid":1,"tid":102,"name":"thread_name","args":{"name":"sea"}},
{"ph":"M","pid":1,"tid":102,"name":"thread_sort_index","args":{"sort_index":102}},
{"ph":"M","pid":3,"tid":101,"name":"thread_name","args":{"name":"display 1"}},
{"ph":"M","pid":3,"tid":101,"name":"thread_sort_index","args":{"sort_index":101}},
{"ph":"M","pid":3,"tid":102,"name":"thread_name","args":{"name":"display 1 screen"}},
{"ph":"M","pid":3,"tid":102,"name":"thread_sort_index","args":{"sort_index":102}},
{"ph":"M","pid":3,"tid":103,"name":"thread_name","args":{"name":"display 2"}},
{"ph":"M","pid":3,"tid":103,"name":"thread_sort_index","args":{"sort_index":103}},
{"ph":"M","pid":3,"tid":104,"name":"thread_name","args":{"name":"display 2 screen"}},
{"ph":"M","pid":3,"tid":104,"name":"thread_sort_index","args":{"sort_index":104}},
{"ph":"X","pid":1,"tid":101,"ts":1.000,"dur":0.050,"name":"table of frame 7","args":{"first_cycle":100,"frame":7}},
{"ph":"X","pid":1,"tid":101,"ts":1.110,"dur":0.320,"name":"display 2","args":{"first_cycle":111,"frame":7,"first_pixel":1024,"pixels":64,"recovered_slots":0}},
{"ph":"X","pid":1,"tid":101,"ts":1.430,"dur":0.160,"name":"display 1, recovered","cname":"good","args":{"first_cycle":143,"frame":7,"first_pixel":0,"pixels":32,"recovered_slots":3}},
{"ph":"X","pid":1,"tid":101,"ts":1.590,"dur":0.060,"name":"page miss","cname":"bad","args":{"first_cycle":159,"word_address":4096,"display":2}},
{"ph":"X","pid":1,"tid":101,"ts":1.650,"dur":0.120,"name":"refresh","cname":"bad","args":{"first_cycle":165}},
{"ph":"X","pid":1,"tid":101,"ts":1.770,"dur":0.080,"name":"link writes","cname":"bad","args":{"first_cycle":177}},
{"ph":"X","pid":1,"tid":101,"ts":1.850,"dur":0.020,"name":"arbitration","cname":"bad","args":{"first_cycle":185}},
{"ph":"X","pid":1,"tid":101,"ts":1.870,"dur":0.010,"name":"poll","cname":"grey","args":{"first_cycle":187}},
{"ph":"X","pid":1,"tid":102,"ts":2.000,"dur":0.320,"name":"lost slot","cname":"terrible","args":{"first_cycle":200}},
{"ph":"X","pid":3,"tid":103,"ts":3.000,"dur":2.000,"name":"composite frame 4","args":{"first_cycle":300,"frame":4}},
{"ph":"X","pid":3,"tid":103,"ts":3.500,"dur":0.100,"name":"stall","cname":"terrible","args":{"first_cycle":350,"frame":4}},
{"ph":"X","pid":3,"tid":104,"ts":4.000,"dur":4.000,"name":"shows frame 4","args":{"first_cycle":400,"frame":4}},
{"ph":"C","pid":2,"name":"renderer sea, display 1","ts":5.000,"args":{"pixels":64}}
],"otherData":{"scenario":"machine","level":"tlm","core_mhz":100.0,"core_period_ps":10000,"core_cycles":123456789012}})");
    for (const tlm::SliceRow& row : tlm::kSliceTable) CHECK_FALSE(row.meaning.empty());
}

TEST_CASE("each composer's buffer is a counter, written where it changes", "[schedule]") {
    const std::vector<Json> events = events_of(machine(), [](ScheduleTrace& trace) {
        CHECK(trace.level_wanted_cycle() == -1);  // without a window, none
        trace.buffer_level(2, 1, 0, 0);
        trace.buffer_level(2, 2, 0, 0);
        trace.buffer_level(2, 1, 10, 64);
        trace.buffer_level(1, 1, 15, 64);
        trace.buffer_level(2, 1, 20, 64);
        trace.buffer_level(2, 2, 20, 0);
        trace.buffer_level(2, 1, 30, 0);
    });
    CHECK(levels_of(events) == std::vector<Json>{{"renderer sea, display 1", 0.0, 0},
                                                 {"renderer sea, display 2", 0.0, 0},
                                                 {"renderer sea, display 1", 0.1, 64},
                                                 {"renderer ball, display 1", 0.15, 64},
                                                 {"renderer sea, display 1", 0.3, 0}});
}

TEST_CASE("times are the core clock's, to the nearest nanosecond, however late", "[schedule]") {
    struct Time {
        double core_mhz;
        std::int64_t cycle;
        const char* text;
    };
    for (const Time& time : std::vector<Time>{
             {133.3, 0, R"("ts":0.000,"dur":0.008,)"},  // 0 to 7.502 ns
             {133.3, 1, R"("ts":0.008,"dur":0.007,)"},  // to 15.004 ns
             {133.3, 134, R"("ts":1.005,"dur":0.008,)"},
             {133.3, 1'000'000'000, R"("ts":7502000.000,"dur":0.008,)"},
             {133.3, 123'456'789'012, R"("ts":926172831.168,"dur":0.008,)"},  // 926172831.168024 us
             {0.7, 169, R"("ts":241.428,)"},                                  // 241428.499 ns
             {0.7, 500, R"("ts":714.286,)"},                                  // 714285.5 ns
             {0.7, 831, R"("ts":1187.143,)"},                                 // 1187142.501 ns
         }) {
        INFO(time.text);
        const std::string text = text_of(machine(time.core_mhz), [&time](ScheduleTrace& trace) {
            trace.bus(1, poll(time.cycle, time.cycle));
            trace.buffer_level(1, 1, time.cycle, 1);
        });
        CHECK(text.find(time.text) != std::string::npos);
        const std::vector<Json> events = events_of(text);
        CHECK(events[0]["ts"] == events[1]["ts"]);
    }
}

TEST_CASE("neighbours neither overlap nor leave a gap in a viewer that counts nanoseconds", "[schedule]") {
    const std::uint64_t seed = test::random_seed(11);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    const double core_mhz = GENERATE(0.7, 66.6, 100.0, 133.3, 799.0, 3333.0);
    INFO(core_mhz << " MHz");
    const std::vector<Json> events = events_of(machine(core_mhz), [&](ScheduleTrace& trace) {
        std::int64_t cycle = 1'000'000;
        for (int n = 0; n < 2000; ++n) {
            const CycleSpan span{cycle, cycle + random.between(0, 99)};
            // The stall lies in the frame, up to its last clock.
            trace.column_stall(1, 0, {span.first + span.cycles() / 2, span.last});
            trace.composited(1, 0, span);
            cycle = span.last + 1;
        }
    });
    REQUIRE(events.size() == 4000);
    std::int64_t end = viewer_nanoseconds(events[1]["ts"]);
    int wrong = 0;
    for (std::size_t n = 0; n < events.size(); n += 2) {
        const std::int64_t start = viewer_nanoseconds(events[n + 1]["ts"]);
        wrong += start != end ? 1 : 0;
        end = start + viewer_nanoseconds(events[n + 1]["dur"]);
        const std::int64_t stall = viewer_nanoseconds(events[n]["ts"]);
        wrong += stall < start || stall + viewer_nanoseconds(events[n]["dur"]) != end ? 1 : 0;
    }
    CHECK(wrong == 0);
}

TEST_CASE("names are written whatever they are made of, in their own letters if they can be", "[schedule]") {
    const std::string replacement = "\xEF\xBF\xBD";
    struct Name {
        std::string given;
        std::string read;
        bool is_searchable = false;
    };
    const std::string quotes(700'000, '"');  // longer than the writer's buffer
    const std::string foreign = "\xC3\xA9t\xC3\xA9 \xE6\xB5\xB7";
    for (const Name& name : std::vector<Name>{{"\"quoted\\ \t{[,]}\"", "\"quoted\\ \t{[,]}\""},
                                              {foreign, foreign, true},
                                              {"\x01\x1F\n", "\x01\x1F\n"},
                                              {quotes, quotes},
                                              {"s\xE9"
                                               "a",
                                               "s" + replacement + "a"}}) {
        Scenario scenario = machine();
        scenario.name = name.given;
        scenario.renderers[1].name = name.given;
        const std::string text = text_of(scenario, [](ScheduleTrace& trace) {
            trace.bus(2, poll(0, 0));
            trace.buffer_level(2, 2, 0, 5);
        });
        const std::vector<Json> events = events_of(text);
        REQUIRE(events.size() == 2);
        CHECK((Json::parse(text)["traceEvents"][8]["args"]["name"] == name.read));  // the bus's track
        CHECK((events[1]["name"] == "renderer " + name.read + ", display 2"));
        CHECK((Json::parse(text)["otherData"]["scenario"] == name.read));
        if (name.is_searchable) CHECK(text.find(name.given) != std::string::npos);
    }
}

TEST_CASE("a long schedule is whole", "[schedule]") {
    constexpr int kBursts = 20'000;  // several times the buffer
    const std::vector<Json> events = events_of(machine(), [](ScheduleTrace& trace) {
        for (int n = 0; n < kBursts; ++n) {
            trace.bus(1 + n % 2, {BusUse::kBusy, {32LL * n, 32LL * n + 31}, n, 1, 64LL * n, 64, n % 3});
        }
    });
    REQUIRE(events.size() == kBursts);
    int wrong = 0;
    for (int n = 0; n < kBursts; ++n) {
        const Json& arguments = events[static_cast<std::size_t>(n)]["args"];
        wrong += arguments["first_cycle"] != 32 * n || arguments["frame"] != n ? 1 : 0;
    }
    CHECK(wrong == 0);
}

TEST_CASE("a window cuts slices at its edges and says where they really begin and end", "[schedule]") {
    const std::string text = text_of(machine(), [](ScheduleTrace& trace) {
        trace.show_only({100, 199});
        trace.bus(1, poll(0, 99));
        trace.bus(1, poll(200, 299));
        trace.bus(1, poll(90, 109));
        trace.bus(1, poll(110, 110));
        trace.bus(1, {BusUse::kPageMiss, {199, 205}, 0, 2, 0, 0, 0, 4096});
        trace.composited(2, 4, {50, 299});
        trace.bus(2, {BusUse::kTable, {100, 199}, 0});
    });
    std::vector<Json> slices;
    for (const Json& event : events_of(text)) slices.push_back({event["ts"], event["dur"], event["args"]});
    const auto whole = [](int first, int last, Json arguments) {
        arguments["whole_first_cycle"] = first;
        arguments["whole_last_cycle"] = last;
        return arguments;
    };
    CHECK(slices ==
          std::vector<Json>{
              {1.0, 0.1, whole(90, 109, {{"first_cycle", 100}})},
              {1.1, 0.01, {{"first_cycle", 110}}},
              {1.99, 0.01, whole(199, 205, {{"first_cycle", 199}, {"word_address", 4096}, {"display", 2}})},
              {1.0, 1.0, whole(50, 299, {{"first_cycle", 100}, {"frame", 4}})},
              {1.0, 1.0, {{"first_cycle", 100}, {"frame", 0}}}});
    const Json facts = Json::parse(text)["otherData"];
    CHECK(facts["core_cycles"] == 123'456'789'012);
    CHECK(facts["window_first_cycle"] == 100);
    CHECK(facts["window_last_cycle"] == 199);
}

TEST_CASE("a window begins with the level of every buffer", "[schedule]") {
    const std::vector<Json> events = events_of(machine(), [](ScheduleTrace& trace) {
        trace.show_only({100, 199});
        trace.buffer_level(1, 1, 0, 0);
        trace.buffer_level(1, 1, 80, 64);
        CHECK(trace.level_wanted_cycle() == 100);
        trace.buffer_level(1, 1, 100, 44);
        trace.buffer_level(1, 1, 120, 24);
        trace.buffer_level(1, 2, 50, 7);
        trace.buffer_level(1, 2, 100, 9);
        trace.buffer_level(1, 2, 199, 8);
        trace.buffer_level(1, 2, 200, 6);
        trace.buffer_level(2, 1, 99, 30);  // nothing more is reported of it
        trace.buffer_level(2, 2, 150, 0);
        trace.buffer_level(2, 2, 250, 10);
    });
    CHECK(levels_of(events) == std::vector<Json>{{"renderer ball, display 1", 1.0, 44},
                                                 {"renderer ball, display 1", 1.2, 24},
                                                 {"renderer ball, display 2", 1.0, 9},
                                                 {"renderer ball, display 2", 1.99, 8},
                                                 {"renderer sea, display 2", 1.5, 0},
                                                 {"renderer sea, display 1", 1.0, 30}});

    const std::vector<Json> of_one_clock = events_of(machine(), [](ScheduleTrace& trace) {
        trace.show_only({100, 100});
        trace.buffer_level(1, 1, 50, 7);
        trace.buffer_level(2, 2, 99, 30);
        trace.bus(1, poll(90, 110));
    });
    CHECK(of_one_clock.size() == 3);
    CHECK(levels_of(of_one_clock) ==
          std::vector<Json>{{"renderer ball, display 1", 1.0, 7}, {"renderer sea, display 2", 1.0, 30}});
}

TEST_CASE("a window shows what the run has of it, and without an event in it no file is left", "[schedule]") {
    const ScratchDirectory scratch;
    constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();
    const auto shown = [&scratch](CycleSpan window, CycleSpan polls, std::int64_t level_cycle) {
        ScheduleTrace trace(scratch / "schedule.json", machine());
        trace.show_only(window);
        if (polls.cycles() > 0) trace.bus(1, {BusUse::kPoll, polls});
        trace.buffer_level(1, 1, level_cycle, 7);
        trace.buffer_level(2, 1, level_cycle, 9);
        return trace.finish(1000);
    };
    CHECK_FALSE(shown({1000, kForever}, {0, 2000}, 0));
    CHECK_FALSE(shown({0, 99}, {100, 200}, 200));
    CHECK_FALSE(shown({100, 199}, {}, 50));
    CHECK_FALSE(shown({100, 199}, {}, 100));  // the levels that it begins with are no events
    CHECK(scratch.names().empty());
    CHECK(shown({100, 199}, {}, 101));
    const auto span = shown({900, kForever}, {950, 960}, 0);
    REQUIRE(span);
    CHECK(span->first == 900);
    CHECK(span->last == 999);
    CHECK(Json::parse(content(scratch / "schedule.json"))["otherData"]["window_last_cycle"] == 999);
}

TEST_CASE("the file gets its name when it is complete", "[schedule]") {
    for (const bool is_finished : {true, false}) {
        const ScratchDirectory scratch;
        const fs::path file = scratch.write("schedule.json", "the old one");
        auto trace = std::make_unique<ScheduleTrace>(file, machine());
        trace->bus(1, poll(0, 9));
        CHECK(scratch.names().size() == 2);  // one has its temporary name
        CHECK(content(file) == "the old one");
        if (is_finished) trace->finish(10);
        trace.reset();
        CHECK(scratch.names() == std::vector<std::string>{"schedule.json"});
        CHECK((content(file) == "the old one") == !is_finished);
        if (is_finished) CHECK(events_of(content(file)).size() == 1);
    }
}

TEST_CASE("a schedule's name ends in .json", "[schedule]") {
    const ScratchDirectory scratch;
    CHECK_NOTHROW(ScheduleTrace::check_name("out/schedule.json"));
    for (const char* name : {"schedule", "schedule.vcd", "schedule.json.gz", "schedule.JSON", ".json", ""}) {
        const fs::path file = *name == '\0' ? fs::path() : scratch / name;
        const std::string expected = "--trace " + file.string() + ": a schedule must end in .json";
        CHECK(failure_of<InputError>([&] { ScheduleTrace::check_name(file); }) == expected);
        CHECK(failure_of<InputError>([&] { ScheduleTrace(file, machine()); }) == expected);
    }
    CHECK(scratch.names().empty());
}

TEST_CASE("a schedule that cannot be written is reported in one line, at its beginning or at its end",
          "[schedule]") {
    const ScratchDirectory scratch;
    const fs::path file = scratch / "folder/schedule.json";
    const auto write = [&file](int events, const auto& meanwhile) {
        return failure_of<OutputError>([&] {
            ScheduleTrace trace(file, machine());
            meanwhile();
            for (int n = 0; n < events; ++n) trace.bus(1, poll(n, n));
            trace.finish(events);
        });
    };
    const std::string missing = "cannot write '" + file.string() + "': No such file or directory";
    CHECK(write(1, [] { FAIL("the file was opened"); }) == missing);
    fs::create_directories(scratch / "folder");
    CHECK(write(1, [&scratch] { fs::remove_all(scratch / "folder"); }) == missing);
    fs::create_directories(scratch / "folder");
    std::ofstream(file) << "the old one";
    for (const int events : {1, 20'000}) {
        const test::FileSizeLimit limit(100);
        CHECK(write(events, [] {}) == "cannot write '" + file.string() + "': File too large");
        CHECK(content(file) == "the old one");
        CHECK(std::distance(fs::directory_iterator(scratch / "folder"), {}) == 1);
    }
}
