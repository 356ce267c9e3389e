#include "tools/exploration/explorer.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <thread>

#include "host/quiet_fork.h"
#include "support/lines.h"
#include "support/scratch_directory.h"
#include "tools/exploration/figures.h"

// Explorations with a stand-in for the level: what a run does is the scenario's name or its buffer.

using namespace metabuffer;
using namespace metabuffer::exploration;
using metabuffer::test::ScratchDirectory;

namespace {

/// The smallest image whose control scanline holds a table: 12x4 pixels of three bytes.
std::string image() { return "P6\n12 4\n255\n" + std::string(144, '.'); }

constexpr const char* kScenario = R"(
displays: {width: 12, height: 4}
composer: {ready_space_pixels: 2}
bus: {burst_pixels: 2}
renderers:
  - frames: [{image: view.ppm, z: 0, viewport: {x: 0, y: 0}}]
)";

struct Workspace {
    Workspace() {
        directory.write("view.ppm", image());
        directory.write("scenario.yaml", kScenario);
    }
    SweepPlan plan(const std::string& key, const std::vector<std::string>& values) const {
        SweepDescription description;
        description.name = "test";
        description.scenario = directory / "scenario.yaml";
        description.axes.push_back(Axis{{key}, {values}, {"test"}});
        return make_plan(description);
    }
    /// Lines of a file, none if it is not there.
    std::vector<std::string> lines(const std::string& name) const {
        return test::lines_of_file(directory / name);
    }
    ScratchDirectory directory;
};

std::vector<std::string> numbers(int from, int to) {
    std::vector<std::string> values;
    for (int value = from; value <= to; ++value) values.push_back(std::to_string(value));
    return values;
}

ExploreOptions with_processes(int processes) {
    ExploreOptions options;
    options.processes = processes;
    return options;
}

/// A line at a file's end in one write, as several processes do it.
void note(const std::filesystem::path& file, const std::string& line) {
    std::ofstream(file, std::ios::app) << line + "\n" << std::flush;
}

Simulation simulation_of(const Scenario& scenario, std::int64_t core_cycles) {
    Simulation simulation;
    simulation.report.scenario = scenario.name;
    simulation.report.core_cycles = core_cycles;
    simulation.report.core_mhz = scenario.clocks.core_mhz;
    simulation.report.renderers.resize(1);
    simulation.report.composers.resize(1);
    simulation.report.displays.resize(1);
    simulation.report.displays[0].frames_shown = scenario.frames;
    return simulation;
}

Value figure(const RunRecord& run, const std::string& name) {
    return run.figures.at(figure_index(name).value());
}

RunRecord run_of(const ResultsDatabase& results, const PointRecord& point) {
    return results.find_run(point.settings).value().second;
}

/// Starves below the scenario's watchdog_cycles, which stands in for the threshold.
Simulation starving(const Scenario& scenario, bool /*pictures*/) {
    Simulation simulation = simulation_of(scenario, 1);
    const bool starves = scenario.composer.buffer_pixels < scenario.watchdog_cycles;
    simulation.report.composers[0].starved_pixels = starves ? 7 : 0;
    return simulation;
}

/// Aborts without the test framework's message.
void abort_quietly() {
    std::signal(SIGABRT, SIG_DFL);
    std::abort();
}

SearchDescription buffer_search(std::int64_t to) {
    return describe_search("composer.buffer_pixels", 1, static_cast<double>(to), "test");
}

}  // namespace

TEST_CASE("explorer: each simulation is a process of its own") {
    const Workspace work;
    const SweepPlan plan = work.plan("composer.buffer_pixels", numbers(10, 29));
    const Explorer explorer(
        plan, [](const Scenario& scenario, bool /*pictures*/) { return simulation_of(scenario, getpid()); });
    ResultsDatabase results = ResultsDatabase::open(work.directory / "r.db", explorer.identity("1"));
    const Exploration exploration = explorer.run(&results, with_processes(3));
    REQUIRE(exploration.points.size() == 20);
    std::set<std::int64_t> processes;
    const std::vector<Point> points(plan.points.begin(), plan.points.end());
    for (std::size_t n = 0; n < exploration.points.size(); ++n) {
        CHECK(exploration.points[n].settings == points[n].settings);
        processes.insert(
            std::get<std::int64_t>(figure(run_of(results, exploration.points[n]), "core_cycles")));
    }
    CHECK(processes.size() == 20);
    CHECK(processes.count(getpid()) == 0);
    CHECK(exploration.progress.points_ended == 20);
    CHECK(exploration.progress.runs == 20);
}

TEST_CASE("explorer: as many simulations run at once as were asked for and no more") {
    const Workspace work;
    const SweepPlan plan = work.plan("composer.buffer_pixels", numbers(10, 21));
    const std::filesystem::path at_work = work.directory / "at-work";
    std::filesystem::create_directory(at_work);
    const Explorer explorer(plan, [&at_work](const Scenario& scenario, bool /*pictures*/) {
        // Each waits until it has seen three at work, itself among them: with fewer the test would not end.
        const std::filesystem::path own = at_work / std::to_string(getpid());
        const std::filesystem::path seen = at_work.parent_path() / "three-seen";
        std::ofstream(own) << "here";
        std::ptrdiff_t most = 0;
        for (int wait = 0; wait < 10'000 && !std::filesystem::exists(seen); ++wait) {
            std::ptrdiff_t count = 0;
            for (const auto& entry : std::filesystem::directory_iterator(at_work))
                count += entry.exists() ? 1 : 0;
            most = std::max(most, count);
            if (count >= 3) std::ofstream(seen) << "yes";
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        if (!std::filesystem::exists(seen)) throw std::runtime_error("never three at once");
        if (most > 3) throw std::runtime_error("more than three at once");
        std::filesystem::remove(own);
        return simulation_of(scenario, 1);
    });
    for (const PointRecord& point : explorer.run(nullptr, with_processes(3)).points) {
        CHECK(point.status == RunStatus::kDone);
        CHECK(point.reason.empty());
    }
}

TEST_CASE("explorer: a run that fails is a record with its reason and the others go on") {
    const Workspace work;
    const SweepPlan plan = work.plan(
        "name", {"fine", "abort", "leave", "input", "exception", "watchdog", "loop-killed", "also-fine"});
    const Explorer explorer(plan, [](const Scenario& scenario, bool /*pictures*/) {
        Simulation simulation = simulation_of(scenario, 1);
        if (scenario.name == "abort") abort_quietly();
        if (scenario.name == "leave") _exit(EXIT_SUCCESS);
        if (scenario.name == "input") throw InputError("line 3: told to refuse");
        if (scenario.name == "exception") throw std::runtime_error("told\nto throw");
        if (scenario.name == "watchdog") simulation.report.watchdog = {"bus 1 waits", "display 1 waits"};
        if (scenario.name == "loop-killed") kill(getpid(), SIGKILL);
        return simulation;
    });
    ResultsDatabase results = ResultsDatabase::open(work.directory / "r.db", explorer.identity("1"));
    const std::vector<PointRecord> points = explorer.run(&results, with_processes(2)).points;
    REQUIRE(points.size() == 8);
    const auto check = [&points](std::size_t n, RunStatus status, const std::string& reason) {
        CAPTURE(n);
        CHECK(points[n].status == status);
        CHECK(points[n].reason == reason);
    };
    check(0, RunStatus::kDone, "");
    check(1, RunStatus::kCrashed, "its process ended by a signal: Aborted");
    check(2, RunStatus::kCrashed, "its process ended without a report");
    check(3, RunStatus::kInvalid, "line 3: told to refuse");
    check(4, RunStatus::kFailed, "told to throw");
    check(5, RunStatus::kWatchdog, "nothing moved any more: bus 1 waits and display 1 waits");
    check(6, RunStatus::kCrashed, "its process ended by a signal: Killed");
    check(7, RunStatus::kDone, "");
    // A watchdog's run has a report, and one that crashed has none.
    CHECK_FALSE(run_of(results, points[5]).figures.empty());
    CHECK(run_of(results, points[1]).figures.empty());
}

TEST_CASE("explorer: settings that make no scenario are recorded as the scenario's own error") {
    const Workspace work;
    const SweepPlan plan = work.plan("composer.buffer_pixels", {"16", "-3", "many"});
    const Explorer explorer(plan, starving);
    const std::vector<PointRecord> points = explorer.run(nullptr, with_processes(1)).points;
    REQUIRE(points.size() == 3);
    CHECK(points[0].status == RunStatus::kDone);
    CHECK(points[1].status == RunStatus::kInvalid);
    CHECK(points[1].reason.find("composer.buffer_pixels") != std::string::npos);
    CHECK(points[1].reason.find("out of range") != std::string::npos);
    CHECK(points[2].status == RunStatus::kInvalid);
}

TEST_CASE("explorer: a killed sweep goes on with the points that had not ended") {
    const Workspace work;
    const std::filesystem::path started = work.directory / "started";
    const SweepPlan plan = work.plan("composer.buffer_pixels", numbers(10, 209));
    const Explorer explorer(plan, [&started](const Scenario& scenario, bool /*pictures*/) {
        note(started, std::to_string(scenario.composer.buffer_pixels));
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return simulation_of(scenario, 1);
    });
    const std::filesystem::path file = work.directory / "r.db";
    std::size_t kept = 0;
    // Killed again and again, a little later each time.
    for (int round = 1; round <= 4; ++round) {
        const pid_t victim = quiet_fork();
        if (victim == 0) {
            ResultsDatabase results = ResultsDatabase::open(file, explorer.identity("1"));
            ExploreOptions options = with_processes(3);
            const std::size_t last = kept + 20;
            options.on_progress = [last](const Progress& progress) {
                if (progress.points_ended >= last) kill(getpid(), SIGKILL);
            };
            explorer.run(&results, options);
            _exit(EXIT_SUCCESS);
        }
        int status = 0;
        REQUIRE(waitpid(victim, &status, 0) == victim);
        REQUIRE(WIFSIGNALED(status));
        const std::size_t rows = ResultsReader(file).results().rows.size();
        CHECK(rows >= kept + 20);  // those that were reported to have ended
        kept = rows;
    }
    // Children of the killed ones die with them; until then they may still note their start.
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::size_t before = work.lines("started").size();
    ResultsDatabase results = ResultsDatabase::open(file, explorer.identity("1"));
    const Exploration rest = explorer.run(&results, with_processes(3));
    CHECK(rest.points.size() == 200);
    CHECK(rest.progress.points_reused == kept);
    CHECK(rest.progress.runs == 200 - kept);
    CHECK(work.lines("started").size() - before == 200 - kept);
}

TEST_CASE("explorer: a search finds the smallest value and keeps every simulation") {
    const Workspace work;
    SweepPlan plan = work.plan("watchdog_cycles", {"100", "57", "1", "70000"});
    plan.search = buffer_search(60'000);
    const Explorer explorer(plan, starving);
    ResultsDatabase results = ResultsDatabase::open(work.directory / "r.db", explorer.identity("1"));
    const Exploration exploration = explorer.run(&results, with_processes(4));
    REQUIRE(exploration.points.size() == 4);
    CHECK(exploration.points[0].smallest == 100);
    CHECK(exploration.points[1].smallest == 57);
    CHECK(exploration.points[2].smallest == 1);
    CHECK(exploration.points[0].monotonic == true);
    CHECK(exploration.points[3].status == RunStatus::kUnmet);
    CHECK(exploration.points[3].reason.find("none of ") == 0);
    CHECK(exploration.points[3].reason.find("values tried, 1 to 60000, meets the goal; ") !=
          std::string::npos);
    CHECK(exploration.points[3].reason.find("composer.buffer_pixels=60000: starved_pixels 7") !=
          std::string::npos);
    CHECK(exploration.points[3].reason.find("stalled_cycles") == std::string::npos);  // that part holds
    std::size_t runs = 0;
    for (const PointRecord& point : exploration.points) runs += static_cast<std::size_t>(point.runs);
    CHECK(runs == exploration.progress.runs);
    // The run that shows the point is the one with the smallest value.
    const std::optional<PointRecord> known = results.find_point(exploration.points[0].settings);
    REQUIRE(known);
    std::vector<Setting> settings = exploration.points[0].settings;
    settings.push_back({"composer.buffer_pixels", "100"});
    CHECK(results.find_run(settings).value().first == known->run);
    // None of it is run again.
    const Exploration again = explorer.run(&results, with_processes(4));
    CHECK(again.progress.runs == 0);
    CHECK(again.points[0].smallest == 100);
}

TEST_CASE("explorer: runs whose result is known without simulation are left out of a search") {
    const Workspace work;
    SweepPlan plan = work.plan("watchdog_cycles", {"100", "57", "3"});
    plan.search = buffer_search(60'000);
    const Explorer explorer(plan, starving);
    ResultsDatabase results = ResultsDatabase::open(work.directory / "r.db", explorer.identity("1"));
    ExploreOptions options = with_processes(2);
    options.known = [](const Scenario& scenario) {
        KnownAnswer known;
        known.least = 40;
        known.enough = 500;
        if (scenario.watchdog_cycles == 57) {
            known.enough.reset();
            known.most = 600;
        }
        if (scenario.watchdog_cycles == 3) known.hopeless = "nothing helps";
        return known;
    };
    const Exploration exploration = explorer.run(&results, options);
    REQUIRE(exploration.points.size() == 3);
    CHECK(exploration.points[0].smallest == 100);
    CHECK(exploration.points[0].bounds == "less than 40 is too little and more than 500 is never needed");
    CHECK(exploration.points[1].smallest == 57);
    CHECK(exploration.points[1].bounds == "less than 40 is too little and more than 600 changes nothing");
    CHECK(exploration.points[2].status == RunStatus::kUnmet);
    CHECK(exploration.points[2].reason == "nothing helps");
    CHECK(exploration.points[2].runs == 0);
    const ResultsReader::Table runs = ResultsReader(work.directory / "r.db").runs();
    const auto settings =
        std::find(runs.columns.begin(), runs.columns.end(), "settings") - runs.columns.begin();
    CHECK(!runs.rows.empty());
    for (const std::vector<Value>& row : runs.rows) {
        const auto text = std::get<std::string>(row[static_cast<std::size_t>(settings)]);
        const int pixels =
            std::stoi(nlohmann::json::parse(text).at("composer.buffer_pixels").get<std::string>());
        CHECK(pixels >= 40);
        CHECK(pixels <= 600);
    }
    // For an answer that the results have, figures are there, too.
    const Exploration again = explorer.run(&results, options);
    CHECK(again.progress.runs == 0);
    CHECK(figure_index("starved_pixels").value() < again.points[0].figures.size());
    CHECK(again.points[2].reason == "nothing helps");
}

TEST_CASE("explorer: the cost is what the sweep says it is") {
    const Workspace work;
    SweepPlan plan = work.plan("composer.buffer_pixels", numbers(10, 12));
    plan.cost = "3 * composer.buffer_pixels + 0.5 * buffer_bits";
    const Explorer explorer(
        plan, [](const Scenario& scenario, bool /*pictures*/) { return simulation_of(scenario, getpid()); });
    ResultsDatabase results = ResultsDatabase::open(work.directory / "r.db", explorer.identity("1"));
    explorer.run(&results, with_processes(2));
    const auto table =
        ResultsReader(work.directory / "r.db").results({"composer.buffer_pixels", "cost", "buffer_bits"}, "");
    REQUIRE(table.rows.size() == 3);
    for (const std::vector<Value>& row : table.rows) {
        const auto pixels = static_cast<double>(std::get<std::int64_t>(row[0]));
        const auto bits = static_cast<double>(std::get<std::int64_t>(row[2]));
        CHECK(row[1] == Value(3.0 * pixels + 0.5 * bits));
    }
    // A file with another cost holds other results.
    SweepPlan other = plan;
    other.cost.clear();
    CHECK_THROWS_AS(ResultsDatabase::open(work.directory / "r.db", Explorer(other, starving).identity("1")),
                    InputError);
}

TEST_CASE("explorer: a clock is searched in fractions of a megahertz") {
    const Workspace work;
    SweepPlan plan = work.plan("watchdog_cycles", {"41"});
    plan.search = describe_search("clocks.core_mhz", 1, 100, "test", 0.25);
    const Explorer explorer(plan, [](const Scenario& scenario, bool /*pictures*/) {
        Simulation simulation = simulation_of(scenario, 1);
        const bool starves = scenario.clocks.core_mhz < 10.5;
        simulation.report.composers[0].starved_pixels = starves ? 7 : 0;
        return simulation;
    });
    ResultsDatabase results = ResultsDatabase::open(work.directory / "r.db", explorer.identity("1"));
    CHECK(explorer.run(&results, with_processes(2)).points[0].smallest == 10.5);
    const Exploration again = explorer.run(&results, with_processes(2));
    CHECK(again.progress.runs == 0);
    CHECK(again.points[0].smallest == 10.5);
    CHECK_FALSE(again.points[0].figures.empty());
    const auto table = ResultsReader(work.directory / "r.db").results({"smallest"}, "");
    CHECK(table.rows[0][0] == Value(10.5));
}

TEST_CASE("explorer: a search that meets a crash is a failed point and not a guess") {
    const Workspace work;
    SweepPlan plan = work.plan("watchdog_cycles", {"100"});
    plan.search = buffer_search(60'000);
    const Explorer explorer(plan, [](const Scenario& scenario, bool pictures) {
        if (scenario.composer.buffer_pixels == 64) abort_quietly();
        return starving(scenario, pictures);
    });
    const std::vector<PointRecord> points = explorer.run(nullptr, with_processes(2)).points;
    REQUIRE(points.size() == 1);
    CHECK(points[0].status == RunStatus::kCrashed);
    CHECK(points[0].reason == "composer.buffer_pixels=64: its process ended by a signal: Aborted");
    CHECK_FALSE(points[0].smallest);
}

TEST_CASE("explorer: a stop ends it and leaves the rest for the next time") {
    const Workspace work;
    const SweepPlan plan = work.plan("composer.buffer_pixels", numbers(10, 109));
    const Explorer explorer(plan, starving);
    std::array<int, 2> ends{};
    REQUIRE(pipe(ends.data()) == 0);
    ExploreOptions options = with_processes(2);
    options.stop_descriptor = ends[0];
    options.on_progress = [&ends](const Progress& progress) {
        if (progress.points_ended == 10) REQUIRE(write(ends[1], "x", 1) == 1);
    };
    ResultsDatabase results = ResultsDatabase::open(work.directory / "r.db", explorer.identity("1"));
    const Exploration exploration = explorer.run(&results, options);
    close(ends[0]);
    close(ends[1]);
    CHECK(exploration.stopped);
    CHECK(exploration.points.size() >= 10);
    CHECK(exploration.points.size() < 100);
    const Exploration rest = explorer.run(&results, with_processes(2));
    CHECK(rest.points.size() == 100);
    CHECK(rest.progress.points_reused == exploration.points.size());
}

TEST_CASE("explorer: results of other input are refused") {
    const Workspace work;
    const SweepPlan plan = work.plan("composer.buffer_pixels", {"10"});
    const auto identity = [&plan] { return Explorer(plan, starving).identity("1"); };
    const ResultsIdentity first = identity();
    CHECK(identity().inputs == first.inputs);
    CHECK(first.inputs.count("(scenario)") == 1);
    CHECK(first.inputs.count("view.ppm") == 1);
    SECTION("another scenario") {
        work.directory.write("scenario.yaml", std::string(kScenario) + "frames: 2\n");
    }
    SECTION("another image") {
        std::string other = image();
        other[20] = '!';
        work.directory.write("view.ppm", other);
    }
    const std::filesystem::path file = work.directory / "r.db";
    { ResultsDatabase::open(file, first); }
    CHECK_THROWS_AS(ResultsDatabase::open(file, identity()), InputError);
    CHECK(Explorer(plan, starving).identity("2").fingerprint != first.fingerprint);
    CHECK(first.level == "tlm");
    CHECK(Explorer(plan, starving).identity("1", "rtl").level == "rtl");
}

TEST_CASE("explorer: images that only later points show are input as well") {
    const Workspace work;
    work.directory.write("other.ppm", image());
    const SweepPlan plan = work.plan("renderers.0.frames.0.image", {"missing.ppm", "view.ppm", "other.ppm"});
    const auto identity = [&plan] { return Explorer(plan, starving).identity("1"); };
    const ResultsIdentity first = identity();
    CHECK(first.inputs.at("missing.ppm") == "missing");
    CHECK(first.inputs.at("other.ppm") == first.inputs.at("view.ppm"));
    work.directory.write("other.ppm", image() + " ");
    CHECK(identity().inputs.at("other.ppm") != first.inputs.at("other.ppm"));
}

TEST_CASE("explorer: a scenario may be added to the results of others") {
    const Workspace work;
    work.directory.write("second.yaml", kScenario);
    const auto plan_of = [&work](const std::vector<std::string>& scenarios) {
        SweepDescription description;
        description.name = "test";
        description.base = work.directory.path();
        description.axes.push_back(Axis{{kScenarioAxis}, {scenarios}, {"test"}});
        return make_plan(description);
    };
    for (const std::vector<std::string>& scenarios :
         {std::vector<std::string>{"scenario.yaml"},
          std::vector<std::string>{"second.yaml", "scenario.yaml"}}) {
        const SweepPlan plan = plan_of(scenarios);
        const Explorer explorer(plan, starving);
        ResultsDatabase results = ResultsDatabase::open(work.directory / "r.db", explorer.identity("1"));
        const Exploration exploration = explorer.run(&results, with_processes(1));
        CHECK(exploration.points.size() == scenarios.size());
        CHECK(exploration.progress.runs == 1);
    }
    work.directory.write("scenario.yaml", std::string(kScenario) + "# changed\n");
    const SweepPlan plan = plan_of({"second.yaml", "scenario.yaml"});
    CHECK_THROWS_AS(ResultsDatabase::open(work.directory / "r.db", Explorer(plan, starving).identity("1")),
                    InputError);
}

TEST_CASE("explorer: what was killed from outside or missed a file is tried again") {
    const Workspace work;
    const SweepPlan plan = work.plan("renderers.0.frames.0.image", {"view.ppm", "late.ppm"});
    const std::filesystem::path go_file = work.directory / "go";
    const Simulate simulate = [&go_file](const Scenario& scenario, bool /*pictures*/) {
        if (!std::filesystem::exists(go_file)) kill(getpid(), SIGKILL);
        return simulation_of(scenario, 1);
    };
    const auto statuses = [&] {
        const Explorer explorer(plan, simulate);
        ResultsIdentity identity = explorer.identity("1");
        identity.inputs.erase("late.ppm");  // the file has not changed, it has not been there so far
        ResultsDatabase results = ResultsDatabase::open(work.directory / "r.db", identity);
        std::vector<RunStatus> result;
        for (const PointRecord& point : explorer.run(&results, with_processes(1)).points) {
            result.push_back(point.status);
        }
        return result;
    };
    CHECK(statuses() == std::vector<RunStatus>{RunStatus::kCrashed, RunStatus::kInvalid});
    std::ofstream(go_file) << "go";
    work.directory.write("late.ppm", image());
    CHECK(statuses() == std::vector<RunStatus>{RunStatus::kDone, RunStatus::kDone});
}

TEST_CASE("explorer: a simulation that does not come to an end is given up with its reason") {
    const Workspace work;
    const SweepPlan plan = work.plan("name", {"stuck"});
    const Explorer explorer(plan, [](const Scenario& scenario, bool /*pictures*/) {
        kill(getpid(), SIGSTOP);
        return simulation_of(scenario, 1);
    });
    ExploreOptions options = with_processes(2);
    options.time_limit_seconds = 0.5;
    const std::vector<PointRecord> points = explorer.run(nullptr, options).points;
    REQUIRE(points.size() == 1);
    CHECK(points[0].status == RunStatus::kCrashed);
    CHECK(points[0].reason == "took longer than its time limit of 0.5 s");
}

TEST_CASE("explorer: a search over negative values that none meets ends as unmet") {
    const Workspace work;
    SweepPlan plan = work.plan("watchdog_cycles", {"70000"});
    plan.search = describe_search("renderers.0.frames.0.viewport.x", -9, -3, "test");
    const Explorer explorer(plan, starving);
    const std::vector<PointRecord> points = explorer.run(nullptr, with_processes(2)).points;
    REQUIRE(points.size() == 1);
    CHECK(points[0].status == RunStatus::kUnmet);
    CHECK(points[0].reason.find(
              "no value of -9 to -3 meets the goal; renderers.0.frames.0.viewport.x=-3: ") == 0);
}
