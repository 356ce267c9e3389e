#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "program_run.h"
#include "support/random_seed.h"
#include "tools/exploration/results_database.h"
#include "tools/program/exit_status.h"
#include "workplace.h"

// `metabuffer sweep --shard`, `--parts` and `metabuffer merge` from outside: a sweep in shards gives what it gives in
// one run, whichever process is killed on the way.

namespace metabuffer::test::shard_commands_test {
using namespace exploration;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

/// 2 x 40 points, some of which starve.
constexpr const char* kSweep = R"(
scenario: scenario.yaml
set: {memory.page_words: 16, composer.ready_space_pixels: 8}
axes:
  - {key: bus.width_bits, values: [16, 64]}
  - {key: composer.buffer_pixels, range: {from: 20, to: 59, step: 1}}
)";

/// A searched point has many simulations; its pictures belong to one of them.
constexpr const char* kSearch = R"(
scenario: scenario.yaml
set: {memory.page_words: 16, composer.ready_space_pixels: 8}
pictures: true
axes:
  - {key: bus.width_bits, values: [16, 64]}
  - {key: bus.arbitration, values: [irsa, edf, round-robin]}
minimize: {key: composer.buffer_pixels, from: 8, to: 300, checks: 2}
)";

ProgramResult metabuffer_in(const Workplace& work, const std::vector<std::string>& arguments) {
    return run_program(work, arguments);
}

void run_well(const Workplace& work, const std::vector<std::string>& arguments) {
    const ProgramResult result = metabuffer_in(work, arguments);
    CAPTURE(arguments, result.err, result.out);
    REQUIRE(result.status == kExitDone);
}

/// What `metabuffer export` writes of a file or a folder.
std::string exported(const Workplace& work, const std::string& results) {
    const ProgramResult result = metabuffer_in(work, {"export", results});
    CAPTURE(results, result.err);
    REQUIRE(result.status == kExitDone);
    REQUIRE(!result.out.empty());
    return result.out;
}

std::string shard(int number, int count) { return std::to_string(number) + "/" + std::to_string(count); }

}  // namespace

TEST_CASE("shards: merged in any order, twice and more, they export the same bytes as one run",
          "[program][sweep]") {
    const Workplace work;
    const std::uint64_t seed = random_seed(41);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    for (const char* const sweep : {kSweep, kSearch}) {
        work.write("sweep.yaml", sweep);
        run_well(work, {"sweep", "sweep.yaml", "-o", "whole.db", "--quiet"});
        const std::string expected = exported(work, "whole.db");
        const int count = random.between(2, 6);
        CAPTURE(count);
        std::vector<std::string> parts;
        for (int number = 1; number <= count; ++number) {
            parts.push_back("part-" + std::to_string(number) + ".db");
            run_well(work,
                     {"sweep", "sweep.yaml", "--shard", shard(number, count), "-o", parts.back(), "--quiet"});
        }
        for (std::size_t n = parts.size(); n > 1; --n) {
            std::swap(parts[n - 1],
                      parts[static_cast<std::size_t>(random.between(0, static_cast<int>(n) - 1))]);
        }
        CHECK(exported(work, "whole.db") == expected);
        run_well(work, std::vector<std::string>{"merge", "-o", "all.db"} + parts);
        CHECK(exported(work, "all.db") == expected);
        // A part and the target itself once more.
        const ProgramResult again = metabuffer_in(work, {"merge", parts.front(), "all.db", "-o", "all.db"});
        CHECK(again.status == kExitDone);
        CHECK_THAT(again.out, Contains(" points, 0 of them new: all.db"));
        CHECK(exported(work, "all.db") == expected);
        // The parts, without being put together first.
        const ProgramResult of_parts = metabuffer_in(work, std::vector<std::string>{"export"} + parts);
        CHECK(of_parts.out == expected);
        // A sweep goes on from what was merged, and finds nothing to do.
        const ProgramResult more = metabuffer_in(work, {"sweep", "sweep.yaml", "-o", "all.db"});
        CHECK(more.status == kExitDone);
        CHECK_THAT(more.out, Contains(", 0 simulations"));
        for (const std::string& file : parts) std::filesystem::remove(work / file);
        std::filesystem::remove(work / "all.db");
        std::filesystem::remove(work / "whole.db");
    }
}

TEST_CASE("shards: reports and pictures come along, with the run that they belong to", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSearch);
    run_well(work, {"sweep", "sweep.yaml", "-o", "whole.db", "--quiet"});
    // The second part comes first, so that numbers of runs are not what they were.
    for (const int number : {2, 1, 3}) {
        run_well(work, {"sweep", "sweep.yaml", "--shard", shard(number, 3), "-o",
                        "part-" + std::to_string(number) + ".db", "--quiet"});
    }
    run_well(work, {"merge", "part-2.db", "part-3.db", "part-1.db", "-o", "all.db"});
    const ResultsReader whole(work / "whole.db");
    const ResultsReader all(work / "all.db");
    const std::vector<std::string> columns{"run", "status"};
    const ResultsReader::Table expected = whole.results(columns, "");
    const ResultsReader::Table merged = all.results(columns, "");
    REQUIRE(merged.rows.size() == expected.rows.size());
    REQUIRE(merged.rows.size() == 6);
    for (std::size_t n = 0; n < merged.rows.size(); ++n) {
        CAPTURE(n);
        const std::int64_t run = std::get<std::int64_t>(merged.rows[n][0]);
        const std::int64_t expected_run = std::get<std::int64_t>(expected.rows[n][0]);
        CHECK(all.report(run) == whole.report(expected_run));
        CHECK_FALSE(all.report(run).empty());
        CHECK(all.pictures(run) == whole.pictures(expected_run));
        CHECK_FALSE(all.pictures(run).empty());
    }
    CHECK(all.runs().rows.size() == whole.runs().rows.size());
}

TEST_CASE("merge: says what is missing, with a status of its own, and a sweep runs it", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    run_well(work, {"sweep", "sweep.yaml", "-o", "whole.db", "--quiet"});
    for (const int number : {1, 4}) {
        run_well(work, {"sweep", "sweep.yaml", "--shard", shard(number, 5), "-o",
                        "part-" + std::to_string(number) + ".db", "--quiet"});
    }
    const ProgramResult result = metabuffer_in(work, {"merge", "part-1.db", "part-4.db", "-o", "all.db"});
    CHECK(result.status == kExitIncomplete);
    CHECK(result.err == "missing: shards 2, 3 and 5 of 5\n");
    CHECK_THAT(result.out, Contains("2 files, 32 points, 32 of them new: all.db"));
    // The merged file remembers it.
    const ProgramResult again = metabuffer_in(work, {"merge", "all.db", "-o", "copy.db"});
    CHECK(again.status == kExitIncomplete);
    CHECK(again.err == result.err);
    run_well(work, {"sweep", "sweep.yaml", "-o", "all.db", "--quiet"});
    CHECK(exported(work, "all.db") == exported(work, "whole.db"));
    run_well(work, {"merge", "all.db", "-o", "copy.db"});
}

TEST_CASE("merge: a part that was killed lacks points, and says how many", "[program][sweep]") {
    const Workplace work;
    std::string many = kSweep;
    many.replace(many.find("to: 59"), 6, "to: 2059");
    work.write("sweep.yaml", many);
    run_script(work,
               "\"$0\" sweep sweep.yaml --shard 1/2 -o part-1.db & until grep -aFqs '\"}done' part-1.db-wal "
               "part-1.db; do sleep 0.05; done; kill -KILL $!; wait $!");
    const ProgramResult result = metabuffer_in(work, {"merge", "part-1.db", "-o", "all.db"});
    CHECK(result.status == kExitIncomplete);
    const auto ended = static_cast<std::int64_t>(ResultsReader(work / "all.db").results().rows.size());
    CHECK(ended > 0);
    CHECK(result.err == "missing: shard 2 of 2, and " + std::to_string(2040 - ended) +
                            " of the 2040 points of the other shards\n");
}

TEST_CASE("merge: what a killed sweep left in its journal neither gets lost nor comes back",
          "[program][sweep]") {
    const Workplace work;
    std::string many = kSweep;
    many.replace(many.find("to: 59"), 6, "to: 559");
    work.write("sweep.yaml", many);
    run_well(work, {"sweep", "sweep.yaml", "-o", "whole.db", "--quiet"});
    run_script(work,
               "\"$0\" sweep sweep.yaml -o all.db & until grep -aFqs '\"}done' all.db-wal all.db; do sleep "
               "0.05; done; kill -KILL $!; wait $!");
    REQUIRE(work.exists("all.db-wal"));
    std::filesystem::create_symlink("all.db", work / "link.db");
    run_well(work, {"merge", "whole.db", "-o", "link.db"});
    CHECK_FALSE(work.exists("all.db-wal"));
    CHECK(exported(work, "all.db") == exported(work, "whole.db"));
}

TEST_CASE("merge: a few parts of a shard are not the shard", "[program][sweep]") {
    const Workplace work;
    std::string many = kSweep;
    many.replace(many.find("to: 59"), 6, "to: 259");
    work.write("sweep.yaml", many);
    // Stopped and started again: two parts at least, and the last one knows that the shard has ended.
    const std::string sweep = "\"$0\" sweep sweep.yaml --shard 1/1 --parts parts --quiet";
    // A busy computer takes longer until the first points are done.
    std::vector<std::filesystem::path> early;
    for (const char* seconds : {"0.7", "1.5", "3", "6", "12", "24"}) {
        std::filesystem::remove_all(work / "parts");
        run_script(work, sweep + " & sleep " + seconds + "; kill -TERM $!; wait $!");
        early.clear();
        for (const auto& entry : std::filesystem::directory_iterator(work / "parts"))
            early.push_back(entry.path());
        REQUIRE(early.size() < 2);
        if (!early.empty() && ResultsReader(early.front()).count() > 0) break;
    }
    REQUIRE(early.size() == 1);
    run_well(work, {"sweep", "sweep.yaml", "--shard", "1/1", "--parts", "parts", "--quiet"});
    const auto lost = ResultsReader(early.front()).count();
    REQUIRE(lost > 0);
    run_well(work, {"merge", "parts", "-o", "all.db"});
    std::filesystem::remove(early.front());
    const ProgramResult result = metabuffer_in(work, {"merge", "parts", "-o", "rest.db"});
    CHECK(result.status == kExitIncomplete);
    CHECK(result.err == "missing: " + std::to_string(lost) + " of the 480 points\n");
}

TEST_CASE("merge: after axes have grown, what counts is the larger sweep", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    run_well(work, {"sweep", "sweep.yaml", "-o", "all.db", "--quiet"});
    std::string more = kSweep;
    more.replace(more.find("to: 59"), 6, "to: 99");
    work.write("sweep.yaml", more);
    run_well(work, {"sweep", "sweep.yaml", "--shard", "2/4", "-o", "part-2.db", "--quiet"});
    const ProgramResult result = metabuffer_in(work, {"merge", "part-2.db", "-o", "all.db"});
    CHECK(result.status == kExitIncomplete);
    CHECK(result.err == "missing: shards 1, 3 and 4 of 4\n");
    run_well(work, {"sweep", "sweep.yaml", "-o", "all.db", "--quiet"});
    run_well(work, {"merge", "all.db", "-o", "all.db"});
}

TEST_CASE("merge: files may have names that mean something to SQLite or to a shell", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    std::filesystem::create_directory(work / "a 50%?#'b");
    run_well(work, {"sweep", "sweep.yaml", "--shard", "1/1", "-o", "a 50%?#'b/part;1.db", "--quiet"});
    run_well(work, {"merge", "a 50%?#'b", "-o", "a 50%?#'b/:memory:"});
    run_well(work, {"sweep", "sweep.yaml", "--shard", "1/1", "--parts", "a 50%?#'b", "--quiet"});
    CHECK(exported(work, "a 50%?#'b/:memory:") == exported(work, "a 50%?#'b"));
}

TEST_CASE("merge: results of another sweep, or none, are refused and nothing is written",
          "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    run_well(work, {"sweep", "sweep.yaml", "--shard", "1/2", "-o", "part-1.db", "--quiet"});
    std::string other = kSweep;
    other.replace(other.find("page_words: 16"), 14, "page_words: 32");
    work.write("other.yaml", other);
    run_well(work, {"sweep", "other.yaml", "--shard", "2/2", "-o", "part-2.db", "--quiet"});
    work.write("text.db", "hello");
    std::filesystem::create_directory(work / "empty");
    const std::string before = text_of(work / "part-1.db");
    check_refused_commands(
        work, "",
        {{"merge part-1.db part-2.db -o all.db", {"'part-2.db' holds results of other input"}},
         {"export part-1.db part-2.db", {"merge files of one sweep"}},
         {"merge part-2.db -o part-1.db", {"merge files of one sweep"}},
         {"merge part-1.db text.db -o all.db", {"it is no SQLite file"}},
         {"merge part-1.db none.db -o all.db", {"there is no such file"}},
         {"merge empty -o all.db", {"'empty' holds no results"}}});
    CHECK(text_of(work / "part-1.db") == before);
}

TEST_CASE("sweep: names of files do not make another sweep", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    run_well(work, {"sweep", "sweep.yaml", "--shard", "1/2", "-o", "part-1.db", "--quiet"});
    std::string renamed = kSweep;
    renamed.replace(renamed.find("scenario.yaml"), 13, "renamed.yaml");
    work.write("other.yaml", renamed);
    std::filesystem::copy_file(work / "scenario.yaml", work / "renamed.yaml");
    run_well(work, {"sweep", "other.yaml", "--shard", "2/2", "-o", "part-2.db", "--quiet"});
    run_well(work, {"merge", "part-1.db", "part-2.db", "-o", "all.db"});
    // Other content of the scenario's file does.
    work.write("renamed.yaml", text_of(work / "scenario.yaml") + "frames: 1\n");
    check_refused(metabuffer_in(work, {"sweep", "other.yaml", "--shard", "2/2", "-o", "part-2.db"}),
                  {"holds results of other input"});
}

TEST_CASE("parts: what was handed in is not run again, and a part that runs twice does no harm",
          "[program][sweep]") {
    const Workplace work;
    std::string many = kSweep;
    many.replace(many.find("to: 59"), 6, "to: 259");
    work.write("sweep.yaml", many);
    run_well(work, {"sweep", "sweep.yaml", "-o", "whole.db", "--quiet"});
    const std::string expected = exported(work, "whole.db");
    const std::string sweep = "\"$0\" sweep sweep.yaml --parts parts --hand-in 1 --quiet ";
    // Stopped: it hands in what it has.
    run_script(work, sweep + "--shard 1/2 & sleep 0.5; kill -TERM $!; wait $!");
    REQUIRE(work.exists("parts"));
    const ProgramResult first = metabuffer_in(work, {"merge", "parts", "-o", "first.db", "--quiet"});
    CHECK(first.status == kExitIncomplete);
    const auto ended = ResultsReader(work / "first.db").results().rows.size();
    // Killed: what it has handed in until then is there.
    run_script(work, sweep +
                         "--shard 2/2 & until ls parts/part-2-of-2-*.db >parts.log 2>&1; do sleep 0.05; "
                         "done; kill -KILL $!; wait $!");
    // The same shard by two at once, as after a job that was taken for dead.
    run_script(work, sweep + "--shard 2/2 & " + sweep + "--shard 2/2; wait $!");
    const ProgramResult rest =
        metabuffer_in(work, {"sweep", "sweep.yaml", "--shard", "1/2", "--parts", "parts"});
    CHECK(rest.status == kExitDone);
    CHECK_THAT(rest.out,
               Contains("240 of 240 points") && Contains(std::to_string(240 - ended) + " simulations"));
    run_well(work, {"merge", "parts", "-o", "all.db"});
    CHECK(exported(work, "all.db") == expected);
    CHECK(exported(work, "parts") == expected);
    // Cut another way, there is nothing to do either.
    const ProgramResult third =
        metabuffer_in(work, {"sweep", "sweep.yaml", "--shard", "2/3", "--parts", "parts"});
    CHECK(third.status == kExitDone);
    CHECK_THAT(third.out, Contains(", 0 simulations"));
}

TEST_CASE("parts: a folder with another sweep's results is refused", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    run_well(work, {"sweep", "sweep.yaml", "--shard", "1/9", "--parts", "parts", "--quiet"});
    std::string other = kSweep;
    other.replace(other.find("page_words: 16"), 14, "page_words: 32");
    work.write("sweep.yaml", other);
    check_refused(metabuffer_in(work, {"sweep", "sweep.yaml", "--shard", "2/9", "--parts", "parts"}),
                  {"name another, or remove it"});
}

TEST_CASE("shards: shard numbers that do not exist, and options that do not go together",
          "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    std::vector<RefusedCommand> wrong;
    for (const std::string shard :
         {"", "3", "0/2", "3/2", "1/0", "-1/2", "a/b", "1/2/3", "1/1000001", "1.5/2"}) {
        wrong.push_back({"--shard=" + shard + " -o r.db", {"use K/N, from 1/N to N/N"}});
    }
    for (const char* options : {"--parts parts", "--shard 1/2 --parts parts -o r.db", "--slurm 2 --shard 1/2",
                                "--sbatch=--time=1", "--no-wait"}) {
        wrong.push_back({options, {}});
    }
    check_refused_commands(work, "sweep sweep.yaml ", wrong);
    // More shards than points: some have none.
    run_well(work, {"sweep", "sweep.yaml", "--shard", "99/100", "-o", "r.db"});
    const ProgramResult list = metabuffer_in(work, {"sweep", "sweep.yaml", "--shard", "2/80", "--list"});
    CHECK(std::count(list.out.begin(), list.out.end(), '\n') == 1);
}

TEST_CASE("sweep: without Slurm, --slurm says which package has it", "[program][sweep]") {
    const Workplace work;
    work.write("sweep.yaml", kSweep);
    std::filesystem::create_directory(work / "nothing");
    const ProgramResult result =
        run_script(work, "PATH=nothing exec \"$0\" sweep sweep.yaml --slurm 2 -o r.db --quiet");
    check_refused(result, {"sbatch", "slurm-client"});
}

}  // namespace metabuffer::test::shard_commands_test
