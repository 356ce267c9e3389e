#include "coverage.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cover_group.h"
#include "coverage_file.h"
#include "coverage_report.h"
#include "key_coverage.h"
#include "support/scratch_directory.h"

using namespace metabuffer::coverage;
using Catch::Matchers::Contains;

namespace {

enum class Colour : std::uint8_t { kRed, kGreen };

Axis<Colour> colours() { return {{Colour::kRed, "red"}, {Colour::kGreen, "green"}}; }

struct LampGoals : CoverGroup {
    explicit LampGoals(Coverage& coverage) : CoverGroup(coverage, {"lamp", "what a lamp can do"}) {}
    Bin lit = bin("lit");
    Bin dark = bin("dark");
    Cross<Colour, int> blinks{*this, colours(), numbers(2, 3, " times")};
    Ranges hours{*this, {{1, "an hour"}, {2, "2 to 9 hours"}, {10, "longer"}}};
};

struct SwitchGoals : CoverGroup {
    explicit SwitchGoals(Coverage& coverage) : CoverGroup(coverage, {"switch", "what a switch can do"}) {}
    Bin clicks = bin("clicks");
};

/// Both, with their Coverage.
struct HouseGoals {
    Coverage coverage;
    LampGoals lamp{coverage};
    SwitchGoals light_switch{coverage};
};

std::vector<std::string> names(const Coverage& coverage, const std::string& group) {
    std::vector<std::string> result;
    for (const Goal& goal : coverage.groups().at(group).goals) result.push_back(goal.name);
    return result;
}

void write(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

}  // namespace

TEST_CASE("coverage: goals are known once they are declared, also those that are never hit") {
    const HouseGoals goals;
    CHECK(goals.coverage.goal_count() == 10);
    CHECK(goals.coverage.groups().size() == 2);
    CHECK(names(goals.coverage, "switch") == std::vector<std::string>{"clicks"});
    CHECK(names(goals.coverage, "lamp") ==
          std::vector<std::string>{"lit", "dark", "red, 2 times", "red, 3 times", "green, 2 times",
                                   "green, 3 times", "an hour", "2 to 9 hours", "longer"});
    CHECK(goals.coverage.has_goal("lamp: red, 2 times"));
    CHECK_FALSE(goals.coverage.has_goal("lamp: clicks"));
    CHECK_FALSE(goals.coverage.has_goal("lamps: lit"));
    CHECK_FALSE(goals.coverage.has_goal(""));
    for (const auto& [name, group] : goals.coverage.groups()) {
        for (const Goal& goal : group.goals) CHECK(goal.count == 0);
    }
}

TEST_CASE("coverage: a goal is declared once, and a group means one thing") {
    Coverage coverage;
    const LampGoals lamp(coverage);
    CoverGroup more(coverage, {"lamp", "what a lamp can do"});
    CHECK_NOTHROW(more.bin("broken"));
    CHECK_THROWS_AS(more.bin("lit"), std::logic_error);
    CHECK(coverage.goal_count() == 10);
    CoverGroup other(coverage, {"lamp", "what a lamp is made of"});
    CHECK_THROWS_AS(other.bin("glass"), std::logic_error);
}

TEST_CASE("coverage: hits count for the goal of the value") {
    const HouseGoals goals;
    goals.lamp.lit.hit_if(false);
    CHECK(goals.lamp.lit.count() == 0);
    goals.lamp.lit.hit(3);
    goals.lamp.lit.hit_if(true);
    goals.lamp.lit.hit();
    CHECK(goals.lamp.lit.count() == 5);
    goals.lamp.blinks(Colour::kGreen, 3).hit();
    CHECK_THROWS_AS(goals.lamp.blinks(Colour::kGreen, 4), std::out_of_range);
    for (const int hours : {1, 2, 9, 10, 1000}) goals.lamp.hours(hours).hit();
    CHECK(record_of("x", goals.coverage).counts ==
          std::map<std::string, std::int64_t>{{"lamp: lit", 5},
                                              {"lamp: green, 3 times", 1},
                                              {"lamp: an hour", 1},
                                              {"lamp: 2 to 9 hours", 2},
                                              {"lamp: longer", 2}});
}

TEST_CASE("coverage: every enumerator is a goal, by its name") {
    const Axis<metabuffer::StarvationMode> modes = every<metabuffer::StarvationMode>("in ", " mode");
    REQUIRE(modes.size() == metabuffer::EnumNames<metabuffer::StarvationMode>::kTable.size());
    CHECK(modes[0].first == metabuffer::StarvationMode::kGlitch);
    CHECK(modes[0].second == "in glitch mode");
}

TEST_CASE(
    "coverage: a scenario hits one value of each key and one pair of two keys; a fault hits its own keys") {
    Coverage coverage;
    const KeyGoals goals(coverage);
    CHECK_FALSE(coverage.has_goal("scenario/values: depth_bits channel"));
    metabuffer::Scenario scenario;
    scenario.memory.banks = 4;
    scenario.bus.arbitration = metabuffer::Arbitration::kEdf;
    goals.cover(scenario);
    metabuffer::Fault fault;
    fault.kind = metabuffer::FaultKind::kTmdsSlip;
    fault.channel = metabuffer::TmdsChannel::kRed;
    goals.cover(fault);
    const std::map<std::string, std::int64_t> counts = record_of("x", coverage).counts;
    for (const char* hit :
         {"scenario/values: memory.banks 4", "scenario/values: memory.read_latency_cycles 0",
          "scenario/pairs: memory.banks 4, bus.arbitration edf", "scenario/values: faults[].kind tmds_slip",
          "scenario/values: faults[].channel red"}) {
        INFO(hit);
        CHECK(counts.count(hit) == 1);
    }
    for (const char* missed :
         {"scenario/values: memory.banks 2", "scenario/pairs: memory.banks 4, bus.arbitration irsa",
          "scenario/values: faults[].of pixels"}) {
        INFO(missed);
        CHECK(coverage.has_goal(missed));
        CHECK(counts.count(missed) == 0);
    }
}

TEST_CASE("coverage: records of a process add up in its file") {
    const HouseGoals goals;
    const metabuffer::test::ScratchDirectory scratch;
    const auto file = scratch.path() / "new" / "7.coverage";
    append_record(file, {"first test", {{"lamp: lit", 2}, {"lamp: red, 2 times", 1}}});
    append_record(file, {"second: test", {{"switch: clicks", 1}}});
    const std::vector<Record> records = read_records(file, goals.coverage);
    REQUIRE(records.size() == 2);
    CHECK(records[0].test == "first test");
    CHECK(records[0].counts ==
          std::map<std::string, std::int64_t>{{"lamp: lit", 2}, {"lamp: red, 2 times", 1}});
    CHECK(records[1].test == "second: test");
    CHECK(records[1].counts == std::map<std::string, std::int64_t>{{"switch: clicks", 1}});
}

TEST_CASE("coverage: a damaged file is refused and says where") {
    const HouseGoals goals;
    const metabuffer::test::ScratchDirectory scratch;
    const auto file = scratch.path() / "a.coverage";
    const std::string good = "test x\n2 lamp: lit\n";
    const std::vector<std::pair<std::string, std::string>> damaged{
        {"", "holds no record"},
        {good, "a.coverage:3: the record ends without"},
        {good + "test y\nend\n", "a.coverage:3: expected \"COUNT GROUP: BIN\""},
        {"2 lamp: lit\nend\n", "a.coverage:1: expected \"test NAME\""},
        {"test x\n1 bus/none: whole\nend\n", "a.coverage:2: there is no goal \"bus/none: whole\""},
        {"test x\n0 lamp: lit\nend\n", "a.coverage:2: expected"},
        {"test x\n-1 lamp: lit\nend\n", "a.coverage:2: expected"},
        {"test x\n1lamp: lit\nend\n", "a.coverage:2: expected"},
        {"test x\n99999999999999999999 lamp: lit\nend\n", "a.coverage:2: expected"},
        {"test x\n\nend\n", "a.coverage:2: expected"},
    };
    for (const auto& [text, complaint] : damaged) {
        INFO(text);
        write(file, text);
        CHECK_THROWS_WITH(read_records(file, goals.coverage), Contains(complaint));
        CHECK_THROWS_AS(merge_directory(scratch.path(), goals.coverage), CoverageFileError);
    }
    write(file, good + "end\n");
    CHECK_NOTHROW(merge_directory(scratch.path(), goals.coverage));
    CHECK_THROWS_WITH(read_records(scratch.path() / "none", goals.coverage), Contains("cannot be read"));
}

TEST_CASE("coverage: merged counts are sums and name the first test") {
    const HouseGoals goals;
    const metabuffer::test::ScratchDirectory scratch;
    append_record(scratch.path() / "1.coverage", {"b", {{"lamp: lit", 1}}});
    append_record(scratch.path() / "2.coverage", {"a", {{"lamp: lit", 1}, {"lamp: dark", 1}}});
    append_record(scratch.path() / "2.coverage", {"c", {{"lamp: dark", 1}}});
    write(scratch.path() / "notes.txt", "no coverage");
    const MergedCoverage merged = merge_directory(scratch.path(), goals.coverage);
    CHECK(merged.records() == 3);
    CHECK(merged.reached("lamp", "lit").count == 2);
    CHECK(merged.reached("lamp", "dark").count == 2);
    CHECK(merged.reached("lamp", "lit").first_test == "a");
    CHECK(merged.reached("switch", "clicks").count == 0);
    CHECK(merged.reached("switch", "clicks").first_test.empty());
    CHECK(merged.goals_reached() == 2);
    CHECK(merged.reached_in("lamp") == 2);
    CHECK(merged.reached_in("switch") == 0);
    CHECK(merged.percent() == 20.0);
    CHECK_THROWS_WITH(merge_directory(scratch.path() / "none", goals.coverage), Contains("none"));
    std::filesystem::create_directory(scratch.path() / "empty");
    CHECK_THROWS_WITH(merge_directory(scratch.path() / "empty", goals.coverage),
                      Contains("METABUFFER_COVERAGE"));
}

TEST_CASE("coverage: the report names every hole and no goal that is reached") {
    const HouseGoals goals;
    MergedCoverage merged(goals.coverage);
    merged.add({"some test", {{"lamp: dark", 1}}});
    const std::string text = text_report(merged, 90.0, false);
    CHECK_THAT(text, Contains("    HOLE  lit\n"));
    CHECK_THAT(text, Contains("    HOLE  clicks\n"));
    CHECK_THAT(text, !Contains("    HOLE  dark\n"));
    CHECK_THAT(text, Contains("1 of 10 goals reached"));
    CHECK_THAT(text, Contains("threshold 90.0 %"));
    CHECK_THAT(text_report(merged, 90.0, true), Contains("    dark: 1, first in some test\n"));
    const auto json = nlohmann::json::parse(json_report(merged, 90.0));
    CHECK(json.at("reached") == 1);
    CHECK(json.at("goals") == 10);
    CHECK(json.at("groups").at(0).at("bins").at(1).at("first_test") == "some test");
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
