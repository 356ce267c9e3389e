#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "program_run.h"
#include "report/counters.h"
#include "scenario/fault_kinds.h"
#include "scenario/scenario_loader.h"
#include "tools/exploration/figures.h"
#include "tools/program/exit_status.h"
#include "workplace.h"

// What the program says of its own tables: keys, counters, and the scenario that a run had.

namespace metabuffer::test::tables_test {
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

json answer(const Workplace& work, const std::vector<std::string>& words) {
    const ProgramResult result = run_program(work, words);
    INFO(result.err);
    REQUIRE(result.status == kExitDone);
    return json::parse(result.out);
}

/// One with faults, a table, two frames and most settings away from their defaults.
constexpr const char* kUnusual =
    "displays: {columns: 2, rows: 1, width: 24, height: 16, supersample: 2, background: [1, 2, 3]}\n"
    "composition: over\n"
    "depth_range: [0.5, 20]\n"
    "clocks: {core_mhz: 66.5}\n"
    "memory: {page_words: 64, page_miss_cycles: 4}\n"
    "bus: {width_bits: 32, burst_pixels: 8, arbitration: round-robin}\n"
    "composer: {buffer_pixels: 200, on_starvation: stall}\n"
    "renderers:\n"
    "  - name: it's left\n"
    "    copies: 2\n"
    "    frames:\n"
    "      - image: a.png\n"
    "        z: 0.75\n"
    "        viewport: {x: 3, y: 2, multiple: 1}\n"
    "      - image: a.png\n"
    "        z: 0.75\n"
    "        table: [[1, 0, 0, 8, 6, -1, 2, 2]]\n"
    "  - name: right\n"
    "    frames:\n"
    "      - image: b.png\n"
    "        z: 20\n"
    "        viewport: {x: 20, y: 1, multiple: 2}\n"
    "faults:\n"
    "  - {renderer: right, pair: 0, kind: crc, frame: depth}\n"
    "  - {renderer: it's left_2, pair: 1, kind: delay, delay_pairs: 1}\n";

}  // namespace

TEST_CASE("keys: every key is listed with a meaning, and what must be given says so") {
    const Workplace work;
    const json keys = answer(work, {"keys", "--json"});
    std::vector<std::string> paths;
    for (const json& key : keys) {
        INFO(key.dump());
        paths.push_back(key.at("path"));
        CHECK_FALSE(key.at("meaning").get<std::string>().empty());
        const std::string type = key.at("type");
        if (type == "whole number" && !key.contains("choices")) CHECK(key.at("minimum") < key.at("maximum"));
        if (type == "choice") CHECK(key.at("choices").size() >= 2);
    }
    CHECK(paths == scenario_key_paths());
    const auto key_of = [&keys](const std::string& path) {
        for (const json& key : keys) {
            if (key.at("path") == path) return key;
        }
        return json();
    };
    CHECK(key_of("displays.width").at("default") == "required");
    CHECK(key_of("displays.background").at("default") == "[0, 0, 0]");
    CHECK(key_of("bus.width_bits").at("default") == "64");
    CHECK(key_of("bus.width_bits").at("unit") == "bits");
    CHECK(key_of("bus.width_bits").at("choices") == json({16, 32, 64, 128, 256, 512}));
    CHECK(key_of("clocks.core_mhz").at("maximum") == 10000.0);
    CHECK(key_of("composer.on_starvation").at("choices") == json({"glitch", "stall"}));
    CHECK(key_of("faults[].kind").at("kinds").size() == kFaultKinds.size());
}

TEST_CASE("keys: a prefix selects, and one that begins no key is refused with the nearest") {
    const Workplace work;
    const ProgramResult bus = run_program(work, {"keys", "bus."});
    CHECK(bus.status == kExitDone);
    CHECK_THAT(bus.out, Contains("bus.burst_pixels") && Contains("1 to 65535") && Contains("pixels"));
    CHECK_THAT(bus.out, !Contains("memory."));
    CHECK_THAT(run_program(work, {"keys", "faults[].k"}).out, Contains("random_stalls"));
    const ProgramResult wrong = run_program(work, {"keys", "composr"});
    CHECK(wrong.status == kExitBadInput);
    CHECK(wrong.complains_in_one_line());
    CHECK_THAT(wrong.err, Contains("'composr'") && Contains("the nearest is composer"));
}

TEST_CASE("counters: every counter of a report and every figure is listed") {
    const Workplace work;
    const json tables = answer(work, {"counters", "--json"});
    REQUIRE(tables.at("figures").size() == exploration::figure_kinds().size());
    REQUIRE(run_program(work, {"run", "scenario.yaml", "--no-images", "--quiet", "--out", "out"}).status ==
            kExitDone);
    const json report = json::parse(text_of(work / "out/report.json"));
    for (const json& item : tables.at("costs"))
        CHECK(report.at("cost").contains(item.at("name").get<std::string>()));
    for (const json& counter : tables.at("counters")) {
        INFO(counter.dump());
        const std::string name = counter.at("name");
        const std::string total = counter.at("name_in_totals");
        const bool is_of_bus = counter.at("owners") == "buses";
        const std::string owners = is_of_bus ? "renderers" : counter.at("owners").get<std::string>();
        const json& owner = report.at(owners).at(0);
        CHECK((is_of_bus ? owner.at("bus") : owner).contains(name));
        CHECK((is_of_bus ? report.at("totals").at("bus") : report.at("totals")).contains(total));
    }
    CHECK_THAT(run_program(work, {"counters"}).out,
               Contains("busready_drops") && Contains("frames_per_second"));
}

TEST_CASE("a run leaves the scenario that it ran, and that file gives the same report") {
    const Workplace work;
    work.write("unusual.yaml", kUnusual);
    const auto run = [&work](const std::string& scenario, const std::string& out,
                             const std::vector<std::string>& more) {
        std::vector<std::string> words{"run", scenario, "--quiet", "--out", out};
        words.insert(words.end(), more.begin(), more.end());
        const ProgramResult result = run_program(work, words);
        INFO(result.err);
        REQUIRE(result.status == kExitDone);
        return text_of(work / out / "report.json");
    };
    for (const std::string level : {"tlm", "rtl", "functional"}) {
        INFO(level);
        const std::string first =
            run("unusual.yaml", "out/first", {"--level", level, "--set", "memory.words_per_cycle=2"});
        const std::string again = run("out/first/effective_scenario.yaml", "out/again", {"--level", level});
        CHECK(first == again);
        CHECK(text_of(work / "out/first/display_2.png") == text_of(work / "out/again/display_2.png"));
    }
    // Every key outside of lists, with its value; the name of the file that was run, not of this one.
    const std::string effective = text_of(work / "out/first/effective_scenario.yaml");
    CHECK_THAT(effective, Contains("name: 'unusual'") && Contains("words_per_cycle: 2") &&
                              Contains("ready_space_pixels: 8") && Contains("frames: 2") &&
                              Contains("background: [1, 2, 3]") && Contains("watchdog_cycles: 0") &&
                              Contains("image: '../../a.png'") && Contains("it''s left_2"));
    // The same again, whatever was overridden before.
    CHECK(text_of(work / "out/again/effective_scenario.yaml") == effective);
}

}  // namespace metabuffer::test::tables_test
