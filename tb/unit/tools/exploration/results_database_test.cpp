#include "tools/exploration/results_database.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/errors.h"
#include "host/quiet_fork.h"
#include "support/random_seed.h"
#include "support/scratch_directory.h"
#include "tools/exploration/figures.h"

namespace metabuffer::exploration {
namespace {

using test::ScratchDirectory;

ResultsIdentity sweep_identity() {
    return {"widths", "f00d", {}, {"bus.width_bits", "bus.arbitration"}, "", "", "", "", {}};
}

std::vector<Setting> settings_of(int width_bits, const std::string& arbitration) {
    return {{"bus.width_bits", std::to_string(width_bits)}, {"bus.arbitration", arbitration}};
}

RunRecord run_of(std::vector<Setting> settings, std::int64_t starved_pixels = 0) {
    RunRecord run;
    run.settings = std::move(settings);
    run.figures.resize(figure_kinds().size());
    run.figures[figure_index("starved_pixels").value()] = starved_pixels;
    run.figures[figure_index("frames_per_second").value()] = 59.5;
    run.report = "{\"scenario\": \"x\"}\n";
    run.wall_seconds = 0.25;
    return run;
}

PointRecord point_of(std::vector<Setting> settings) {
    PointRecord point;
    point.settings = std::move(settings);
    return point;
}

void add(ResultsDatabase& database, int width_bits, const std::string& arbitration,
         std::int64_t starved_pixels = 0) {
    database.add_point(point_of(settings_of(width_bits, arbitration)),
                       run_of(settings_of(width_bits, arbitration), starved_pixels));
}

/// A finished file with one point.
std::filesystem::path finished_file(const ScratchDirectory& directory,
                                    const ResultsIdentity& identity = sweep_identity()) {
    ResultsDatabase database = ResultsDatabase::open(directory / "results.db", identity);
    add(database, 64, "irsa");
    return directory / "results.db";
}

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// The message of the InputError that an action ends with, or what it did instead.
std::string refusal(const std::function<void()>& action) {
    try {
        action();
    } catch (const InputError& error) {
        return error.what();
    } catch (const std::exception& error) {
        return std::string("another error: ") + error.what();
    }
    return "done";
}

std::string refusal_to_write(const std::filesystem::path& file,
                             const ResultsIdentity& identity = sweep_identity()) {
    return refusal([&] { ResultsDatabase::open(file, identity); });
}

std::string refusal_to_read(const std::filesystem::path& file) {
    return refusal([&] { ResultsReader reader(file); });
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// A process that does one thing and writes the outcome to a pipe.
class Child {
  public:
    /// `work` gets the pipe's end to write to.
    explicit Child(const std::function<void(int)>& work) {
        std::array<int, 2> ends{};
        if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
        process_ = quiet_fork();
        if (process_ < 0) throw std::runtime_error("no process");
        if (process_ == 0) {
            close(ends[0]);
            try {
                work(ends[1]);
            } catch (const std::exception& error) {
                send(ends[1], error.what());
            }
            _exit(0);
        }
        close(ends[1]);
        descriptor_ = ends[0];
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child() {
        if (process_ > 0) {
            kill(process_, SIGKILL);
            waitpid(process_, nullptr, 0);
        }
        close(descriptor_);
    }

    static void send(int descriptor, const std::string& text) {
        if (write(descriptor, text.data(), text.size()) < 0) _exit(1);
    }

    /// Up to so many bytes; fewer at the end.
    std::string read_bytes(std::size_t count) const {
        std::string text(count, '\0');
        std::size_t have = 0;
        while (have < count) {
            const ssize_t got = read(descriptor_, text.data() + have, count - have);
            if (got <= 0) break;
            have += static_cast<std::size_t>(got);
        }
        text.resize(have);
        return text;
    }
    std::string read_all() const {
        std::string all;
        for (;;) {
            const std::string part = read_bytes(4096);
            all += part;
            if (part.size() < 4096) return all;
        }
    }
    pid_t process() const { return process_; }
    void kill_and_wait() {
        kill(process_, SIGKILL);
        waitpid(process_, nullptr, 0);
        process_ = -1;
    }
    /// Whether it ended by itself and well.
    bool ended_well() {
        int status = 0;
        waitpid(process_, &status, 0);
        process_ = -1;
        return WIFEXITED(status) && WEXITSTATUS(status) == 0;
    }

  private:
    pid_t process_ = -1;
    int descriptor_ = -1;
};

std::string integrity(const std::filesystem::path& file) {
    SQLite::Database database(file.string(), SQLite::OPEN_READONLY);
    SQLite::Statement check(database, "PRAGMA integrity_check");
    check.executeStep();
    return check.getColumn(0).getString();
}

Value cell(const ResultsReader::Table& table, std::size_t row, const std::string& column) {
    const auto found = std::find(table.columns.begin(), table.columns.end(), column);
    REQUIRE(found != table.columns.end());
    return table.rows.at(row).at(static_cast<std::size_t>(found - table.columns.begin()));
}

}  // namespace

TEST_CASE("results: status names read back") {
    for (const RunStatus status : {RunStatus::kDone, RunStatus::kInvalid, RunStatus::kWatchdog,
                                   RunStatus::kFailed, RunStatus::kCrashed, RunStatus::kUnmet}) {
        CHECK(run_status_of(to_string(status)) == status);
    }
    CHECK_THROWS_AS(run_status_of("finished"), InputError);
}

TEST_CASE("results: what is added is found again with all that it has") {
    const ScratchDirectory directory;
    const auto file = directory / "results.db";
    RunRecord run = run_of(settings_of(32, "edf"), 17);
    run.status = RunStatus::kWatchdog;
    run.reason = "nothing moved";
    for (std::size_t n = 0; n < run.figures.size(); ++n) {
        if (n % 3 == 0) run.figures[n] = static_cast<std::int64_t>(n) << 40U;
        if (n % 3 == 1) run.figures[n] = static_cast<double>(n) / 3.0;
        if (n % 3 == 2) run.figures[n] = Value();
    }
    PointRecord point = point_of(settings_of(32, "edf"));
    point.status = RunStatus::kUnmet;
    point.reason = "no value of \"composer.buffer_pixels\" does";
    point.smallest = 1234;
    point.monotonic = false;
    point.note = "7 does not";
    point.runs = 21;
    std::int64_t id = 0;
    {
        ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
        CHECK_FALSE(database.find_run(run.settings));
        CHECK_FALSE(database.find_point(point.settings));
        id = database.add_run(run);
        point.run = id;
        database.add_point(point);
    }
    const ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
    const auto found_run = database.find_run(run.settings);
    REQUIRE(found_run);
    CHECK(found_run->first == id);
    CHECK(found_run->second.settings == run.settings);
    CHECK(found_run->second.status == run.status);
    CHECK(found_run->second.reason == run.reason);
    CHECK(found_run->second.figures == run.figures);
    CHECK(found_run->second.wall_seconds == run.wall_seconds);
    const auto found_point = database.find_point(point.settings);
    REQUIRE(found_point);
    CHECK(found_point->settings == point.settings);
    CHECK(found_point->status == point.status);
    CHECK(found_point->reason == point.reason);
    CHECK(found_point->run == point.run);
    CHECK(found_point->smallest == point.smallest);
    CHECK(found_point->monotonic == point.monotonic);
    CHECK(found_point->note == point.note);
    CHECK(found_point->runs == point.runs);
    CHECK_FALSE(database.find_point(settings_of(32, "irsa")));
    CHECK_FALSE(database.find_run(settings_of(320, "edf")));
}

TEST_CASE("results: a run that came to no report has no figures and no report") {
    const ScratchDirectory directory;
    RunRecord run = run_of(settings_of(8, "irsa"));
    run.status = RunStatus::kInvalid;
    run.figures.clear();
    run.report.clear();
    std::int64_t id = 0;
    {
        ResultsDatabase database = ResultsDatabase::open(directory / "results.db", sweep_identity());
        database.add_point(point_of(run.settings), run);
        const auto found = database.find_run(run.settings);
        REQUIRE(found);
        CHECK(found->second.figures.empty());
        id = found->first;
        const auto point = database.find_point(run.settings);
        REQUIRE(point);
        CHECK(point->run == id);
        CHECK_FALSE(point->smallest);
        CHECK_FALSE(point->monotonic);
    }
    const ResultsReader reader(directory / "results.db");
    CHECK(reader.report(id).empty());
    CHECK(reader.report(id + 1).empty());
    CHECK(reader.pictures(id).empty());
    CHECK(cell(reader.results(), 0, "starved_pixels") == Value());
}

TEST_CASE("results: a row with the same settings replaces the one before") {
    const ScratchDirectory directory;
    {
        ResultsDatabase database = ResultsDatabase::open(directory / "results.db", sweep_identity());
        RunRecord run = run_of(settings_of(64, "irsa"), 5);
        run.pictures = {{1, "one"}, {2, "two"}};
        const std::int64_t id = database.add_run(run);
        add(database, 64, "irsa", 6);
        add(database, 64, "irsa", 7);
        const auto found = database.find_run(run.settings);
        REQUIRE(found);
        CHECK(found->first == id);
    }
    const ResultsReader reader(directory / "results.db");
    const ResultsReader::Table table = reader.results();
    REQUIRE(table.rows.size() == 1);
    CHECK(cell(table, 0, "starved_pixels") == Value(std::int64_t{7}));
    CHECK(reader.runs().rows.size() == 1);
    CHECK(reader.pictures(std::get<std::int64_t>(cell(table, 0, "run"))).empty());
}

TEST_CASE("results: the view has the settings by key - then the point - then the figures of its run") {
    const ScratchDirectory directory;
    const ResultsReader reader(finished_file(directory));
    std::vector<std::string> expected{"point",     "bus.width_bits", "bus.arbitration",
                                      "status",    "reason",         "smallest",
                                      "monotonic", "runs",           "note",
                                      "run"};
    for (const FigureKind& figure : figure_kinds()) expected.emplace_back(figure.name);
    expected.emplace_back("wall_seconds");
    CHECK(reader.columns() == expected);
    const ResultsReader::Table table = reader.results();
    CHECK(table.columns == expected);
    REQUIRE(table.rows.size() == 1);
    CHECK(cell(table, 0, "bus.width_bits") == Value(std::int64_t{64}));
    CHECK(cell(table, 0, "bus.arbitration") == Value(std::string("irsa")));
    CHECK(cell(table, 0, "status") == Value(std::string("done")));
    CHECK(cell(table, 0, "runs") == Value(std::int64_t{1}));
    CHECK(cell(table, 0, "frames_per_second") == Value(59.5));
    CHECK(cell(table, 0, "wall_seconds") == Value(0.25));
    CHECK(cell(table, 0, "monotonic") == Value());
    CHECK(reader.identity().name == "widths");
    CHECK(reader.identity().fingerprint == "f00d");
    CHECK(reader.identity().keys == sweep_identity().keys);
}

TEST_CASE("results: keys may be anything - names of figures and quotes included") {
    const ScratchDirectory directory;
    const std::vector<std::string> keys{"renderers", "run", "scenario", "o'dd\"key",
                                        "renderers.0.frames.0.viewport.x"};
    {
        ResultsDatabase database =
            ResultsDatabase::open(directory / "results.db", {"", "", {}, keys, "", "", "", "", {}});
        std::vector<Setting> settings;
        settings.reserve(keys.size());
        for (const std::string& key : keys) settings.push_back({key, std::to_string(settings.size() + 1)});
        database.add_point(point_of(settings), run_of(settings));
    }
    const ResultsReader reader(directory / "results.db");
    const ResultsReader::Table table = reader.results("axis.renderers = 1 and \"o'dd\"\"key\" = 4");
    REQUIRE(table.rows.size() == 1);
    CHECK(cell(table, 0, "axis.renderers") == Value(std::int64_t{1}));
    CHECK(cell(table, 0, "axis.run") == Value(std::int64_t{2}));
    CHECK(cell(table, 0, "renderers.0.frames.0.viewport.x") == Value(std::int64_t{5}));
    CHECK(cell(table, 0, "run") == Value(std::int64_t{1}));
}

TEST_CASE("results: rows come in the order of the axes' values whichever point ended first") {
    const ScratchDirectory directory;
    {
        ResultsDatabase database = ResultsDatabase::open(directory / "results.db", sweep_identity());
        add(database, 128, "edf");
        add(database, 64, "irsa");
        add(database, 16, "irsa");
        add(database, 64, "edf");
    }
    const ResultsReader reader(directory / "results.db");
    const auto table = reader.results({"bus.width_bits", "bus.arbitration"}, "");
    CHECK(table.columns == std::vector<std::string>{"bus.width_bits", "bus.arbitration"});
    std::string order;
    for (const auto& row : table.rows) order += text_of(row[0]) + " " + text_of(row[1]) + "; ";
    CHECK(order == "16 irsa; 64 edf; 64 irsa; 128 edf; ");
}

TEST_CASE("results: conditions and columns are expressions over the view's columns") {
    const ScratchDirectory directory;
    {
        ResultsDatabase database = ResultsDatabase::open(directory / "results.db", sweep_identity());
        for (const int width : {16, 32, 64, 128}) {
            add(database, width, "irsa", 1000 / width);
            add(database, width, "edf", 100 / width);
        }
    }
    const ResultsReader reader(directory / "results.db");
    CHECK(reader.results().rows.size() == 8);
    CHECK(reader.results("bus.width_bits >= 64 and bus.arbitration <> 'edf'").rows.size() == 2);
    CHECK(reader.results("starved_pixels = 0").rows.size() == 1);
    const auto table =
        reader.results({"bus.width_bits / 8", "max(starved_pixels, 5)"}, "bus.width_bits = 16");
    CHECK(table.columns == std::vector<std::string>{"bus.width_bits / 8", "max(starved_pixels, 5)"});
    REQUIRE(table.rows.size() == 2);
    CHECK(table.rows[0] == std::vector<Value>{std::int64_t{2}, std::int64_t{6}});
    CHECK(table.rows[1] == std::vector<Value>{std::int64_t{2}, std::int64_t{62}});

    CHECK_THROWS_WITH(reader.results("bus.width_bit = 3"),
                      "'bus.width_bit' is not known; the nearest is bus.width_bits");
    for (const std::string text : {"1; drop table runs", "1) or (1", "point in (select 1)", "1 in runs",
                                   "count(*)", "1 order by 1", "1 in sqlite_master"}) {
        CAPTURE(text);
        CHECK_THROWS_AS(reader.results(text), InputError);
        CHECK_THROWS_AS(reader.results({"point", text}, ""), InputError);
    }
    CHECK(reader.results().rows.size() == 8);
}

TEST_CASE("results: reports and pictures come back byte for byte, and are stored as zlib streams") {
    const ScratchDirectory directory;
    const std::uint64_t seed = test::random_seed(7);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    std::vector<RunRecord> runs;
    std::vector<std::int64_t> ids;
    {
        ResultsDatabase database = ResultsDatabase::open(directory / "results.db", sweep_identity());
        for (const int size : {1, 100, 65535, 65536, 65537, 1'000'000}) {
            RunRecord run = run_of(settings_of(size, "irsa"));
            run.report.clear();
            for (int n = 0; n < size; ++n) run.report += static_cast<char>(random.bits());
            run.pictures = {{2, run.report.substr(0, 50) + std::string("\0\0", 2)}, {1, ""}, {12, "png"}};
            ids.push_back(database.add_run(run));
            runs.push_back(run);
        }
    }
    const ResultsReader reader(directory / "results.db");
    for (std::size_t n = 0; n < runs.size(); ++n) {
        CHECK((reader.report(ids[n]) == runs[n].report));
        auto pictures = runs[n].pictures;
        std::sort(pictures.begin(), pictures.end());
        CHECK((reader.pictures(ids[n]) == pictures));
    }
    {
        ResultsDatabase database = ResultsDatabase::open(directory / "results.db", sweep_identity());
        RunRecord run = run_of(settings_of(1, "irsa"));
        for (int n = 0; n < 1000; ++n) run.report += "\"starved_pixels\": 0, ";
        database.add_run(run);
    }
    SQLite::Database database((directory / "results.db").string(), SQLite::OPEN_READONLY);
    SQLite::Statement report(database, "SELECT report FROM runs");
    REQUIRE(report.executeStep());
    const std::string bytes = report.getColumn(0).getString();
    CHECK(bytes.size() < 1000);
    CHECK(bytes.at(0) == '\x78');
}

TEST_CASE("results: a finished file is one file that is complete by itself, and two tables describe it") {
    const ScratchDirectory directory;
    const auto file = finished_file(directory);
    CHECK(directory.names() == std::vector<std::string>{"results.db"});
    // Bytes 18 and 19 of an SQLite file: 1 is no write-ahead log.
    CHECK(bytes_of(file).substr(18, 2) == "\x01\x01");
    std::filesystem::rename(file, directory / "moved.db");
    CHECK(ResultsReader(directory / "moved.db").results().rows.size() == 1);
    SQLite::Database database(finished_file(directory).string(), SQLite::OPEN_READONLY);
    CHECK(database.execAndGet("SELECT value FROM meta WHERE key = 'schema_version'").getString() == "2");
    CHECK(database.execAndGet("SELECT count(*) FROM meta WHERE key = 'program_version'").getInt() == 1);
    CHECK(database.execAndGet("SELECT key FROM axes WHERE position = 1").getString() == "bus.arbitration");
    CHECK(database.execAndGet("SELECT typeof(value) FROM point_settings WHERE position = 0").getString() ==
          "integer");
}

TEST_CASE("results: points and runs are found by an index") {
    const ScratchDirectory directory;
    SQLite::Database database(finished_file(directory).string(), SQLite::OPEN_READONLY);
    for (const std::string table : {"points", "runs"}) {
        SQLite::Statement plan(database, "EXPLAIN QUERY PLAN SELECT * FROM " + table + " WHERE settings = ?");
        REQUIRE(plan.executeStep());
        CHECK(contains(plan.getColumn(3).getString(), "USING INDEX"));
    }
}

TEST_CASE("results: a reader sees what a writer has added so far") {
    const ScratchDirectory directory;
    const auto file = directory / "results.db";
    std::optional<ResultsReader> reader;
    {
        ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
        reader.emplace(file);
        CHECK(reader->results().rows.empty());
        for (int n = 1; n <= 50; ++n) {
            add(database, n, "irsa");
            REQUIRE(reader->results().rows.size() == static_cast<std::size_t>(n));
        }
    }
    // The writer has gone and the reader is still there.
    CHECK(reader->results().rows.size() == 50);
    reader.reset();
    CHECK(ResultsReader(file).results().rows.size() == 50);
    CHECK_FALSE(std::filesystem::exists(directory / "results.db.lock"));
    // The next writer tidies up.
    ResultsDatabase::open(file, sweep_identity());
    CHECK(directory.names() == std::vector<std::string>{"results.db"});
}

TEST_CASE("results: whatever moment the writer is killed at - what it had added is there") {
    const std::uint64_t seed = test::random_seed(8);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    const ScratchDirectory directory;
    const auto file = directory / "results.db";
    int added = 0;
    int rounds_with_points = 0;
    for (int round = 0; round < 25; ++round) {
        Child child([&](int descriptor) {
            ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
            for (int n = added;; ++n) {
                RunRecord run = run_of(settings_of(n, "irsa"), n);
                run.report += std::string(static_cast<std::size_t>(n % 7) * 1000, 'r');
                run.pictures = {{1, std::string(static_cast<std::size_t>(n % 5) * 20000, 'p')}};
                database.add_point(point_of(run.settings), run);
                Child::send(descriptor, "+");
            }
        });
        const auto wanted = static_cast<std::size_t>(random.between(0, 60));
        std::size_t received = child.read_bytes(wanted).size();
        REQUIRE(received == wanted);
        usleep(static_cast<useconds_t>(random.between(0, 3000)));
        child.kill_and_wait();
        received += child.read_all().size();
        rounds_with_points += received > 0 ? 1 : 0;

        // The check is the same whether a reader or the next writer is the first to see what is left.
        if (random.one_in(2) && std::filesystem::exists(file) && added + static_cast<int>(received) > 0) {
            const auto rows = ResultsReader(file).results().rows.size();
            REQUIRE(rows >= static_cast<std::size_t>(added) + received);
            REQUIRE(rows <= static_cast<std::size_t>(added) + received + 1);
        }
        const ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
        for (int n = added; n < added + static_cast<int>(received); ++n) {
            const auto point = database.find_point(settings_of(n, "irsa"));
            REQUIRE(point);
            REQUIRE(point->run);
            const auto run = database.find_run(settings_of(n, "irsa"));
            REQUIRE(run);
            REQUIRE(run->first == *point->run);
            REQUIRE(run->second.figures.at(figure_index("starved_pixels").value()) == Value(std::int64_t{n}));
        }
        added += static_cast<int>(received);
        // One that was added and not reported is there in full or not at all.
        const bool is_one_more = database.find_point(settings_of(added, "irsa")).has_value();
        REQUIRE(database.find_run(settings_of(added, "irsa")).has_value() == is_one_more);
        added += is_one_more ? 1 : 0;
        REQUIRE_FALSE(database.find_point(settings_of(added, "irsa")));
    }
    CHECK(rounds_with_points > 15);
    CHECK(integrity(file) == "ok");
    const ResultsReader reader(file);
    const auto table = reader.results();
    REQUIRE(table.rows.size() == static_cast<std::size_t>(added));
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        const auto run = std::get<std::int64_t>(cell(table, row, "run"));
        const auto width =
            static_cast<std::size_t>(std::get<std::int64_t>(cell(table, row, "bus.width_bits")));
        REQUIRE(reader.report(run).size() == run_of({}).report.size() + width % 7 * 1000);
        REQUIRE(reader.pictures(run).at(0).second.size() == width % 5 * 20000);
    }
}

TEST_CASE("results: a writer that is killed as it makes the file leaves one that can be continued") {
    for (const int microseconds : {0, 100, 300, 600, 1000, 1500, 2000, 3000, 5000, 8000}) {
        const ScratchDirectory directory;
        Child child([&](int descriptor) {
            Child::send(descriptor, "+");
            ResultsDatabase::open(directory / "results.db", sweep_identity());
            pause();
        });
        REQUIRE(child.read_bytes(1) == "+");
        usleep(static_cast<useconds_t>(microseconds));
        child.kill_and_wait();
        CAPTURE(microseconds, directory.names());
        const auto file = finished_file(directory);
        CHECK(ResultsReader(file).results().rows.size() == 1);
        CHECK(directory.names() == std::vector<std::string>{"results.db"});
    }
}

TEST_CASE("results: only one process at a time adds to a file, and a killed one does not hold it") {
    const ScratchDirectory directory;
    const auto file = finished_file(directory);
    const auto attempt = [&file] {
        Child child([&file](int descriptor) { Child::send(descriptor, refusal_to_write(file)); });
        return child.read_all();
    };
    {
        const ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
        CHECK(attempt() == "'" + file.string() + "' is being written by another process (" +
                               std::to_string(getpid()) + "); wait for it, or name another file with -o");
        // The refused one has left all as it was.
        CHECK(contains(attempt(), "another process"));
        CHECK(refusal_to_read(file) == "done");
    }
    CHECK(attempt() == "done");
    // The writer's child lives until this process closes its end of the pipe.
    std::array<int, 2> life{};
    REQUIRE(pipe(life.data()) == 0);
    Child writer([&](int descriptor) {
        const ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
        if (quiet_fork() == 0) {
            close(life[1]);
            char byte = 0;
            _exit(static_cast<int>(read(life[0], &byte, 1)));
        }
        Child::send(descriptor, "+");
        pause();
    });
    REQUIRE(writer.read_bytes(1) == "+");
    CHECK(contains(refusal_to_write(file), "another process"));
    writer.kill_and_wait();
    CHECK(refusal_to_write(file) == "done");
    for (const int end : life) close(end);
}

TEST_CASE("results: of several writers only one at a time has the file open") {
    const ScratchDirectory directory;
    const auto file = finished_file(directory);
    const auto mark = directory / "mark";
    const auto work = [&](int descriptor) {
        int opened = 0;
        while (opened < 40) {
            try {
                const ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
                const int held = open(mark.c_str(), O_CREAT | O_EXCL | O_WRONLY, 0600);
                if (held < 0) Child::send(descriptor, "two at once; ");
                close(held);
                usleep(200);
                unlink(mark.c_str());
                ++opened;
            } catch (const InputError& error) {
                if (!contains(error.what(), "another process")) {
                    Child::send(descriptor, error.what());
                    return;
                }
                // At all sorts of moments, but not too soon, or no writer would ever find another one.
                usleep(static_cast<useconds_t>(opened));
            }
        }
    };
    Child first(work);
    Child second(work);
    Child third(work);
    std::string complaints;
    complaints += first.read_all();
    complaints += second.read_all();
    complaints += third.read_all();
    INFO(complaints);
    CHECK(complaints.empty());
}

TEST_CASE("results: a file of other input is refused with what differs") {
    const ScratchDirectory directory;
    ResultsIdentity search = sweep_identity();
    search.search_key = "composer.buffer_pixels";
    search.goal = "starved_pixels = 0";
    const auto file = finished_file(directory, search);
    const std::string before = bytes_of(file);
    const std::string begin = "'" + file.string() + "' holds results ";
    const std::string end = "; name another file with -o, or remove it";

    ResultsIdentity other = search;
    other.fingerprint = "version 2";
    CHECK(refusal_to_write(file, other) ==
          begin + "of another build (" + search.fingerprint + " instead of version 2)" + end);
    other.fingerprint = search.fingerprint + "; bus.width_bits=64";
    CHECK(refusal_to_write(file, other) ==
          begin + "of other input (settings that all points share are not the same)" + end);
    other = search;
    other.keys = {"bus.width_bits"};
    CHECK(refusal_to_write(file, other) ==
          begin + "over other axes (bus.width_bits and bus.arbitration instead of bus.width_bits)" + end);
    other = search;
    std::swap(other.keys[0], other.keys[1]);
    CHECK(contains(refusal_to_write(file, other), "over other axes"));
    other = search;
    other.search_key = "bus.burst_pixels";
    CHECK(refusal_to_write(file, other) ==
          begin + "of another search (of 'composer.buffer_pixels' instead of 'bus.burst_pixels')" + end);
    other.search_key = "";
    CHECK(contains(refusal_to_write(file, other), "instead of none"));
    other = search;
    other.goal = "late_pixels = 0";
    CHECK(refusal_to_write(file, other) ==
          begin + "of a search with another goal ('starved_pixels = 0' instead of 'late_pixels = 0')" + end);

    CHECK((bytes_of(file) == before));
    CHECK(directory.names() == std::vector<std::string>{"results.db"});
    CHECK(refusal_to_write(file, search) == "done");
    // A name is a title, often that of the sweep's file.
    other = search;
    other.name = "others";
    CHECK(refusal_to_write(file, other) == "done");
}

TEST_CASE("results: files of other kinds, none, and empty ones are refused and left as they are") {
    const ScratchDirectory directory;
    CHECK(contains(refusal_to_read(directory / "none.db"), "there is no such file"));
    CHECK(directory.names().empty());
    const std::string message = refusal_to_write(directory / "none" / "results.db");
    CHECK(contains(message, "cannot be written to"));
    CHECK(contains(message, "No such file or directory"));
    const auto refused = [&](const std::filesystem::path& file, const std::string& reason) {
        const std::string before = bytes_of(file);
        CAPTURE(file.filename().string());
        for (const std::string& message : {refusal_to_write(file), refusal_to_read(file)}) {
            CHECK(contains(message, "'" + file.string() + "'"));
            CHECK(contains(message, reason));
            CHECK_FALSE(contains(message, "\n"));
            CHECK_FALSE(contains(message, "another error"));
        }
        CHECK((bytes_of(file) == before));
        CHECK_FALSE(std::filesystem::exists(file.string() + ".lock"));
    };
    refused(directory.write("short.db", "hello"), "no SQLite file");
    refused(directory.write("long.db", std::string(100'000, 'x')), "no SQLite file");
    refused(directory.write("sweep.yaml", "scenario: a.yaml\n"), "no SQLite file");

    SQLite::Database((directory / "tables.db").string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
        .exec("CREATE TABLE runs (id); INSERT INTO runs VALUES (1)");
    refused(directory / "tables.db", "not one of results");
    SQLite::Database((directory / "marked.db").string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
        .exec("PRAGMA application_id = 5; CREATE TABLE meta (key, value)");
    refused(directory / "marked.db", "not one of results");

    const auto newer = finished_file(directory);
    SQLite::Database(newer.string(), SQLite::OPEN_READWRITE)
        .exec("PRAGMA user_version = 7; UPDATE meta SET value = '9.1' WHERE key = 'program_version'");
    refused(newer, "has schema version 7 (of metabuffer 9.1); this program knows version 2");

    std::filesystem::create_directory(directory / "folder.db");
    CHECK(contains(refusal_to_write(directory / "folder.db"), "is no file"));
    CHECK(contains(refusal_to_read(directory / "folder.db"), "is no file"));
    CHECK(contains(refusal_to_write("/dev/null"), "is no file"));
    const auto file = directory.write("results.db", "");
    CHECK(contains(refusal_to_read(file), "holds no results"));
    CHECK(refusal_to_write(file) == "done");
    CHECK(refusal_to_read(file) == "done");
}

TEST_CASE("results: a file with other figures is not added to but read") {
    const ScratchDirectory directory;
    const auto file = finished_file(directory);
    SQLite::Database(file.string(), SQLite::OPEN_READWRITE).exec("ALTER TABLE runs ADD COLUMN newest_figure");
    CHECK(contains(refusal_to_write(file), "with other figures"));
    const ResultsReader reader(file);
    CHECK(reader.results().rows.size() == 1);
    CHECK(reader.runs().columns.back() == "newest_figure");
}

TEST_CASE("results: a damaged file ends in an InputError or in results") {
    const std::uint64_t seed = test::random_seed(9);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    const ScratchDirectory directory;
    {
        ResultsDatabase database = ResultsDatabase::open(directory / "results.db", sweep_identity());
        for (int n = 0; n < 200; ++n) add(database, n, "irsa");
    }
    const std::string whole = bytes_of(directory / "results.db");
    int refused = 0;
    for (int n = 0; n < 60; ++n) {
        std::string bytes = whole;
        if (random.one_in(3)) {
            bytes.resize(static_cast<std::size_t>(random.between(1, static_cast<int>(whole.size()) - 1)));
        } else {
            for (int damage = random.between(1, 200); damage > 0; --damage) {
                bytes[static_cast<std::size_t>(random.between(0, static_cast<int>(bytes.size()) - 1))] =
                    static_cast<char>(random.bits());
            }
        }
        const auto file = directory.write("damaged.db", bytes);
        const std::string message = refusal([&] {
            const ResultsReader reader(file);
            reader.results("starved_pixels = 0");
            for (const auto& row : reader.runs().rows) reader.report(std::get<std::int64_t>(row.at(0)));
        });
        CAPTURE(n, message);
        REQUIRE_FALSE(contains(message, "another error"));
        REQUIRE_FALSE(contains(message, "\n"));
        refused += message == "done" ? 0 : 1;
        REQUIRE_FALSE(contains(refusal_to_write(file), "another error"));
    }
    CHECK(refused > 20);
}

TEST_CASE("results: what cannot be written is an OutputError and leaves what was there") {
    const ScratchDirectory directory;
    const auto file = finished_file(directory);
    Child child([&file](int descriptor) {
        ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
        // From here on no file grows beyond this: the disk is full.
        signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{300'000, 300'000};
        setrlimit(RLIMIT_FSIZE, &limit);
        int added = 0;
        try {
            for (;; ++added) {
                RunRecord run = run_of(settings_of(1000 + added, "edf"));
                run.pictures = {{1, std::string(20'000, 'p')}};
                database.add_point(point_of(run.settings), run);
            }
        } catch (const OutputError& error) {
            Child::send(descriptor, std::to_string(added) + " " + error.what());
        }
        // The failed one is not there, not even to its own writer.
        const bool is_half_there = database.find_run(settings_of(1000 + added, "edf")).has_value();
        Child::send(descriptor, is_half_there ? " half" : " whole");
    });
    const std::string received = child.read_all();
    INFO(received);
    CHECK(child.ended_well());
    CHECK(contains(received, "cannot add to '" + file.string() + "': "));
    CHECK(contains(received, " whole"));
    const int added = std::stoi(received);
    CHECK(added > 2);
    CHECK(ResultsReader(file).results().rows.size() == static_cast<std::size_t>(added) + 1);
}

namespace {

/// Does something as a user who may not write to the folder, and reports how it ended.
std::string as_stranger(const ScratchDirectory& directory, const std::function<void()>& action) {
    chmod(directory.path().c_str(), 0555);
    for (const std::string& name : directory.names()) chmod((directory / name).c_str(), 0444);
    Child child([&action](int descriptor) {
        constexpr uid_t kNobody = 65534;
        if (geteuid() == 0 && (setgid(kNobody) != 0 || setuid(kNobody) != 0)) _exit(1);
        Child::send(descriptor, refusal(action));
    });
    std::string received = child.read_all();
    CHECK(child.ended_well());
    chmod(directory.path().c_str(), 0755);
    return received;
}

/// A file as a killed writer leaves it.
std::filesystem::path killed_file(const ScratchDirectory& directory) {
    auto file = finished_file(directory);
    Child child([&](int descriptor) {
        ResultsDatabase database = ResultsDatabase::open(file, sweep_identity());
        add(database, 128, "edf");
        Child::send(descriptor, "+");
        pause();
    });
    REQUIRE(child.read_bytes(1) == "+");
    child.kill_and_wait();
    return file;
}

}  // namespace

TEST_CASE("results: a finished file is read where nothing can be written") {
    const ScratchDirectory directory;
    const auto file = finished_file(directory);
    CHECK(as_stranger(directory, [&file] {
              if (ResultsReader(file).results().rows.size() != 1) throw InputError("rows are missing");
          }) == "done");
    CHECK(contains(as_stranger(directory, [&file] { ResultsDatabase::open(file, sweep_identity()); }),
                   "cannot be written to"));
}

TEST_CASE("results: a killed sweep's file is read where nothing can be written or says what to do") {
    const ScratchDirectory directory;
    const auto file = killed_file(directory);
    REQUIRE(std::filesystem::file_size(file.string() + "-wal") > 0);
    const auto read_both = [&file] {
        if (ResultsReader(file).results().rows.size() != 2) throw InputError("rows are missing");
    };
    CHECK(as_stranger(directory, read_both) == "done");
    std::filesystem::remove(file.string() + "-shm");
    const std::string message = as_stranger(directory, read_both);
    CHECK(contains(message, "-wal' takes a folder that can be written to"));

    // Copied as the message says, both rows are there.
    const ScratchDirectory copy;
    for (const std::string name : {"results.db", "results.db-wal"}) {
        std::filesystem::copy_file(directory / name, copy / name);
        chmod((copy / name).c_str(), 0644);
    }
    CHECK(ResultsReader(copy / "results.db").results().rows.size() == 2);

    // If the file of waiting changes is gone, the file itself is complete without them.
    std::filesystem::remove(file.string() + "-wal");
    CHECK(as_stranger(directory, [&file] {
              if (ResultsReader(file).results().rows.size() != 1) throw InputError("rows are missing");
          }) == "done");
}

TEST_CASE("results: names of files may contain characters of URIs") {
    const ScratchDirectory directory;
    const auto file = killed_file(directory);
    std::filesystem::remove(file.string() + "-wal");
    std::filesystem::remove(file.string() + "-shm");
    const auto odd = directory / "100%25 ?mode=rw#1.db";
    std::filesystem::rename(file, odd);
    CHECK(as_stranger(directory, [&odd] {
              if (ResultsReader(odd).results().rows.size() != 1) throw InputError("rows are missing");
          }) == "done");
}

}  // namespace metabuffer::exploration
