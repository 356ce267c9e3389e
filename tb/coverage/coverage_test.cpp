#include "coverage.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>

#include "bin_names.h"
#include "coverage_file.h"
#include "coverage_report.h"
#include "goals.h"
#include "scratch_directory.h"

using namespace metabuffer::coverage;
using Catch::Matchers::Contains;

namespace {

/// Some goal, by its place.
std::pair<std::string, std::string> goal_at(std::size_t place) {
    for (const GoalGroup& group : goal_groups()) {
        if (place < group.bins.size()) return {group.name, group.bins[place]};
        place -= group.bins.size();
    }
    throw std::out_of_range("no such goal");
}

Record record_of(const std::string& test, const std::vector<std::size_t>& goals) {
    Record record{test, {}};
    for (const std::size_t goal : goals) ++record.coverage.counter(goal);
    return record;
}

void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

}  // namespace

TEST_CASE("coverage: goals have names of their own that files can hold") {
    std::set<std::string> groups;
    std::size_t place = 0;
    for (const GoalGroup& group : goal_groups()) {
        INFO(group.name);
        CHECK(groups.insert(group.name).second);
        CHECK_FALSE(group.meaning.empty());
        CHECK_FALSE(group.bins.empty());
        CHECK(group.name.find(": ") == std::string::npos);
        for (const std::string& bin : group.bins) {
            INFO(bin);
            CHECK(goal_index(group.name, bin) == place++);
            CHECK(bin.find('\n') == std::string::npos);
        }
    }
    CHECK(place == goal_count());
    CHECK(goal_count() >= 250);
}

TEST_CASE("coverage: a name that is no goal is a mistake of the sampler") {
    Coverage coverage;
    CHECK_THROWS_AS(coverage.hit("bus/burst", "of two and a half pixels"), std::logic_error);
    CHECK_THROWS_AS(coverage.hit("bus/burts", "whole"), std::logic_error);
    CHECK_FALSE(is_goal("bus/burst", ""));
    coverage.hit_if(false, "bus/burst", "whole");
    CHECK(coverage.count("bus/burst", "whole") == 0);
    coverage.hit("bus/burst", "whole", 3);
    Bin bin(coverage, "bus/burst", "whole");
    bin.hit();
    bin.hit_if(false);
    CHECK(coverage.count("bus/burst", "whole") == 4);
}

TEST_CASE("coverage: records of a process add up in its file") {
    const metabuffer::test::ScratchDirectory scratch;
    const auto file = scratch.path() / "new" / "7.coverage";
    append_record(file, record_of("first test", {0, 0, 5}));
    append_record(file, record_of("second: test", {1}));
    const std::vector<Record> records = read_records(file);
    REQUIRE(records.size() == 2);
    CHECK(records[0].test == "first test");
    CHECK(records[0].coverage.count(std::size_t{0}) == 2);
    CHECK(records[0].coverage.count(std::size_t{5}) == 1);
    CHECK(records[0].coverage.count(std::size_t{1}) == 0);
    CHECK(records[1].test == "second: test");
    CHECK(records[1].coverage.count(std::size_t{1}) == 1);
}

TEST_CASE("coverage: a damaged file is refused and says where") {
    const metabuffer::test::ScratchDirectory scratch;
    const auto file = scratch.path() / "a.coverage";
    const auto [group, bin] = goal_at(0);
    const std::string good = "test x\n2 " + group + ": " + bin + "\n";
    const std::vector<std::pair<std::string, std::string>> damaged{
        {"", "holds no record"},
        {good, "a.coverage:3: the record ends without"},
        {good + "test y\nend\n", "a.coverage:3: expected \"COUNT GROUP: BIN\""},
        {"2 " + group + ": " + bin + "\nend\n", "a.coverage:1: expected \"test NAME\""},
        {"test x\n1 bus/none: whole\nend\n", "a.coverage:2: there is no goal \"bus/none: whole\""},
        {"test x\n0 " + group + ": " + bin + "\nend\n", "a.coverage:2: expected"},
        {"test x\n-1 " + group + ": " + bin + "\nend\n", "a.coverage:2: expected"},
        {"test x\n1" + group + ": " + bin + "\nend\n", "a.coverage:2: expected"},
        {"test x\n99999999999999999999 " + group + ": " + bin + "\nend\n", "a.coverage:2: expected"},
        {"test x\n\nend\n", "a.coverage:2: expected"},
    };
    for (const auto& [text, complaint] : damaged) {
        INFO(text);
        write(file, text);
        CHECK_THROWS_WITH(read_records(file), Contains(complaint));
        CHECK_THROWS_AS(merge_directory(scratch.path()), CoverageFileError);
    }
    write(file, good + "end\n");
    CHECK_NOTHROW(merge_directory(scratch.path()));
    CHECK_THROWS_WITH(read_records(scratch.path() / "none"), Contains("cannot be read"));
}

TEST_CASE("coverage: merged counts are sums and name the first test") {
    const metabuffer::test::ScratchDirectory scratch;
    append_record(scratch.path() / "1.coverage", record_of("b", {3}));
    append_record(scratch.path() / "2.coverage", record_of("a", {3, 4}));
    append_record(scratch.path() / "2.coverage", record_of("c", {4}));
    write(scratch.path() / "notes.txt", "no coverage");
    const MergedCoverage merged = merge_directory(scratch.path());
    CHECK(merged.records() == 3);
    CHECK(merged.count(3) == 2);
    CHECK(merged.count(4) == 2);
    CHECK(merged.first_test(3) == "a");
    CHECK(merged.first_test(5).empty());
    CHECK(merged.reached() == 2);
    CHECK_THROWS_WITH(merge_directory(scratch.path() / "none"), Contains("none"));
    std::filesystem::create_directory(scratch.path() / "empty");
    CHECK_THROWS_WITH(merge_directory(scratch.path() / "empty"), Contains("METABUFFER_COVERAGE"));
}

TEST_CASE("coverage: the report names every hole and no goal that is reached") {
    MergedCoverage merged;
    merged.add(record_of("some test", {2}));
    const auto [hole_group, hole] = goal_at(0);
    const auto [group, reached] = goal_at(2);
    const std::string text = text_report(merged, 90.0, false);
    CHECK_THAT(text, Contains("    HOLE  " + hole + "\n"));
    CHECK_THAT(text, !Contains("    HOLE  " + reached + "\n"));
    CHECK_THAT(text, Contains("1 of " + std::to_string(goal_count()) + " goals reached"));
    CHECK_THAT(text, Contains("threshold 90.0 %"));
    CHECK_THAT(text_report(merged, 90.0, true), Contains("    " + reached + ": 1, first in some test\n"));
    const auto json = nlohmann::json::parse(json_report(merged, 90.0));
    CHECK(json.at("reached") == 1);
    CHECK(json.at("goals") == goal_count());
    CHECK(json.at("groups").at(0).at("bins").at(2).at("first_test") == "some test");
    CHECK(json.at("groups").at(0).at("bins").at(0).at("count") == 0);
}

TEST_CASE("coverage: the threshold is one number") {
    const metabuffer::test::ScratchDirectory scratch;
    const auto file = scratch.path() / "threshold.txt";
    write(file, "# why\n\n97.5\n");
    CHECK(read_threshold(file) == 97.5);
    for (const char* text : {"", "# only words\n", "much\n", "101\n", "-1\n", "90 %\n"}) {
        INFO(text);
        write(file, text);
        CHECK_THROWS_AS(read_threshold(file), CoverageFileError);
    }
    CHECK_THROWS_AS(read_threshold(scratch.path() / "none"), CoverageFileError);
}

TEST_CASE("coverage: clock ratios are told apart") {
    const auto ratio = [](std::int64_t core, std::int64_t out) {
        return std::string(clock_ratio_name(core, out));
    };
    // Periods of the core clock and of DVI out.
    CHECK(ratio(100, 300) == "DVI out slower by a whole factor");
    CHECK(ratio(100, 250) == "DVI out slower");
    CHECK(ratio(100, 100) == "DVI out equal");
    CHECK(ratio(250, 100) == "DVI out faster");
    CHECK(ratio(300, 100) == "DVI out faster by a whole factor");
}
