#include <catch2/catch.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "program_run.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/results_database.h"
#include "tools/program/exit_status.h"

// `metabuffer export` from outside, on files that the library wrote.

namespace metabuffer::test::export_command_test {
namespace {

using Catch::Matchers::Contains;
using exploration::figure_kinds;
using exploration::PointRecord;
using exploration::ResultsDatabase;
using exploration::RunRecord;
using exploration::RunStatus;
using nlohmann::json;

void add(ResultsDatabase& database, const std::string& width_bits, const std::string& arbitration,
         std::int64_t figure) {
    RunRecord run;
    run.settings = {{"bus.width_bits", width_bits}, {"bus.arbitration", arbitration}};
    run.figures.assign(figure_kinds().size(), figure);
    PointRecord point;
    point.settings = run.settings;
    if (figure < 0) {
        run.figures.clear();
        run.status = point.status = RunStatus::kCrashed;
        run.reason = point.reason = "ended with \"signal 11\", no report";
    }
    database.add_point(point, run);
}

ScratchDirectory& with_results(ScratchDirectory& scratch) {
    ResultsDatabase database = ResultsDatabase::open(
        scratch / "r.db", {"widths", "f", {}, {"bus.width_bits", "bus.arbitration"}, "", "", "", "", {}});
    add(database, "128", "irsa", 3);
    add(database, "64", "edf", -1);
    add(database, "64", "irsa", 5);
    return scratch;
}

}  // namespace

TEST_CASE("export: CSV of chosen columns and points on standard output") {
    ScratchDirectory scratch;
    const ProgramResult result = run_program(
        with_results(scratch), {"export", "r.db", "--columns", "bus.width_bits, reason, max(bursts, 4)"});
    CHECK(result.status == kExitDone);
    CHECK(result.err.empty());
    CHECK(result.out ==
          "bus.width_bits,reason,\"max(bursts, 4)\"\r\n"
          "64,\"ended with \"\"signal 11\"\", no report\",\r\n"
          "64,,5\r\n"
          "128,,4\r\n");
    const ProgramResult chosen = run_program(scratch, {"export", "r.db", "--columns", "point", "--where",
                                                       "bus.arbitration = 'irsa' and bursts > 3"});
    CHECK(chosen.out == "point\r\n3\r\n");
}

TEST_CASE("export: JSON holds every column - numbers as numbers and nothing as null") {
    ScratchDirectory scratch;
    const ProgramResult result = run_program(with_results(scratch), {"export", "r.db", "-o", "r.json"});
    CHECK(result.status == kExitDone);
    CHECK(result.out.empty());
    const json rows = json::parse(text_of(scratch / "r.json"));
    REQUIRE(rows.size() == 3);
    CHECK(rows[0]["bus.width_bits"] == 64);
    CHECK(rows[0]["status"] == "crashed");
    CHECK(rows[0]["bursts"].is_null());
    CHECK(rows[2]["bursts"] == 3);
    for (const auto& kind : figure_kinds()) CHECK(rows[2].contains(kind.name));
    CHECK(scratch.names() == std::vector<std::string>{".stderr", ".stdout", "r.db", "r.json"});
}

TEST_CASE("export: every simulation in its own row") {
    ScratchDirectory scratch;
    const ProgramResult result =
        run_program(with_results(scratch), {"export", "r.db", "--runs", "--format", "json"});
    CHECK(result.status == kExitDone);
    const json rows = json::parse(result.out);
    REQUIRE(rows.size() == 3);
    CHECK(json::parse(rows[0]["settings"].get<std::string>())["bus.width_bits"] == "128");
}

TEST_CASE("export: what cannot be done is reported on one line") {
    ScratchDirectory scratch;
    with_results(scratch);
    const auto refused = [&scratch](std::vector<std::string> arguments, const std::string& words) {
        arguments.insert(arguments.begin(), {"export"});
        check_refused(run_program(scratch, arguments), {words});
    };
    refused({}, "RESULTS");
    refused({"none.db"}, "'none.db' cannot be read: there is no such file");
    refused({"r.db", "--where", "bus.width_bit = 1"},
            "--where: 'bus.width_bit' is not known; the nearest is bus.width_bits");
    refused({"r.db", "--where", "1; drop table runs"}, "--where: ';' has no place");
    refused({"r.db", "--columns", "point,(select 1)"}, "--columns: ");
    refused({"r.db", "--columns", "point,,run"}, "--columns: there is no expression");
    refused({"r.db", "--runs", "--where", "1"}, "--where");
    refused({"r.db", "--format", "xml"}, "xml");
    refused({"r.db", "-o", "r.txt"}, "r.txt");
    refused({"r.db", "-o", "r.db", "--format", "csv"}, "would replace");
    refused({"r.db", "-o", "none/r.csv"}, "none/r.csv");
    CHECK(scratch.names() == std::vector<std::string>{".stderr", ".stdout", "r.db"});
    CHECK(run_program(scratch, {"export", "r.db"}).status == kExitDone);
}

TEST_CASE("export: the documentation has every figure and every function") {
    const std::string document = text_of(std::string(METABUFFER_SOURCE_DIRECTORY) + "/docs/results.md");
    for (const auto& kind : figure_kinds()) {
        CHECK_THAT(document, Contains(std::string("| `") + kind.name + "` | " + kind.unit + " | " +
                                      kind.meaning + " |"));
    }
    for (const std::string& function : exploration::expression_functions()) {
        CHECK_THAT(document, Contains("`" + function + "`"));
    }
}

}  // namespace metabuffer::test::export_command_test
