#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "host/errors.h"
#include "program_run.h"
#include "support/lines.h"
#include "tools/exploration/results_database.h"
#include "tools/program/exit_status.h"
#include "workplace.h"

// `metabuffer sweep`, `size` and `export` from outside: what is run is what `metabuffer run` runs, and what has ended
// stays.

namespace metabuffer::test::exploration_commands_test {
using namespace exploration;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using exploration::text_of;
using test::text_of;

namespace {

/// A sweep over a starved machine: 2 x 40 points.
constexpr const char* kSweep = R"(
scenario: scenario.yaml
set: {memory.page_words: 16, composer.ready_space_pixels: 8}
axes:
  - {key: bus.width_bits, values: [16, 64]}
  - {key: composer.buffer_pixels, range: {from: 20, to: 59, step: 1}}
)";

ProgramResult sweep(const Workplace& work, const std::vector<std::string>& arguments = {}) {
    return run_program(work, std::vector<std::string>{"sweep", "sweep.yaml", "-o", "r.db"} + arguments);
}

/// Starts a sweep in a shell, which then does something to it.
ProgramResult sweep_and(const Workplace& work, const std::string& what) {
    return run_script(work, "\"$0\" sweep sweep.yaml -o r.db --processes 2 & " + what);
}

/// Some figures of every point, by its settings.
std::map<std::string, std::vector<Value>> points_of(const Workplace& work, const std::string& file = "r.db") {
    std::map<std::string, std::vector<Value>> points;
    const auto table = ResultsReader(work / file)
                           .results({"bus.width_bits", "composer.buffer_pixels", "status", "starved_pixels",
                                     "core_cycles", "bursts"},
                                    "");
    for (const auto& row : table.rows) {
        points[text_of(row[0]) + " " + text_of(row[1])] = {row.begin() + 2, row.end()};
    }
    return points;
}

std::size_t rows_in(const Workplace& work, const std::string& file = "r.db") {
    return ResultsReader(work / file).results().rows.size();
}

/// The same for a sweep that was killed, perhaps before it had made its tables; a reader then reports that there is
/// nothing.
std::size_t rows_left_in(const Workplace& work) {
    try {
        return rows_in(work);
    } catch (const InputError& error) {
        CHECK_THAT(error.what(), Contains("holds no results"));
        return 0;
    }
}

}  // namespace

TEST_CASE("sweep: every point is what run gives for its settings", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    const ProgramResult result = sweep(work);
    CHECK(result.status == kExitDone);
    CHECK(result.err.empty());
    CHECK_THAT(result.out, Contains("80 of 80 points"));
    const auto points = points_of(work);
    REQUIRE(points.size() == 80);
    for (const std::string width : {"16", "64"}) {
        for (const std::string buffer : {"20", "37", "59"}) {
            CAPTURE(width, buffer);
            REQUIRE(work.run({"--no-images", "--quiet", "--set", "memory.page_words=16", "--set",
                              "composer.ready_space_pixels=8", "--set", "bus.width_bits=" + width, "--set",
                              "composer.buffer_pixels=" + buffer})
                        .status == kExitDone);
            const auto report = work.report();
            const std::vector<Value> expected{std::string("done"),
                                              report["totals"]["starved_pixels"].get<std::int64_t>(),
                                              report["core_cycles"].get<std::int64_t>(),
                                              report["totals"]["bus"]["bursts"].get<std::int64_t>()};
            CHECK(points.at(width + " " + buffer) == expected);
        }
    }
    // Nothing but the results, and nothing to be done the next time.
    CHECK_FALSE(work.exists("r.db-wal"));
    CHECK_FALSE(work.exists("r.db.lock"));
    CHECK_THAT(sweep(work).out, Contains("80 points were there already"));
}

TEST_CASE("sweep: a colour table is one of its inputs, and results of another table are not gone on with",
          "[program][sweep]") {
    const Workplace work;
    const auto write_table = [&work](const std::string& row) {
        std::string table;
        for (int v = 0; v < 256; ++v) table += row + "\n";
        work.write("t.csv", table);
    };
    write_table("1,2,3");
    work.write("sweep.yaml",
               "scenario: scenario.yaml\n"
               "set: {displays.correction: [{display: 1, lut: t.csv}]}\n"
               "axes: [{key: composer.buffer_pixels, values: [100, 200]}]\n");
    REQUIRE(sweep(work).status == kExitDone);
    CHECK_THAT(sweep(work).out, Contains("2 points were there already"));
    write_table("1,2,4");
    const ProgramResult changed = sweep(work);
    CHECK(changed.status == kExitBadInput);
    CHECK(changed.complains_in_one_line());
    CHECK_THAT(changed.err, Contains("t.csv"));
}

TEST_CASE("sweep: level rtl gives the same figures, and its results are apart from those of level tlm",
          "[program][sweep][repeat]") {
    const Workplace work;
    work.write(
        "sweep.yaml",
        "scenario: scenario.yaml\n"
        "axes: [{key: bus.width_bits, values: [16, 64]}, {key: composer.buffer_pixels, values: [20, 59]}]\n");
    REQUIRE(sweep(work).status == kExitDone);
    REQUIRE(run_program(work, {"sweep", "sweep.yaml", "-o", "rtl.db", "--level", "rtl"}).status == kExitDone);
    const auto points = points_of(work, "rtl.db");
    CHECK(points.size() == 4);
    CHECK(points == points_of(work));
    const ResultsReader results(work / "rtl.db");
    CHECK(results.identity().level == "rtl");
    CHECK(ResultsReader(work / "r.db").identity().level == "tlm");
    const ProgramResult mixed = sweep(work, {"--level", "rtl"});
    CHECK(mixed.status == kExitBadInput);
    CHECK_THAT(mixed.err, Contains("of level tlm instead of level rtl"));
    CHECK(points_of(work) == points);
}

TEST_CASE("size: level rtl finds the value that level tlm finds", "[program][sweep][repeat]") {
    const Workplace work;
    const auto size = [&work](const std::string& level) {
        return run_program(work, {"size", "scenario.yaml", "--minimize", "composer.buffer_pixels=16..200",
                                  "--checks", "2", "--level", level, "--quiet"});
    };
    const ProgramResult rtl = size("rtl");
    CHECK(rtl.status == kExitDone);
    CHECK(rtl.out == size("tlm").out);
    const ProgramResult functional = size("functional");
    CHECK(functional.status == kExitBadInput);
    CHECK_THAT(functional.err, Contains("--level") && Contains("rtl"));
}

TEST_CASE("sweep: after kill -9 the same command goes on and the results are those of an undisturbed sweep",
          "[program][sweep]") {
    Workplace work;
    work.write("sweep.yaml", kSweep);
    REQUIRE(sweep(work, {"--quiet"}).status == kExitDone);
    const auto expected = points_of(work);
    std::filesystem::remove(work / "r.db");
    std::size_t kept = 0;
    for (const char* moment : {"0.35", "0.4", "0.5"}) {
        sweep_and(work, std::string("sleep ") + moment + "; kill -9 $!; wait");
        if (!work.exists("r.db")) continue;  // killed before there was anything
        const std::size_t rows = rows_left_in(work);
        CHECK(rows >= kept);
        kept = rows;
    }
    CHECK(sweep(work).status == kExitDone);
    CHECK(points_of(work) == expected);
}

TEST_CASE("sweep: a signal to stop ends it in order", "[program][sweep]") {
    const Workplace work;
    std::string many = kSweep;
    many.replace(many.find("to: 59"), 6, "to: 9000");
    work.write("sweep.yaml", many);
    // Once a point has ended, however slow the machine is: its settings and its status are in the journal or the file.
    const ProgramResult stopped = sweep_and(
        work, "until grep -aFqs '\"}done' r.db r.db-wal; do sleep 0.05; done; kill -TERM $!; wait $!");
    CHECK(stopped.status == kExitStopped);
    CHECK_THAT(stopped.err, Contains("the same command goes on from here"));
    CHECK_FALSE(work.exists("r.db-wal"));
    CHECK_FALSE(work.exists("r.db.lock"));
    CHECK(rows_in(work) > 0);
}

TEST_CASE("sweep: points that fail are kept with their reasons", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml",
               "scenario: scenario.yaml\naxes:\n"
               "  - {key: name, values: [good, crash, exit, error, exception, input, watchdog]}\n");
    const ProgramResult result =
        run_program(METABUFFER_FAULTY_PROGRAM, work, {"sweep", "sweep.yaml", "-o", "r.db"});
    CHECK(result.status == kExitDone);
    CHECK_THAT(result.out, Contains("told to throw"));
    const std::string line =
        "6 of 7 points without a result: 1 invalid, 1 watchdog, 2 failed, 2 crashed; the column reason says "
        "why\n";
    CHECK(result.err == line);
    const ProgramResult strict = run_program(METABUFFER_FAULTY_PROGRAM, work,
                                             {"sweep", "sweep.yaml", "-o", "s.db", "--quiet", "--strict"});
    CHECK(strict.status == kExitStrict);
    CHECK(strict.out.empty());
    CHECK(strict.err == line);
    std::map<std::string, std::pair<std::string, std::string>> outcomes;
    for (const auto& row : ResultsReader(work / "r.db").results({"name", "status", "reason"}, "").rows) {
        outcomes[text_of(row[0])] = {text_of(row[1]), text_of(row[2])};
    }
    REQUIRE(outcomes.size() == 7);
    CHECK(outcomes["good"].first == "done");
    CHECK(outcomes["crash"] ==
          std::pair<std::string, std::string>("crashed", "its process ended by a signal: Aborted"));
    CHECK(outcomes["exit"].first == "crashed");
    CHECK(outcomes["error"].first == "failed");
    CHECK_THAT(outcomes["error"].second, Contains("metabuffer/test: told to fail"));
    CHECK(outcomes["exception"].first == "failed");
    CHECK(outcomes["input"] == std::pair<std::string, std::string>("invalid", "told to refuse"));
    CHECK(outcomes["watchdog"].first == "watchdog");
    CHECK_THAT(outcomes["watchdog"].second, Contains("composer_1_1 waits for a pixel"));
}

TEST_CASE("sweep: a scenario that no point makes valid is bad input", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    work.write("scenario.yaml", std::string(kScenario) + "frams: 2\n");
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"sweep", "sweep.yaml", "--quiet", "-o", "r.db"},
          std::vector<std::string>{"size", "scenario.yaml", "--quiet", "--minimize",
                                   "composer.buffer_pixels=1..99"}}) {
        const ProgramResult result = run_program(work, command);
        CHECK(result.status == kExitBadInput);
        CHECK(result.complains_in_one_line());
        CHECK_THAT(result.err, Contains("scenario.yaml:") && Contains("the nearest is frames"));
    }
}

TEST_CASE("sweep: the list has every point in order and runs nothing", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", std::string(kSweep) + "filter: composer.buffer_pixels >= bus.width_bits\n");
    const ProgramResult result = run_program(work, {"sweep", "sweep.yaml", "--list"});
    CHECK(result.status == kExitDone);
    const std::vector<std::string> lines = lines_of(result.out);
    REQUIRE(lines.size() == 40);  // 16 bits all of them, 64 bits none
    CHECK(lines.front() == "bus.width_bits=16 composer.buffer_pixels=20");
    CHECK(lines.back() == "bus.width_bits=16 composer.buffer_pixels=59");
    CHECK_FALSE(work.exists("out"));
}

TEST_CASE("sweep: changed input does not get mixed into old results", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    REQUIRE(sweep(work, {"--quiet"}).status == kExitDone);
    // More values are fine.
    std::string more = kSweep;
    more.replace(more.find("to: 59"), 6, "to: 61");
    work.write("sweep.yaml", more);
    CHECK_THAT(sweep(work).out, Contains("84 of 84 points") && Contains("80 points were there already"));
    const std::string before = text_of(work / "r.db");
    work.write("scenario.yaml", std::string(kScenario) + "frames: 1\n");
    const ProgramResult refused = sweep(work);
    CHECK(refused.status == kExitBadInput);
    CHECK(refused.complains_in_one_line());
    CHECK_THAT(refused.err, StartsWith("'r.db' holds results of other input"));
    CHECK(text_of(work / "r.db") == before);
}

TEST_CASE("sweep: pictures are those that run writes", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml",
               "scenario: scenario.yaml\npictures: true\naxes:\n"
               "  - {key: renderers.1.frames.0.viewport.multiple, values: [1, 3]}\n");
    REQUIRE(sweep(work, {"--quiet"}).status == kExitDone);
    const ResultsReader results(work / "r.db");
    const auto rows = results.results({"run"}, "\"renderers.1.frames.0.viewport.multiple\" = 3").rows;
    REQUIRE(rows.size() == 1);
    const auto pictures = results.pictures(std::get<std::int64_t>(rows[0][0]));
    REQUIRE(pictures.size() == 2);
    REQUIRE(work.run({"--quiet", "--set", "renderers.1.frames.0.viewport.multiple=3"}).status == kExitDone);
    CHECK(pictures[0].second == text_of(work / "out" / "display_1.png"));
    CHECK(pictures[1].second == text_of(work / "out" / "display_2.png"));
}

TEST_CASE("size: the smallest value is the one that trying all of them finds", "[program][size][repeat]") {
    const Workplace work;
    const std::vector<std::string> settings{"--set", "memory.page_words=16", "--set",
                                            "composer.ready_space_pixels=8"};
    const ProgramResult found = run_program(
        work,
        std::vector<std::string>{"size", "scenario.yaml", "--minimize", "composer.buffer_pixels=1..200",
                                 "--over", "bus.width_bits=32,64,256", "--checks", "200", "-o", "size.db"} +
            settings);
    CHECK(found.status == kExitDone);
    work.write("sweep.yaml",
               "scenario: scenario.yaml\n"
               "set: {memory.page_words: 16, composer.ready_space_pixels: 8}\n"
               "axes:\n"
               "  - {key: bus.width_bits, values: [32, 64, 256]}\n"
               "  - {key: composer.buffer_pixels, range: {from: 1, to: 200, step: 1}}\n");
    REQUIRE(sweep(work, {"--quiet"}).status == kExitDone);
    const ResultsReader all(work / "r.db");
    const auto rows = ResultsReader(work / "size.db")
                          .results({"bus.width_bits", "smallest", "monotonic", "status"}, "")
                          .rows;
    REQUIRE(rows.size() == 3);
    int found_values = 0;
    for (const auto& row : rows) {
        const std::string width = "bus.width_bits = " + text_of(row[0]);
        CAPTURE(width);
        std::vector<std::int64_t> good;
        std::vector<std::int64_t> bad;
        for (const auto& point :
             all.results({"composer.buffer_pixels", "starved_pixels = 0 and rejected_rows = 0"}, width)
                 .rows) {
            (text_of(point[1]) == "1" ? good : bad).push_back(std::get<std::int64_t>(point[0]));
        }
        REQUIRE(good.size() + bad.size() == 200);
        if (good.empty()) {
            CHECK(row[1] == Value());
            CHECK(text_of(row[3]) == "unmet");
            continue;
        }
        ++found_values;
        const std::int64_t smallest = *std::min_element(good.begin(), good.end());
        CHECK(row[1] == Value(smallest));
        CHECK_THAT(found.out, Contains(std::to_string(smallest)));
        // As many checks as there are values: every one above it that is bad was seen.
        const bool is_monotonic = bad.empty() || *std::max_element(bad.begin(), bad.end()) < smallest;
        CHECK(text_of(row[2]) == (is_monotonic ? "1" : "0"));
    }
    CHECK(found_values > 0);  // the narrower buses starve with any of these buffers
}

/// "width pixels;" of each line of a printed front.
std::string front_rows(const std::string& table) {
    std::string rows;
    const std::vector<std::string> lines = lines_of(table);
    for (std::size_t n = 1; n < lines.size(); ++n) {
        std::istringstream words(lines[n]);
        std::string width;
        std::string pixels;
        words >> width >> pixels;
        rows += width + " " + pixels + ";";
    }
    return rows;
}

/// Tries all of a grid: the front is what no other machine undercuts in both keys.
TEST_CASE("size: two keys give the front that trying all of them gives", "[program][size][repeat]") {
    const Workplace work;
    const std::string sweep =
        "scenario: scenario.yaml\nset: {memory.words_per_cycle: 1, composer.ready_space_pixels: 16, "
        "bus.burst_pixels: 16}\naxes:\n  - {key: bus.width_bits, values: [16, 32, 64]}\n"
        "  - {key: composer.buffer_pixels, range: {from: 20, to: 400, step: 4}}\n";
    work.write("grid.yaml", sweep);
    REQUIRE(run_program(work, {"sweep", "grid.yaml", "-o", "grid.db", "--quiet"}).status == kExitDone);
    std::map<std::int64_t, std::int64_t> smallest;  // buffer by width
    for (const auto& row :
         ResultsReader(work / "grid.db")
             .results({"bus.width_bits", "min(composer.buffer_pixels, 100000)"}, exploration::default_goal())
             .rows) {
        const auto width = std::get<std::int64_t>(row[0]);
        const auto pixels = std::get<std::int64_t>(row[1]);
        const auto known = smallest.find(width);
        if (known == smallest.end() || pixels < known->second) smallest[width] = pixels;
    }
    std::string expected;
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (const auto& [width, pixels] : smallest) {
        if (pixels >= least) continue;
        least = pixels;
        expected += std::to_string(width) + " " + std::to_string(pixels) + ";";
    }
    REQUIRE(!expected.empty());
    const ProgramResult result =
        run_program(work, {"size", "scenario.yaml", "--set", "memory.words_per_cycle=1", "--set",
                           "composer.ready_space_pixels=16", "--set", "bus.burst_pixels=16", "--minimize",
                           "bus.width_bits=16..64", "--minimize",
                           "composer.buffer_pixels=" +
                               [] {
                                   std::string values;
                                   for (int pixels = 20; pixels <= 400; pixels += 4)
                                       values += (values.empty() ? "" : ",") + std::to_string(pixels);
                                   return values;
                               }(),
                           "--checks", "400", "--quiet"});
    INFO(result.out << result.err);
    REQUIRE(result.status == kExitDone);
    CHECK(front_rows(result.out) == expected);
}

/// Whichever key comes first: each corner is found from both sides.
TEST_CASE("size: the front of two keys is the same in either order, and a setting without one has a line",
          "[program][size][repeat]") {
    const Workplace work;
    const std::string scenario = std::string(METABUFFER_SOURCE_DIRECTORY) + "/scenarios/case-4.yaml";
    const auto front = [&](const std::string& first, const std::string& second) {
        const ProgramResult result = run_program(
            work, {"size", scenario, "--minimize", first, "--minimize", second, "--checks", "4", "--quiet"});
        CHECK(result.status == kExitDone);
        std::set<std::pair<int, int>> corners;
        for (const std::string& line : lines_of(result.out)) {
            std::istringstream words(line);
            int one = 0;
            int other = 0;
            if (words >> one >> other) corners.insert({one, other});
        }
        return corners;
    };
    const auto forth = front("bus.burst_pixels=1..64", "composer.buffer_pixels");
    std::set<std::pair<int, int>> turned;
    for (const auto& [one, other] : front("composer.buffer_pixels", "bus.burst_pixels=1..64")) {
        turned.insert({other, one});
    }
    CHECK(forth.size() > 5);
    CHECK((forth == turned));

    const ProgramResult slow =
        run_program(work, {"size", scenario, "--minimize", "bus.burst_pixels=8..16", "--minimize",
                           "composer.buffer_pixels", "--over", "clocks.dvi_out_mhz=5,100", "--frames", "3",
                           "--frame-rate-hz", "300", "--quiet"});
    INFO(slow.out << slow.err);
    CHECK(slow.status == kExitDone);
    const std::vector<std::string> lines = lines_of(slow.out);
    REQUIRE(lines.size() >= 3);
    CHECK_THAT(lines[1], Contains(" 5 ") && Contains("unmet") && Contains("too slow for it: the displays"));
    CHECK_THAT(lines[2], Contains(" 100 ") && !Contains("unmet"));
}

TEST_CASE("size: what arithmetic shows is not run, and stalling columns are reported", "[program][size]") {
    const Workplace work;
    const std::vector<std::string> search{"size",       "scenario.yaml",
                                          "--minimize", "composer.buffer_pixels",
                                          "--frames",   "4",
                                          "--set",      "clocks.dvi_out_refresh_hz=1000"};
    const ProgramResult hopeless =
        run_program(work, search + std::vector<std::string>{"--frame-rate-hz", "1100"});
    CHECK_THAT(hopeless.out,
               Contains("no composer.buffer_pixels brings 1100 frames/s: too slow for it: the displays"));
    CHECK_THAT(hopeless.out, Contains(", 0 simulations"));
    const ProgramResult met = run_program(work, search);
    CHECK_THAT(met.out, Contains("is too little and more than"));
    CHECK_THAT(met.out, Contains("with on_starvation: stall, whole pictures and at the same rate:\n"));
    CHECK_THAT(met.out, Contains("bottleneck") && Contains("stalled clocks"));
    const ProgramResult quiet = run_program(work, search + std::vector<std::string>{"--quiet"});
    CHECK_THAT(quiet.out, !Contains("stall"));
    const ProgramResult clock = run_program(
        work, {"size", "scenario.yaml", "--minimize", "clocks.core_mhz=0.5..100+0.5", "--frames", "4",
               "--set", "clocks.dvi_out_refresh_hz=5000", "--frame-rate-hz", "5000", "--quiet"});
    INFO(clock.out);
    std::istringstream words(lines_of(clock.out).at(1));
    double mhz = 0.0;
    words >> mhz;
    CHECK(mhz > 0.5);
    CHECK(mhz < 100.0);
    CHECK(mhz * 2 == std::floor(mhz * 2));
}

/// A page miss of one clock more is enough to make the cheapest answer of case-4 with a bus of 64 bits starve.
TEST_CASE("size: an answer with a margin holds at every move, and no smaller one does", "[program][size]") {
    const Workplace work;
    const std::string scenario = std::string(METABUFFER_SOURCE_DIRECTORY) + "/scenarios/case-4.yaml";
    const auto starves = [&](int buffer_pixels, const std::string& move) {
        const ProgramResult run = run_program(
            work, {"run", scenario, "--no-images", "--strict", "--quiet", "--set", "bus.width_bits=64",
                   "--set", "composer.buffer_pixels=" + std::to_string(buffer_pixels), "--set", move});
        INFO(run.err);
        CHECK((run.status == kExitDone || run.status == kExitStrict));
        return run.status == kExitStrict;
    };
    const auto answer = [&](const std::vector<std::string>& options, const std::string& begin) {
        const ProgramResult result = run_program(
            work, std::vector<std::string>{"size", scenario, "--minimize", "composer.buffer_pixels", "--over",
                                           "bus.width_bits=64"} +
                      options);
        INFO(result.out << result.err);
        CHECK(result.status == kExitDone);
        const std::vector<std::string> lines = lines_of(result.out);
        const auto table = std::find_if(lines.begin(), lines.end(), [&begin](const std::string& line) {
            return line.rfind(begin, 0) == 0;
        });
        REQUIRE(lines.end() - table > 2);
        std::istringstream words(table[2]);
        int width = 0;
        int pixels = 0;
        double cost = 0.0;
        int steps = -1;
        words >> width >> pixels >> cost >> steps;
        return std::tuple(pixels, steps, table[2]);
    };
    const auto [edge, edge_steps, edge_line] = answer({}, "margin, in ");
    CHECK(edge_steps == 0);
    CHECK_THAT(edge_line, Contains("page_miss_cycles 6 to 7: starved_pixels "));
    CHECK_FALSE(starves(edge, "memory.page_miss_cycles=6"));
    CHECK(starves(edge, "memory.page_miss_cycles=7"));

    const auto [safe, safe_steps, safe_line] = answer({"--margin", "2", "--quiet"}, "margin, in ");
    CHECK(safe_steps == 2);
    for (const char* const move :
         {"memory.page_miss_cycles=7", "memory.page_miss_cycles=8", "clocks.core_mhz=99.9",
          "clocks.core_mhz=100.1", "clocks.core_mhz=99", "clocks.core_mhz=101", "clocks.dvi_in_mhz=99.9",
          "clocks.dvi_in_mhz=100.1", "clocks.dvi_in_mhz=99", "clocks.dvi_in_mhz=101", "clocks.dvi_out_mhz=99",
          "clocks.dvi_out_mhz=101"}) {
        CAPTURE(move);
        CHECK_FALSE(starves(safe, move));
    }
    CHECK(starves(safe - 1, "memory.page_miss_cycles=8"));
    CHECK(safe_line != edge_line);
}

TEST_CASE("size: the front of two keys is kept, a row for each corner", "[program][size]") {
    const Workplace work;
    const std::string scenario = std::string(METABUFFER_SOURCE_DIRECTORY) + "/scenarios/case-4.yaml";
    const ProgramResult result =
        run_program(work, {"size", scenario, "--minimize", "bus.width_bits=32..128", "--minimize",
                           "composer.buffer_pixels", "--quiet", "-o", "front.db"});
    INFO(result.out << result.err);
    REQUIRE(result.status == kExitDone);
    std::string kept;
    for (const auto& row : ResultsReader(work / "front.db")
                               .results({"bus.width_bits", "composer.buffer_pixels", "whole"}, "")
                               .rows) {
        kept += text_of(row[0]) + " " + text_of(row[1]) + ";";
        CHECK(text_of(row[2]) == "1");
    }
    CHECK(kept == front_rows(result.out));
    CHECK(std::count(kept.begin(), kept.end(), ';') > 1);
}

/// The displays limit the rate, whatever the machine could do. The first frame does not wait for them, so two frames
/// can follow each other sooner than displays are refreshed.
TEST_CASE("size: a frame rate is met up to the displays' own and never beyond it", "[program][size]") {
    const Workplace work;
    const auto answer = [&work](const std::string& frame_rate_hz) {
        const ProgramResult result =
            run_program(work, {"size", "scenario.yaml", "--minimize", "composer.buffer_pixels=200..400",
                               "--frames", "4", "--set", "clocks.dvi_out_refresh_hz=1000", "--quiet",
                               "--checks", "0", "--frame-rate-hz", frame_rate_hz});
        INFO(result.err);
        CHECK(result.status == kExitDone);
        return result.out;
    };
    CHECK_THAT(answer("1000"), !Contains("unmet"));
    CHECK_THAT(answer("1002"), Contains("unmet"));
}

TEST_CASE("size: wrong arguments are reported in a line and leave nothing", "[program][size][repeat]") {
    check_refused_commands(
        Workplace(), "size scenario.yaml --minimize ",
        {{"composer.bufer_pixels", {"the nearest is composer.buffer_pixels"}},
         {"composer.buffer_pixels=9..3", {"use from at most to"}},
         {"composer.buffer_pixels=few", {"is not a number"}},
         {"composer.buffer_pixels=1.5..9", {"1.5 is not a whole number"}},
         {"clocks.core_mhz=60,70", {"use FROM..TO+STEP"}},
         {"composer.buffer_pixels --minimize composer.buffer_pixels", {"is given twice"}},
         {"composer.buffer_pixels --minimize bus.width_bits -o scenario.yaml",
          {"-o scenario.yaml: is there already"}},
         {"composer.buffer_pixels --margin 4", {"--margin"}},
         {"bus.width_bits --minimize bus.burst_pixels --minimize frames", {"3 keys"}},
         {"bus.arbitration", {"does not hold a number"}},
         {"composer.buffer_pixels --over bus.width_bits", {"has no values"}},
         {"composer.buffer_pixels --over bus.widht_bits=64", {"the nearest is bus.width_bits"}},
         {"composer.buffer_pixels --goal starved", {"--goal starved: 'starved' is not known"}},
         {"composer.buffer_pixels --goal starved_pixels=", {"--goal starved_pixels="}},
         {"composer.buffer_pixels -o scenario.yaml", {"scenario.yaml"}},
         {"composer.buffer_pixels --frame-rate-hz 60",
          {"--frame-rate-hz: a run of 2 frames has no rate; use --frames 3 or more"}},
         {"composer.buffer_pixels --frame-rate-hz 60 --over frames=3,1",
          {"--frame-rate-hz: a run of 1 frame has no rate"}}});
}

TEST_CASE("export: rows are the points and conditions choose among them", "[program][export]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    REQUIRE(sweep(work, {"--quiet"}).status == kExitDone);
    const ProgramResult all = run_program(work, {"export", "r.db"});
    CHECK(all.status == kExitDone);
    CHECK(lines_of(all.out).size() == 81);
    const ProgramResult some = run_program(work, {"export", "r.db", "--format", "json", "--where",
                                                  "bus.width_bits = 64 and composer.buffer_pixels < 23",
                                                  "--columns", "composer.buffer_pixels,starved_pixels"});
    CHECK(some.status == kExitDone);
    const auto json = nlohmann::json::parse(some.out);
    REQUIRE(json.size() == 3);
    CHECK(json[0]["composer.buffer_pixels"] == 20);
    CHECK(json[2]["composer.buffer_pixels"] == 22);
    CHECK(json[1]["starved_pixels"].is_number_integer());
}

TEST_CASE("report: a page that holds the points and their reports", "[program][report]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    REQUIRE(sweep(work, {"--quiet"}).status == kExitDone);
    const ProgramResult result =
        run_program(work, {"report", "r.db", "-o", "page.html", "--title", "Two <buses>"});
    CHECK(result.status == kExitDone);
    CHECK(result.err.empty());
    const std::string page = text_of(work / "page.html");
    CHECK_THAT(page, Contains("Two &lt;buses&gt;") && !Contains("Two <buses>"));
    CHECK_THAT(page, Contains("composer.buffer_pixels"));
    // The same results make the same page.
    REQUIRE(run_program(work, {"report", "r.db", "-o", "again.html", "--title", "Two <buses>"}).status ==
            kExitDone);
    CHECK(text_of(work / "again.html") == page);
}

TEST_CASE("plot: a chart as SVG and as PNG", "[program][plot][repeat]") {
    const Workplace work;
    // Three frames, since the front's usual y is the frame rate.
    work.write("scenario.yaml", std::string(kScenario) + R"(
  - name: third frame
    frames:
      - {image: a.png, z: 0, viewport: {x: 3, y: 2, multiple: 1}}
      - {image: a.png, z: 0, viewport: {x: 4, y: 2, multiple: 1}}
      - {image: a.png, z: 0, viewport: {x: 5, y: 2, multiple: 1}}
)");
    work.write("sweep.yaml", kSweep);
    REQUIRE(sweep(work, {"--quiet"}).status == kExitDone);
    for (const std::string chart : {"lines", "heatmap", "pareto", "policy", "histogram", "scatter"}) {
        CAPTURE(chart);
        const ProgramResult result =
            run_program(work, {"plot", "r.db", "-o", chart + ".svg", "--chart", chart});
        CHECK(result.err == "");
        REQUIRE(result.status == kExitDone);
        CHECK_THAT(text_of(work / (chart + ".svg")), StartsWith("<svg"));
    }
    REQUIRE(run_program(work, {"plot", "r.db", "-o", "p.png", "--width", "300", "--height", "200"}).status ==
            kExitDone);
    CHECK_THAT(text_of(work / "p.png"), StartsWith("\x89PNG"));
}

TEST_CASE("report and plot: wrong arguments are reported in a line and leave nothing",
          "[program][report][plot][repeat]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    REQUIRE(sweep(work, {"--quiet"}).status == kExitDone);
    work.write("text.db", "this is no database, but it is long enough to be one if it wanted to be one");
    check_refused_commands(work, "",
                           {{"report r.db", {"-o"}},
                            {"report none.db -o p.html", {"there is no such file"}},
                            {"report text.db -o p.html", {"text.db"}},
                            {"report r.db -o p.html --where starved", {"'starved' is not known"}},
                            {"report r.db -o no/such/folder/p.html", {"no/such/folder/p.html"}},
                            {"plot r.db -o p.jpg", {"p.jpg"}},
                            {"plot r.db -o p.svg --chart pie", {"pie"}},
                            {"plot r.db -o p.svg --x bus.widht_bits", {"the nearest is bus.width_bits"}},
                            {"plot r.db -o p.svg --where bus.width_bits>1000", {"no point"}},
                            {"plot r.db -o p.svg --width 3", {"--width"}},
                            {"plot r.db -o p.svg --chart pareto", {"a run needs three frames"}}});
}

}  // namespace metabuffer::test::exploration_commands_test
