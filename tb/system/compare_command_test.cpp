#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "program_run.h"
#include "support/address_sanitizer.h"
#include "tools/program/exit_status.h"
#include "workplace.h"

// `metabuffer compare` from outside: the built program, and one whose level tlm does what the scenario's name says.

namespace metabuffer::test::compare_command_test {
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

ProgramResult compare(const Workplace& work, const std::vector<std::string>& arguments = {}) {
    return run_program(work, std::vector<std::string>{"compare", "scenario.yaml"} + arguments);
}

ProgramResult compare_faulty(const Workplace& work, const std::string& fault,
                             const std::vector<std::string>& arguments = {}) {
    return run_program(
        METABUFFER_FAULTY_PROGRAM, work,
        std::vector<std::string>{"compare", "scenario.yaml", "--set", "name=" + fault} + arguments);
}

std::ptrdiff_t lines_of(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

/// A comparison leaves no file, whatever it finds.
std::size_t files_in(const Workplace& work) {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(work.path())) {
        count += entry.path().filename().string().front() == '.' ? 0 : 1;
    }
    return count;
}

}  // namespace

TEST_CASE("compare: the levels are identical", "[program][compare]") {
    const Workplace work;
    const std::size_t files = files_in(work);
    for (const std::vector<std::string>& settings : {std::vector<std::string>{}, kNarrow}) {
        const ProgramResult result = compare(work, settings);
        CHECK(result.status == kExitDone);
        CHECK(result.err.empty());
        CHECK_THAT(result.out, StartsWith("identical; 2 frames on 2 displays, 4 composers, "));
        CHECK_THAT(result.out, Contains(" core clocks: ") && Contains("4 pictures compared") &&
                                   Contains(" by rtl, ") && Contains(" by tlm: ratio "));
        CHECK(lines_of(result.out) == 2);
    }
    CHECK(files_in(work) == files);
}

TEST_CASE("compare: --frames, --set, --no-images and --quiet", "[program][compare]") {
    const Workplace work;
    const ProgramResult longer = compare(work, {"--frames", "5", "--set", "bus.arbitration=edf"});
    CHECK(longer.status == kExitDone);
    CHECK_THAT(longer.out,
               StartsWith("identical; 5 frames on 2 displays") && Contains("10 pictures compared"));
    const ProgramResult counters = compare(work, {"--no-images", "--frames", "1"});
    CHECK(counters.status == kExitDone);
    CHECK_THAT(counters.out,
               StartsWith("identical; 1 frame on 2 displays") && Contains("no pictures compared"));
    const ProgramResult quiet = compare(work, {"--quiet"});
    CHECK(quiet.status == kExitDone);
    CHECK(quiet.out.empty());
    CHECK(quiet.err.empty());
}

TEST_CASE("compare: a run that the watchdog ends at both levels is identical", "[program][compare]") {
    const Workplace work;
    work.write("scenario.yaml", std::string(kScenario) +
                                    "link_timeout_pairs: 1000\n"
                                    "watchdog_cycles: 2000\n"
                                    "faults: [{renderer: right, pair: 1, kind: delay, delay_pairs: 100}]\n");
    const ProgramResult result = compare(work);
    CHECK(result.status == kExitDone);
    CHECK_THAT(result.out, StartsWith("identical;") && Contains("2 pictures compared") &&
                               Contains("the watchdog ended the run at both levels"));
}

TEST_CASE("compare: bad input is refused in one line", "[program][compare][bad input]") {
    check_refused_commands(Workplace(), "compare",
                           {{"", {"SCENARIO"}},
                            {" missing.yaml", {"missing.yaml"}},
                            {" scenario.yaml --set bus.width_bits=65", {"--set"}},
                            {" scenario.yaml --set bus.width_bits", {"PATH=VALUE"}},
                            {" scenario.yaml --frames 0", {"--frames"}},
                            {" scenario.yaml --level rtl", {"--level"}},
                            {" scenario.yaml --out out", {"--out"}},
                            {" scenario.yaml run", {"run"}}});
}

TEST_CASE("compare: a counter that differs is reported by its names", "[program][compare]") {
    const Workplace work;
    const std::size_t files = files_in(work);
    const ProgramResult result = compare_faulty(work, "counter");
    CHECK(result.status == kExitDifferent);
    CHECK(result.err.empty());
    CHECK_THAT(result.out, StartsWith("composers[renderer right, display 1].late_pixels: rtl 0, tlm 1\n"
                                      "totals.late_pixels: rtl 0, tlm 1\n"
                                      "2 differences; 2 frames on 2 displays"));
    const ProgramResult quiet = compare_faulty(work, "counter", {"--quiet", "--no-images"});
    CHECK(quiet.status == kExitDifferent);
    CHECK(lines_of(quiet.out) == 2);
    CHECK(files_in(work) == files);
}

TEST_CASE("compare: pictures that differ, and the watchdog of one level, are reported",
          "[program][compare][repeat]") {
    const Workplace work;
    const ProgramResult differ = compare_faulty(work, "picture");
    CHECK(differ.status == kExitDifferent);
    CHECK_THAT(differ.out, StartsWith("display_2 frame 1: 2 pixels differ, first at 12,5: rtl #"));
    CHECK_THAT(differ.out, Contains("\n1 difference;"));
    const ProgramResult lost = compare_faulty(work, "lost picture");
    CHECK(lost.status == kExitDifferent);
    CHECK_THAT(lost.out, StartsWith("display_1 frame 0: shown by rtl only\n1 difference;"));
    CHECK(compare_faulty(work, "picture", {"--no-images"}).status == kExitDone);
    const ProgramResult watchdog = compare_faulty(work, "watchdog");
    CHECK(watchdog.status == kExitDifferent);
    CHECK_THAT(watchdog.out, Contains("\nwatchdog[0]: rtl none, tlm \"composer_1_1 waits for a pixel\"\n") &&
                                 !Contains("at both levels"));
}

TEST_CASE("compare: many differences are cut short", "[program][compare][repeat]") {
    const Workplace work;
    const ProgramResult result = compare_faulty(work, "all pictures", {"--frames", "60"});
    CHECK(result.status == kExitDifferent);
    CHECK(lines_of(result.out) == 100 + 1 + 2);
    CHECK_THAT(result.out, StartsWith("display_1 frame 0: 1 pixel differs at 23,15") &&
                               Contains("\n... and 20 more\n120 differences;"));
    const ProgramResult quiet = compare_faulty(work, "all pictures", {"--frames", "60", "--quiet"});
    CHECK(lines_of(quiet.out) == 100 + 1);
}

TEST_CASE("compare: a level that fails is named", "[program][compare]") {
    const Workplace work;
    struct Case {
        const char* fault;
        ExitStatus status;
        const char* words;
    };
    for (const Case& failing :
         {Case{"error", kExitModelError, "metabuffer/test: told to fail"},
          Case{"exception", kExitModelError, "told to throw"}, Case{"crash", kExitModelError, "Aborted"},
          Case{"late crash", kExitModelError, "Aborted"}, Case{"exit", kExitModelError, "without a report"},
          Case{"input", kExitBadInput, "told to refuse"},
          Case{"memory", kExitBadInput, "does not have the memory"}}) {
        const ProgramResult result = compare_faulty(work, failing.fault);
        INFO(failing.fault << ": " << result.err);
        CHECK(result.status == failing.status);
        CHECK(result.out.empty());
        CHECK(result.complains_in_one_line());
        CHECK_THAT(result.err, StartsWith("scenario.yaml: level tlm failed: ") && Contains(failing.words));
    }
}

#ifndef METABUFFER_ADDRESS_SANITIZER

/// Limits a process's memory, so it is not a test for a sanitizer, which takes terabytes of addresses.
TEST_CASE("compare: two levels that fail alike are reported in one line", "[program][compare]") {
    const Workplace work;
    // The four composers' buffers take 512 MiB in either process, which is more than the limit.
    const ProgramResult result = run_program(
        "/bin/sh", work,
        {"-c", "ulimit -v 520000; exec \"$0\" compare scenario.yaml --set composer.buffer_pixels=16777216",
         METABUFFER_FAULTY_PROGRAM});
    CHECK(result.status == kExitBadInput);
    CHECK(result.out.empty());
    CHECK(result.complains_in_one_line());
    CHECK_THAT(result.err,
               StartsWith("scenario.yaml: both levels failed: ") && Contains("does not have the memory"));
}

#endif

}  // namespace metabuffer::test::compare_command_test
