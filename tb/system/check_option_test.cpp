#include <algorithm>
#include <catch2/catch.hpp>
#include <regex>

#include "workplace.h"

namespace metabuffer::test::check_option_test {
using Catch::Contains;

namespace {

ProgramResult run_faulty(const Workplace& work, const std::vector<std::string>& arguments) {
    return run_program(METABUFFER_WRONG_PROGRAM, work,
                       std::vector<std::string>{"run", "scenario.yaml", "--out", "out"} + arguments);
}

}  // namespace

TEST_CASE("run --check: a right model breaks no rule, nor does one that starves, and level rtl is run",
          "[program]") {
    const Workplace work;
    const ProgramResult result = work.run({"--check"});
    CHECK(result.status == 0);
    CHECK(result.err.empty());
    CHECK_THAT(result.out, Contains("small (rtl: "));
    CHECK_THAT(result.out, Contains(" 1536 pixels out of pipelines and 4 pictures: no violation\n"));
    const auto check = work.report().at("check");
    CHECK(work.report().at("level") == "rtl");
    CHECK(check.at("rules") > 50);
    CHECK(check.at("pictures") == 4);
    CHECK(check.at("violations") == 0);
    CHECK(check.at("first_violations").empty());
    const ProgramResult narrow = work.run(kNarrow + std::vector<std::string>{"--check"});
    CHECK(narrow.status == 0);
    CHECK_THAT(narrow.out, Contains("starved") && Contains(": no violation"));
    CHECK(work.report().at("totals").at("starved_pixels") > 0);
    // Without it the report says nothing of a check.
    const ProgramResult without = work.run({"--level", "rtl"});
    CHECK(without.status == 0);
    CHECK_THAT(without.out, !Contains("checked"));
    CHECK_FALSE(work.report().contains("check"));
}

TEST_CASE("run --check: level tlm has its pictures checked", "[program]") {
    const Workplace work;
    for (const std::vector<std::string>& trace :
         {std::vector<std::string>{"--level", "tlm"}, {"--trace", "schedule.json"}}) {
        const ProgramResult result = work.run(trace + std::vector<std::string>{"--check"});
        CHECK(result.status == 0);
        CHECK_THAT(result.out, Contains("small (tlm: ") &&
                                   Contains("checked: 4 of 4 pictures against the functional level, and no "
                                            "wires, which only level rtl has: no violation"));
        CHECK(work.report().at("check").at("rules") == 0);
        CHECK(work.report().at("check").at("pictures") == 4);
    }
    const ProgramResult narrow = work.run(kNarrow + std::vector<std::string>{"--level", "tlm", "--check"});
    CHECK(narrow.status == 0);
    CHECK_THAT(narrow.out, Contains("in the others something starved"));
}

TEST_CASE("run --check: what cannot be checked is refused in a line", "[program]") {
    const Workplace work;
    check_refused(work.run({"--check", "--level", "functional"}), {"use --level rtl or tlm"});
    check_refused(work.run({"--check", "--level", "tlm", "--no-images"}), {"use --level rtl"});
    CHECK(work.run({"--check", "--no-images"}).status == 0);
}

TEST_CASE("run --check: a wrong composer is found and traced to its clock", "[program]") {
    const Workplace work;  // every pixel is at Z = 0, so each one that both renderers cover is a tie
    CHECK(run_faulty(work, {"--level", "rtl"}).status == 0);

    const ProgramResult result = run_faulty(work, {"--check"});
    CHECK(result.status == 5);
    CHECK_THAT(result.err, Contains("scenario.yaml: --check: the model has broken a rule"));
    CHECK_THAT(result.err,
               Contains("renderer 1 (left) should have won") && Contains("composer_2_1 is the first"));
    CHECK_THAT(result.out, Contains(" violations\n"));
    CHECK(work.exists("out/display_1.png"));
    const auto check = work.report().at("check");
    const std::int64_t count = check.at("violations");
    const auto first = static_cast<std::int64_t>(check.at("first_violations").size());
    CHECK(count > 0);
    CHECK(first == std::min<std::int64_t>(count, 10));
    for (const auto& line : check.at("first_violations"))
        CHECK_THAT(result.err, Contains(line.get<std::string>()));
    if (count > first) CHECK_THAT(result.err, Contains("and " + std::to_string(count - first) + " more\n"));

    // The options that it names show that clock.
    std::smatch window;
    REQUIRE(std::regex_search(result.err, window,
                              std::regex("--trace FILE.vcd --trace-window (cycles:[0-9]+-[0-9]+)")));
    const ProgramResult traced =
        run_faulty(work, {"--check", "--trace", "wrong.vcd", "--trace-window", window[1].str()});
    CHECK(traced.status == 5);
    CHECK(work.exists("wrong.vcd"));
    CHECK(work.report().at("check") == check);
}

}  // namespace metabuffer::test::check_option_test
