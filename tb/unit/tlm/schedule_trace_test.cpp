#include "tlm/schedule_trace.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "host/errors.h"
#include "support/file_size_limit.h"
#include "support/random_seed.h"
#include "support/scratch_directory.h"

using namespace metabuffer;
using test::ScratchDirectory;
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

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void write_file(const fs::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

/// The text of a trace of what `observe` reports.
template <typename Observe>
std::string text_of(const Scenario& scenario, Observe observe, std::int64_t core_cycles = 1000) {
    const ScratchDirectory scratch;
    ScheduleTrace trace(scratch / "schedule.json", scenario);
    observe(trace);
    trace.finish(core_cycles);
    CHECK(scratch.names() == std::vector<std::string>{"schedule.json"});
    return content(scratch / "schedule.json");
}

/// The events that are not descriptions of tracks, in the order of the file.
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

/// What a metadata event says of a process or of a thread; null if there is none.
Json description(const std::string& text, const std::string& key, const Json& pid,
                 const Json& tid = nullptr) {
    const Json trace = Json::parse(text);
    Json found;
    for (const Json& event : trace["traceEvents"]) {
        if (event["ph"] == "M" && event["name"] == key && event["pid"] == pid &&
            event.value("tid", Json(nullptr)) == tid) {
            CHECK(found.is_null());
            found = event["args"];
        }
    }
    return found;
}

/// The name of the track that an event is on: "process/thread".
std::string track_of(const std::string& text, const Json& event) {
    return description(text, "process_name", event["pid"]).value("name", "?") + "/" +
           description(text, "thread_name", event["pid"], event["tid"]).value("name", "?");
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

const auto kNothing = [](ScheduleTrace&) {};

}  // namespace

TEST_CASE("an empty schedule names its tracks and its run", "[schedule]") {
    const std::string text = text_of(machine(133.3), kNothing, 123'456'789'012);
    const Json trace = Json::parse(text);
    CHECK(text.substr(0, 2) == "{\"");
    CHECK(text.back() == '}');
    CHECK(trace["displayTimeUnit"] == "ns");
    CHECK(trace["otherData"] == Json{{"scenario", "machine"},
                                     {"level", "tlm"},
                                     {"core_mhz", 133.3},
                                     {"core_period_ps", 7502},
                                     {"core_cycles", 123'456'789'012}});
    CHECK(events_of(text).empty());

    std::vector<std::string> processes;
    std::vector<std::string> threads;
    std::vector<int> order;
    for (const Json& event : trace["traceEvents"]) {
        if (event["name"] == "process_name") processes.push_back(event["args"]["name"]);
        if (event["name"] != "thread_name") continue;
        threads.push_back(track_of(text, event));
        CHECK(event["pid"] != event["tid"]);
        order.push_back(description(text, "thread_sort_index", event["pid"], event["tid"])["sort_index"]);
    }
    CHECK(processes == std::vector<std::string>{"buses", "composer buffers", "displays"});
    CHECK(threads == std::vector<std::string>{"buses/ball", "buses/sea", "displays/display 1",
                                              "displays/display 1 screen", "displays/display 2",
                                              "displays/display 2 screen"});
    CHECK(std::is_sorted(order.begin(), order.begin() + 2));
    CHECK(std::is_sorted(order.begin() + 2, order.end()));
    CHECK(description(text, "process_sort_index", 1)["sort_index"] == 1);
}

TEST_CASE("each event stands on a line of its own, and what is said of the run on the last", "[schedule]") {
    std::istringstream text(text_of(machine(), [](ScheduleTrace& trace) {
        trace.poll(1, {0, 9});
        trace.buffer_level(2, 1, 10, 64);
    }));
    std::vector<std::string> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    REQUIRE(lines.size() > 4);
    CHECK(lines.front() == R"({"displayTimeUnit":"ns","traceEvents":[)");
    CHECK(lines.back().substr(0, 15) == R"(],"otherData":{)");
    lines.pop_back();
    for (std::size_t n = 1; n < lines.size(); ++n) {
        const std::string& line = lines[n];
        INFO(line);
        CHECK(Json::parse(line.back() == ',' ? line.substr(0, line.size() - 1) : line).contains("ph"));
    }
}

TEST_CASE("each bus has a track with what it does", "[schedule]") {
    const std::string text = text_of(machine(), [](ScheduleTrace& trace) {
        trace.table(1, 7, {100, 104});
        trace.page_miss(1, 2, 4096, {105, 110});
        trace.beats(1, 2, 7, 1024, 64, 0, {111, 142});
        trace.beats(1, 1, 7, 0, 32, 1, {143, 158});
        trace.poll(1, {159, 159});
        trace.refresh(1, {160, 171});
        trace.memory_write(1, {172, 179});
        trace.arbitration(1, {180, 181});
        trace.lost_slot(2, {200, 231});
    });
    const std::vector<Json> events = events_of(text);
    REQUIRE(events.size() == 9);
    for (const Json& event : events) {
        CHECK(event["ph"] == "X");
        CHECK(track_of(text, event) == (event == events.back() ? "buses/sea" : "buses/ball"));
    }

    CHECK(events[0]["name"] == "table of frame 7");
    CHECK(events[0]["args"] == Json{{"first_cycle", 100}, {"frame", 7}});
    CHECK(events[0]["ts"] == 1.0);
    CHECK(events[0]["dur"] == 0.05);

    CHECK(events[1]["name"] == "page miss");
    CHECK(events[1]["args"] == Json{{"first_cycle", 105}, {"word_address", 4096}, {"display", 2}});
    CHECK(events[1]["cname"] == "bad");

    CHECK(events[2]["name"] == "display 2");
    CHECK(events[2]["args"] == Json{{"first_cycle", 111},
                                    {"frame", 7},
                                    {"first_pixel", 1024},
                                    {"pixels", 64},
                                    {"recovered_slots", 0}});
    CHECK_FALSE(events[2].contains("cname"));

    CHECK(events[3]["name"] == "display 1, recovered");
    CHECK(events[3]["args"]["recovered_slots"] == 1);
    CHECK(events[3]["cname"] == "good");

    CHECK(events[4]["name"] == "poll");
    CHECK(events[4]["args"] == Json{{"first_cycle", 159}});
    CHECK(events[4]["dur"] == 0.01);
    CHECK(events[4]["cname"] == "grey");

    CHECK(events[5]["name"] == "refresh");
    CHECK(events[5]["args"] == Json{{"first_cycle", 160}});
    CHECK(events[5]["dur"] == 0.12);
    CHECK(events[5]["cname"] == "bad");

    CHECK(events[6]["name"] == "link writes");
    CHECK(events[6]["args"] == Json{{"first_cycle", 172}});
    CHECK(events[6]["cname"] == "bad");

    CHECK(events[7]["name"] == "arbitration");
    CHECK(events[7]["args"] == Json{{"first_cycle", 180}});
    CHECK(events[7]["cname"] == "bad");

    CHECK(events[8]["name"] == "lost slot");
    CHECK(events[8]["args"] == Json{{"first_cycle", 200}});
    CHECK(events[8]["cname"] == "terrible");
}

TEST_CASE("each display has a track of its pipeline and one of its screen", "[schedule]") {
    const std::string text = text_of(machine(), [](ScheduleTrace& trace) {
        trace.column_stall(2, 4, {150, 159});
        trace.composited(2, 4, {100, 299});
        trace.shown(2, 4, {400, 799});
    });
    const std::vector<Json> events = events_of(text);
    REQUIRE(events.size() == 3);
    CHECK(events[0]["name"] == "stall");
    CHECK(events[0]["cname"] == "terrible");
    CHECK(events[0]["args"] == Json{{"first_cycle", 150}, {"frame", 4}});
    CHECK(track_of(text, events[0]) == "displays/display 2");
    CHECK(events[1]["name"] == "composite frame 4");
    CHECK(events[1]["args"] == Json{{"first_cycle", 100}, {"frame", 4}});
    CHECK(track_of(text, events[1]) == "displays/display 2");
    CHECK(events[2]["name"] == "shows frame 4");
    CHECK(events[2]["args"] == Json{{"first_cycle", 400}, {"frame", 4}});
    CHECK(track_of(text, events[2]) == "displays/display 2 screen");
    for (const Json& event : events) CHECK(event["ph"] == "X");
}

TEST_CASE("every kind of slice is written as its table says", "[schedule]") {
    const std::vector<Json> events = events_of(machine(), [](ScheduleTrace& trace) {
        trace.table(1, 7, {0, 0});
        trace.beats(1, 2, 7, 0, 8, 0, {1, 1});
        trace.beats(1, 2, 7, 8, 8, 3, {2, 2});
        trace.page_miss(1, 2, 16, {3, 3});
        trace.refresh(1, {4, 4});
        trace.memory_write(1, {5, 5});
        trace.arbitration(1, {6, 6});
        trace.poll(1, {7, 7});
        trace.lost_slot(1, {8, 8});
        trace.composited(2, 7, {9, 9});
        trace.column_stall(2, 7, {10, 10});
        trace.shown(2, 7, {11, 11});
    });
    REQUIRE(events.size() == tlm::kSliceTable.size());
    for (std::size_t kind = 0; kind < events.size(); ++kind) {
        const tlm::SliceRow& row = tlm::kSliceTable[kind];
        INFO(row.name);
        std::string name(row.name);
        for (char& letter : name) letter = letter == 'F' ? '7' : letter == 'D' ? '2' : letter;
        CHECK(events[kind]["name"] == name);
        CHECK(events[kind].value("cname", "") == row.colour_name);
        CHECK_FALSE(row.meaning.empty());
        std::set<std::string> arguments{"first_cycle"};
        for (const std::string_view argument : row.arguments) arguments.emplace(argument);
        arguments.erase("");
        std::set<std::string> written;
        for (const auto& item : events[kind]["args"].items()) written.insert(item.key());
        CHECK(written == arguments);
    }
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
    struct Level {
        const char* name;
        double microseconds;
        int pixels;
    };
    const std::vector<Level> expected{{"renderer sea, display 1", 0.0, 0},
                                      {"renderer sea, display 2", 0.0, 0},
                                      {"renderer sea, display 1", 0.1, 64},
                                      {"renderer ball, display 1", 0.15, 64},
                                      {"renderer sea, display 1", 0.3, 0}};
    REQUIRE(events.size() == expected.size());
    for (std::size_t n = 0; n < events.size(); ++n) {
        INFO(events[n]);
        CHECK(events[n]["ph"] == "C");
        CHECK(events[n]["name"] == expected[n].name);
        CHECK(events[n]["ts"] == expected[n].microseconds);
        CHECK(events[n]["args"] == Json{{"pixels", expected[n].pixels}});
        CHECK(events[n]["pid"] == 2);
    }
}

TEST_CASE("a span without a clock is left out", "[schedule]") {
    const CycleSpan empty{50, 49};
    CHECK(events_of(machine(), [&](ScheduleTrace& trace) {
              trace.table(1, 0, empty);
              trace.beats(1, 1, 0, 0, 0, 0, empty);
              trace.page_miss(1, 1, 0, empty);
              trace.poll(1, empty);
              trace.lost_slot(1, empty);
              trace.composited(1, 0, empty);
              trace.column_stall(1, 0, empty);
              trace.shown(1, 0, empty);
          }).empty());
}

TEST_CASE("times are the core clock's, to the nanosecond, however late", "[schedule]") {
    // 133.3 MHz: 7502 ps
    const std::string text = text_of(machine(133.3), [](ScheduleTrace& trace) {
        trace.poll(1, {0, 0});                              // 0 to 7.502 ns
        trace.poll(1, {1, 133});                            // 7.502 to 1005.268 ns
        trace.poll(1, {134, 134});                          // 1005.268 to 1012.770 ns
        trace.poll(1, {1'000'000'000, 1'000'000'000});      // 7.502 s
        trace.poll(1, {123'456'789'012, 123'456'789'012});  // 926172831.168024 us
        trace.buffer_level(1, 1, 250, 1);                   // 1875.5 ns
    });
    for (const char* time :
         {R"("ts":0.000,"dur":0.008,)", R"("ts":0.008,"dur":0.997,)", R"("ts":1.005,"dur":0.008,)",
          R"("ts":7502000.000,"dur":0.008,)", R"("ts":926172831.168,"dur":0.008,)", R"("ts":1.876,)"}) {
        INFO(time);
        CHECK(text.find(time) != std::string::npos);
    }
}

TEST_CASE("times are rounded to the nearest nanosecond", "[schedule]") {
    // 0.7 MHz: 1428571 ps
    const std::string text = text_of(machine(0.7), [](ScheduleTrace& trace) {
        trace.buffer_level(1, 1, 169, 1);  // 241428.499 ns
        trace.buffer_level(1, 1, 500, 2);  // 714285.5 ns
        trace.buffer_level(1, 1, 831, 3);  // 1187142.501 ns
    });
    for (const char* time : {R"("ts":241.428,)", R"("ts":714.286,)", R"("ts":1187.143,)"}) {
        INFO(time);
        CHECK(text.find(time) != std::string::npos);
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

TEST_CASE("names are written whatever they are made of", "[schedule]") {
    Scenario scenario = machine();
    scenario.name = "a \"machine\"";
    const std::string name =
        GENERATE(std::string("\"quoted\\ \t{[,]}\""), std::string("\xC3\xA9t\xC3\xA9 \xE6\xB5\xB7"),
                 std::string("\x01\x1F\n"), std::string(700'000, '"'));
    scenario.renderers[1].name = name;
    const std::string text = text_of(scenario, [](ScheduleTrace& trace) {
        trace.poll(2, {0, 0});
        trace.buffer_level(2, 2, 0, 5);
    });
    const std::vector<Json> events = events_of(text);
    REQUIRE(events.size() == 2);
    CHECK((track_of(text, events[0]) == "buses/" + name));
    CHECK((events[1]["name"] == "renderer " + name + ", display 2"));
    CHECK(Json::parse(text)["otherData"]["scenario"] == "a \"machine\"");
}

TEST_CASE("a name stands in the file in its own letters, so that it can be searched", "[schedule]") {
    Scenario scenario = machine();
    const std::string name = "\xC3\xA9t\xC3\xA9 \xE6\xB5\xB7";
    scenario.renderers[1].name = name;
    CHECK(text_of(scenario, kNothing).find(name) != std::string::npos);
}

TEST_CASE("a number is whole wherever in the writer's buffer it comes", "[schedule]") {
    constexpr std::size_t kBufferBytes = std::size_t{1} << 18;
    const auto text_with = [](const std::string& name) {
        Scenario scenario = machine();
        scenario.renderers[0].name = name;
        return text_of(scenario, [](ScheduleTrace& trace) {
            for (int n = 0; n < 50; ++n) trace.poll(2, {1'000'000'000 + n, 1'000'000'000 + n});
        });
    };
    const std::string mark = "(name)";
    const std::string text = text_with(mark);
    const std::size_t at = text.find(mark);
    REQUIRE(at != std::string::npos);
    // The buffer ends among the events, or it is full with a name and the few letters around that.
    std::vector<std::size_t> lengths;
    for (std::size_t n = 0; n < 136; n += 8) lengths.push_back(kBufferBytes - 3000 + n);
    for (std::size_t n = 60; n < 80; ++n) lengths.push_back(kBufferBytes - n);
    for (const std::size_t length : lengths) {
        INFO(length);
        const std::string name(length, 'n');
        std::string expected = text;
        CHECK((text_with(name) == expected.replace(at, mark.size(), name)));
    }
}

TEST_CASE("a name that is not UTF-8 is repaired, not refused", "[schedule]") {
    Scenario scenario = machine();
    scenario.name = "\xFF";
    scenario.renderers[0].name =
        "s\xE9"
        "a";
    const std::string text = text_of(scenario, [](ScheduleTrace& trace) { trace.poll(1, {0, 0}); });
    CHECK(track_of(text, events_of(text)[0]) ==
          "buses/s\xEF\xBF\xBD"
          "a");
    CHECK(Json::parse(text)["otherData"]["scenario"] == "\xEF\xBF\xBD");
}

TEST_CASE("a long schedule is whole", "[schedule]") {
    constexpr int kBursts = 20'000;  // several times the buffer
    const std::vector<Json> events = events_of(machine(), [](ScheduleTrace& trace) {
        for (int n = 0; n < kBursts; ++n) {
            trace.beats(1 + n % 2, 1, n, 64LL * n, 64, n % 3, {32LL * n, 32LL * n + 31});
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
        trace.poll(1, {0, 99});
        trace.poll(1, {200, 299});
        trace.beats(1, 2, 7, 1024, 64, 3, {90, 109});
        trace.poll(1, {110, 110});
        trace.page_miss(1, 2, 4096, {199, 205});
        trace.composited(2, 4, {50, 299});
        trace.table(2, 0, {100, 199});
    });
    const std::vector<Json> events = events_of(text);
    REQUIRE(events.size() == 5);
    CHECK(events[0]["name"] == "display 2, recovered");
    CHECK(events[0]["ts"] == 1.0);
    CHECK(events[0]["dur"] == 0.1);
    CHECK(events[0]["args"] == Json{{"first_cycle", 100},
                                    {"whole_first_cycle", 90},
                                    {"whole_last_cycle", 109},
                                    {"frame", 7},
                                    {"first_pixel", 1024},
                                    {"pixels", 64},
                                    {"recovered_slots", 3}});
    CHECK(events[1]["name"] == "poll");
    CHECK(events[1]["args"] == Json{{"first_cycle", 110}});
    CHECK(events[2]["ts"] == 1.99);
    CHECK(events[2]["dur"] == 0.01);
    CHECK(events[2]["args"]["first_cycle"] == 199);
    CHECK(events[2]["args"]["whole_first_cycle"] == 199);
    CHECK(events[2]["args"]["whole_last_cycle"] == 205);
    CHECK(events[3]["ts"] == 1.0);
    CHECK(events[3]["dur"] == 1.0);
    CHECK(events[3]["args"] ==
          Json{{"first_cycle", 100}, {"whole_first_cycle", 50}, {"whole_last_cycle", 299}, {"frame", 4}});
    CHECK(events[4]["args"] == Json{{"first_cycle", 100}, {"frame", 0}});
    const Json facts = Json::parse(text)["otherData"];
    CHECK(facts["core_cycles"] == 1000);
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
    std::vector<Json> levels;
    for (const Json& event : events) {
        levels.push_back({event["name"], event["ts"], event["args"]["pixels"]});
    }
    CHECK(levels == std::vector<Json>{{"renderer ball, display 1", 1.0, 44},
                                      {"renderer ball, display 1", 1.2, 24},
                                      {"renderer ball, display 2", 1.0, 9},
                                      {"renderer ball, display 2", 1.99, 8},
                                      {"renderer sea, display 2", 1.5, 0},
                                      {"renderer sea, display 1", 1.0, 30}});
}

TEST_CASE("a window of one clock has what happens in it and the level of every buffer", "[schedule]") {
    const std::vector<Json> events = events_of(machine(), [](ScheduleTrace& trace) {
        trace.show_only({100, 100});
        trace.buffer_level(1, 1, 50, 7);
        trace.buffer_level(2, 2, 99, 30);
        trace.poll(1, {90, 110});
    });
    REQUIRE(events.size() == 3);
    CHECK(events[0]["name"] == "poll");
    CHECK(events[0]["dur"] == 0.01);
    CHECK(events[1]["name"] == "renderer ball, display 1");
    CHECK(events[1]["ts"] == 1.0);
    CHECK(events[1]["args"]["pixels"] == 7);
    CHECK(events[2]["name"] == "renderer sea, display 2");
    CHECK(events[2]["ts"] == 1.0);
    CHECK(events[2]["args"]["pixels"] == 30);
}

TEST_CASE("a window that has only the levels it begins with is one in which nothing happens", "[schedule]") {
    const ScratchDirectory scratch;
    const auto shows = [&scratch](std::int64_t cycle) {
        ScheduleTrace trace(scratch / "schedule.json", machine());
        trace.show_only({100, 199});
        trace.buffer_level(1, 1, 50, 7);
        trace.buffer_level(2, 1, cycle, 9);
        return trace.finish(1000).has_value();
    };
    CHECK_FALSE(shows(100));
    CHECK(scratch.names().empty());
    CHECK(shows(101));
    CHECK(scratch.names() == std::vector<std::string>{"schedule.json"});
}

TEST_CASE("a window that reaches over the run's end shows what is left, and one after it nothing",
          "[schedule]") {
    const ScratchDirectory scratch;
    constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();
    const auto shown = [&scratch](CycleSpan window, CycleSpan poll) {
        ScheduleTrace trace(scratch / "schedule.json", machine());
        trace.show_only(window);
        trace.poll(1, poll);
        return trace.finish(1000);
    };
    CHECK_FALSE(shown({1000, kForever}, {0, 2000}));
    CHECK_FALSE(shown({0, 99}, {100, 200}));
    CHECK(scratch.names().empty());

    const auto span = shown({900, kForever}, {950, 960});
    REQUIRE(span);
    CHECK(span->first == 900);
    CHECK(span->last == 999);
    CHECK(Json::parse(content(scratch / "schedule.json"))["otherData"]["window_last_cycle"] == 999);
}

TEST_CASE("the file gets its name when it is complete", "[schedule]") {
    const ScratchDirectory scratch;
    const fs::path file = scratch / "schedule.json";
    write_file(file, "the old one");
    auto trace = std::make_unique<ScheduleTrace>(file, machine());
    trace->poll(1, {0, 9});
    CHECK(scratch.names().size() == 2);  // one has its temporary name
    CHECK(content(file) == "the old one");

    SECTION("finished") {
        trace->finish(10);
        CHECK(scratch.names() == std::vector<std::string>{"schedule.json"});
        CHECK(events_of(content(file)).size() == 1);
        trace.reset();
        CHECK(scratch.names() == std::vector<std::string>{"schedule.json"});
    }
    SECTION("given up") {
        trace.reset();
        CHECK(scratch.names() == std::vector<std::string>{"schedule.json"});
        CHECK(content(file) == "the old one");
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

TEST_CASE("a schedule that cannot be written is reported in one line", "[schedule]") {
    const ScratchDirectory scratch;
    const auto open = [](const fs::path& file) {
        return failure_of<OutputError>([&] { ScheduleTrace(file, machine()); });
    };

    SECTION("the folder does not exist") {
        const fs::path file = scratch / "missing/schedule.json";
        CHECK(open(file) == "cannot write '" + file.string() + "': No such file or directory");
    }
    SECTION("a file stands where the folder should be") {
        write_file(scratch / "plain", "kept");
        const fs::path file = scratch / "plain/schedule.json";
        CHECK(open(file) == "cannot write '" + file.string() + "': Not a directory");
        CHECK(content(scratch / "plain") == "kept");
    }
    SECTION("a folder stands where the file should be") {
        const fs::path file = scratch / "schedule.json";
        fs::create_directories(file / "inside");
        CHECK(open(file) == "cannot write '" + file.string() + "': Is a directory");
        CHECK(scratch.names() == std::vector<std::string>{"schedule.json"});
    }
    SECTION("the folder goes while the run lasts") {
        const fs::path file = scratch / "folder/schedule.json";
        fs::create_directories(scratch / "folder");
        CHECK(failure_of<OutputError>([&] {
                  ScheduleTrace trace(file, machine());
                  fs::remove_all(scratch / "folder");
                  trace.finish(1);
              }) == "cannot write '" + file.string() + "': No such file or directory");
    }
    SECTION("the disk is full") {
        const int events = GENERATE(1, 20'000);
        const fs::path file = scratch / "schedule.json";
        write_file(file, "the old one");
        const test::FileSizeLimit limit(100);
        CHECK(failure_of<OutputError>([&] {
                  ScheduleTrace trace(file, machine());
                  for (int n = 0; n < events; ++n) trace.poll(1, {n, n});
                  trace.finish(events);
              }) == "cannot write '" + file.string() + "': File too large");
        CHECK(scratch.names() == std::vector<std::string>{"schedule.json"});
        CHECK(content(file) == "the old one");
    }
}
