#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "images/image_codec.h"
#include "program_run.h"
#include "tools/program/exit_status.h"
#include "workplace.h"

// The built program from outside, as a user meets it.

namespace metabuffer::test::command_line_test {
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using nlohmann::json;

namespace {

constexpr std::int64_t kPeriodPicoseconds = 10'000;  // of the default 100 MHz

/// The scenario with one piece of its text replaced.
std::string with(const std::string& old_text, const std::string& new_text) {
    std::string text = kScenario;
    const std::size_t at = text.find(old_text);
    REQUIRE(at != std::string::npos);
    return text.replace(at, old_text.size(), new_text);
}

std::int64_t total(const json& report, const char* key) {
    return report.at("totals").at(key).get<std::int64_t>();
}

/// The core clocks that the program says its waveform shows.
struct ShownCycles {
    std::int64_t first = -1;
    std::int64_t last = -1;
};

ShownCycles shown_cycles(const ProgramResult& result) {
    const std::regex line("waveform .*: core clocks ([0-9]+) to ([0-9]+)[\n,]");
    std::smatch match;
    if (!std::regex_search(result.out, match, line)) return {};
    return {std::stoll(match[1]), std::stoll(match[2])};
}

/// The dump holds just the clocks first..last: initial values at the first, the last change within the last.
void check_time_range(const Waveform& waveform, const ShownCycles& cycles) {
    CHECK(waveform.first_time() == cycles.first * kPeriodPicoseconds);
    CHECK(waveform.last_time() >= cycles.last * kPeriodPicoseconds);
    CHECK(waveform.last_time() < (cycles.last + 1) * kPeriodPicoseconds);
}

}  // namespace

TEST_CASE("help says what there is", "[program]") {
    const Workplace work;
    const std::vector<RefusedCommand> commands{
        {"--help", {"run", "compare"}},
        {"run --help",
         {"SCENARIO", "--level", "default: tlm", "--out", "--set", "--frames", "--trace", ".vcd", ".json",
          "--trace-window", "--trace-modules", "--no-images", "--strict", "--check", "Exit status",
          "5 --check and the model broke a rule"}},
        {"compare --help", {"SCENARIO", "--set", "--frames", "--no-images", "--quiet", "Exit status", "5 "}}};
    for (const auto& [arguments, words] : commands) {
        const ProgramResult help = run_program(work, words_of(arguments));
        CHECK(help.status == kExitDone);
        CHECK(help.err.empty());
        for (const std::string& word : words) CHECK_THAT(help.out, Contains(word));
    }
}

/// What the readers refuse, and with which words, is judged without the program (tb/unit/scenario).
TEST_CASE("a bad scenario is refused in one line that says where and what", "[program][bad input]") {
    struct BadScenario {
        std::string text;
        std::vector<std::string> words;
    };
    const std::vector<BadScenario> bad{
        {std::string(kScenario) + "compositon: z\n", {":16", "compositon", "composition"}},
        {with("displays: {columns: 2, rows: 1, width: 24, height: 16}\n", ""), {"displays"}},
        {with("256", "48"), {":4", "bus.width_bits", "32, 64"}},
        {with("name: right", "name: left"), {":12", "left"}},
        {with("b.png", "c.png"), {":10", "c.png"}},
        {with("b.png", "scenario.yaml"), {":10", "scenario.yaml"}},
        {with("b.png", "other-size.png"), {":10", "40 x 21", "40 x 20"}},
        {with("a.png, z: 0", "a.png"), {":8", "a.png", "no Z", "depth", "z"}},
        {std::string(kScenario) + "faults: [{renderer: lift, pair: 0, kind: crc}]\n",
         {":16", "lift", "left"}},
        {with("columns: 2,", "columns: 2]"), {":2", "YAML"}},
        {"", {"empty"}},
        {"- 1\n- 2\n", {"map"}},
    };
    const Workplace work;
    for (const auto& [text, words] : bad) {
        work.write("scenario.yaml", text);
        check_refused_commands(work, "run scenario.yaml --out out",
                               {{"", std::vector<std::string>{"scenario.yaml"} + words}});
    }
}

TEST_CASE("each kind of bad command line is refused in one line", "[program][bad input]") {
    const Workplace work;
    check_refused_commands(work, "",
                           {{"", {"--help"}},
                            {"walk", {"--help", "is not a command; use run, live, view, compare"}},
                            {"run", {"SCENARIO"}},
                            {"run scenario.yaml another.yaml --out out", {"another.yaml"}},
                            {"run missing.yaml --out out", {"missing.yaml", "No such file"}},
                            {"run . --out out", {"directory"}},
                            {"run scenario.yaml --out a.png", {"a.png"}},
                            {"run scenario.yaml --out a.png/below", {"a.png"}}});
    check_refused_commands(
        work, "run scenario.yaml --out out ",
        {{"--colour", {"--colour"}},
         {"--level poetry", {"--level", "rtl"}},
         {"--frames 0", {"--frames"}},
         {"--frames two", {"--frames"}},
         {"--set bus.width_bits", {"--set bus.width_bits", "PATH=VALUE"}},
         {"--set bus.wide_bits=64", {"--set bus.wide_bits=64", "bus.width_bits"}},
         {"--set bus=[1", {"--set", "YAML"}},
         {"--trace t.vcd --level functional", {"--trace t.vcd", "functional", "--level rtl"}},
         {"--trace t.json --level functional", {"--trace t.json", "functional", "--level tlm"}},
         {"--trace t.vcd --level tlm", {"--trace t.vcd", "--level rtl", ".json"}},
         {"--trace t.json --level rtl", {"--trace t.json", "--level tlm", ".vcd"}},
         {"--trace t.txt", {"t.txt", ".vcd", ".json"}},
         {"--trace t.txt --level rtl", {"t.txt", ".vcd", ".json"}},
         {"--trace t.json --trace-before 5", {"--trace-before", "whole run", "--trace-window startframe:0"}},
         {"--trace t.json --trace-after 5", {"--trace-after", "whole run", "--trace-window startframe:0"}},
         {"--trace t.json --trace-window startframe:0 --trace-after -1", {"--trace-after"}},
         {"--trace t.json --trace-modules composer_*", {"--trace-modules", "waveform"}},
         {"--trace-window all", {"--trace-window", "--trace"}},
         {"--trace t.vcd --trace-window frames", {"--trace-window", "first-busready-drop", "cycles:A-B"}},
         {"--trace t.json --trace-window frames", {"--trace-window", "first-busready-drop", "cycles:A-B"}},
         {"--no-images --level functional", {"--no-images", "functional", "tlm"}},
         {"--trace nowhere/t.vcd", {"nowhere/t.vcd"}},
         {"--trace nowhere/t.json", {"nowhere/t.json"}},
         {"--trace t.vcd --trace-before -1", {"--trace-before"}},
         {"--trace t.vcd --trace-modules computer_*", {"--trace-modules", "composer"}}});
}

/// Compared with what the functional level shows of the same frames, in which nothing starves.
TEST_CASE("wrong pixels are those of the pictures that starvation has changed", "[program]") {
    const Workplace work;
    REQUIRE(run_program(work, {"run", "scenario.yaml", "--level", "functional", "--out", "right"}).status ==
            kExitDone);
    const auto picture = [&work](const std::string& folder, int display, int frame) {
        const std::string file =
            "/display_" + std::to_string(display) + ".000" + std::to_string(frame) + ".png";
        return image_codec().load({work / (folder + file), std::nullopt, 0.0}, DepthFormat::kA8Z16,
                                  {0.0, 100.0});
    };
    for (const std::string level : {"tlm", "rtl"}) {
        INFO(level);
        REQUIRE(work.run(kNarrow + std::vector<std::string>{"--level", level}).status == kExitDone);
        const json report = json::parse(text_of(work / "out/report.json"));
        std::int64_t wrong = 0;
        for (int frame = 0; frame < 2; ++frame) {
            for (int display = 1; display <= 2; ++display) {
                const PixelImage shown = picture("out", display, frame);
                const PixelImage right = picture("right", display, frame);
                std::int64_t differing = 0;
                for (std::size_t i = 0; i < shown.values.size(); ++i) {
                    if (!(shown.values[i] == right.values[i])) ++differing;
                }
                CHECK(report["frames"][frame]["wrong_pixels"][display - 1] == differing);
                CHECK(report["frames"][frame]["starved_pixels"][display - 1].get<std::int64_t>() >=
                      differing);
                wrong += differing;
            }
        }
        CHECK(wrong > 0);
        CHECK(report["totals"]["wrong_pixels"] == wrong);
        CHECK(report["totals"]["starved_pixels"].get<std::int64_t>() > wrong);
        const ProgramResult without =
            work.run(kNarrow + std::vector<std::string>{"--level", level, "--no-images"});
        CHECK_THAT(without.out, Contains("shown wrong: not known without pictures"));
        CHECK(json::parse(text_of(work / "out/report.json"))["totals"]["wrong_pixels"].is_null());
    }
}

/// Pixels are read when they are needed, so such an image is found in the middle of a run.
TEST_CASE("an image with broken pixels is refused if a frame shows it, and does not matter otherwise",
          "[program]") {
    const Workplace work;
    work.write("b.ppm", "P6\n40 20\n255\n only so many pixels");
    std::string text = with("{image: b.png, z: 0,\n        viewport: {x: 0,",
                            "{image: a.png, z: 0,\n        viewport: {x: 0,");
    work.write("scenario.yaml", text.replace(text.find("b.png"), 5, "b.ppm"));
    for (const std::string level : {"tlm", "rtl", "functional"}) {
        INFO(level);
        CHECK(run_program(work, {"run", "scenario.yaml", "--level", level, "--frames", "1", "--out", level})
                  .status == kExitDone);
        const ProgramResult refused = work.run({"--level", level, "--frames", "2"});
        check_refused(refused, {"scenario.yaml:10: ", "renderers[0].frames[1].image", "b.ppm"});
        CHECK_FALSE(work.exists("out"));
    }
    CHECK(work.run({"--level", "tlm", "--no-images"}).status == kExitDone);
    const ProgramResult compared = run_program(work, {"compare", "scenario.yaml"});
    CHECK(compared.status == kExitBadInput);
    CHECK(compared.complains_in_one_line());
}

TEST_CASE("a run leaves pictures of every frame and the last one, a collage and a report", "[program]") {
    const Workplace work;
    const ProgramResult result = work.run({"--strict"});
    CHECK(result.status == kExitDone);
    CHECK(result.err.empty());
    for (const char* word : {"frames", "clocks", "frame rate", "latency", "buffer high water", "starved"}) {
        CHECK_THAT(result.out, Contains(word));
    }
    for (const std::string display : {"display_1", "display_2"}) {
        CHECK(work.exists("out/" + display + ".0000.png"));
        CHECK(work.exists("out/" + display + ".0001.png"));
        CHECK_FALSE(work.exists("out/" + display + ".0002.png"));
        CHECK(text_of(work / ("out/" + display + ".png")) ==
              text_of(work / ("out/" + display + ".0001.png")));
        CHECK(text_of(work / ("out/" + display + ".png")) !=
              text_of(work / ("out/" + display + ".0000.png")));
    }
    CHECK(work.exists("out/collage.png"));
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(work / "out")) {
        INFO(entry.path());
        ++files;
    }
    CHECK(work.exists("out/effective_scenario.yaml"));
    CHECK(files == 9);  // no half-written file beside them
}

TEST_CASE("a run in which pixels starve names what keeps them from it, and each change does", "[program]") {
    const Workplace work;
    const std::vector<std::string> narrow{"--set", "bus.width_bits=64",
                                          "--set", "memory.words_per_cycle=1",
                                          "--set", "composer.buffer_pixels=60"};
    const std::string out = work.run(narrow).out;
    const std::string title = "what would do, each by itself, as runs have shown:\n";
    REQUIRE(out.find(title) != std::string::npos);
    std::istringstream lines(out.substr(out.find(title) + title.size()));
    const std::regex setting("([a-z_]+\\.[a-z_]+): ([a-z0-9]+)");
    std::set<std::string> keys;
    for (std::string line; std::getline(lines, line) && line.rfind("  ", 0) == 0;) {
        INFO(line);
        std::vector<std::string> change = narrow;
        for (std::sregex_iterator found(line.begin(), line.end(), setting), end; found != end; ++found) {
            keys.insert((*found)[1]);
            change = change + std::vector<std::string>{"--set", (*found)[1].str() + "=" + (*found)[2].str()};
        }
        CHECK_THAT(work.run(change).out, Contains("no pixel starved"));
        if (line.find("composer.buffer_pixels: ") == std::string::npos) continue;
        const int least = std::stoi(line.substr(line.rfind(' ')));
        CHECK_THAT(work.run(change + std::vector<std::string>{"--set", "composer.buffer_pixels=" +
                                                                           std::to_string(least - 1)})
                       .out,
                   !Contains("no pixel starved"));
    }
    CHECK(keys.count("composer.buffer_pixels") == 1);
    CHECK(keys.count("composer.on_starvation") == 1);
    CHECK((keys.count("bus.width_bits") + keys.count("memory.words_per_cycle") > 0));
}

TEST_CASE("a bus that is wider than its memory fills is named by what runs and what analyzes it",
          "[program]") {
    const Workplace work;
    const std::string line =
        "256 bits wide, of which memory fills 64, 64 x memory.words_per_cycle; a bus of so many";
    const std::vector<std::string> wide{"--set", "memory.words_per_cycle=1"};
    CHECK_THAT(work.run(wide).out, Contains(line));
    CHECK_THAT(run_program(work, std::vector<std::string>{"analyze", "scenario.yaml"} + wide).out,
               Contains(line));
    CHECK_THAT(work.run().out, !Contains("of which memory fills"));
    const ProgramResult size =
        run_program(work, std::vector<std::string>{"size", "scenario.yaml", "--minimize",
                                                   "composer.buffer_pixels=80..200", "--over",
                                                   "bus.width_bits=64,128,256"} +
                              wide);
    CHECK_THAT(size.out, Contains("buses of 2 points are wider than their memory fills"));
}

TEST_CASE("option --quiet prints nothing and results go to out/NAME by default", "[program]") {
    const Workplace work;
    const ProgramResult result = run_program(work, {"run", "scenario.yaml", "--quiet"});
    CHECK(result.status == kExitDone);
    CHECK(result.out.empty());
    CHECK(result.err.empty());
    CHECK(work.exists("out/small/report.json"));
    const ProgramResult traced = run_program(work, {"run", "scenario.yaml", "--quiet", "--trace", "t.vcd"});
    CHECK(traced.status == kExitDone);
    CHECK(traced.out.empty());
    CHECK(traced.err.empty());
    CHECK(work.exists("t.vcd"));
}

TEST_CASE("option --frames shows that many frames", "[program]") {
    const Workplace work;
    CHECK(work.run({"--frames", "1"}).status == kExitDone);
    CHECK(work.report().at("frames").size() == 1);
    CHECK(work.exists("out/display_1.png"));
    CHECK_FALSE(work.exists("out/display_1.0000.png"));  // one frame needs no number
    CHECK(work.run({"--frames", "5"}).status == kExitDone);
    CHECK(work.report().at("frames").size() == 5);
    CHECK(work.exists("out/display_2.0004.png"));
    // The last entry repeats.
    CHECK(text_of(work / "out/display_2.0004.png") == text_of(work / "out/display_2.0001.png"));
}

TEST_CASE("option --set overrides what the file says", "[program]") {
    const Workplace work;
    CHECK(work.run({"--set", "displays.background=[9, 8, 7]", "--set", "renderers.0.frames.1.viewport.x=20",
                    "--set", "name=other"})
              .status == kExitDone);
    CHECK(work.report().at("scenario") == "other");
    work.write("scenario.yaml", with("x: 5", "x: 20"));
    CHECK(
        run_program(work, {"run", "scenario.yaml", "--set", "displays.background=[9, 8, 7]", "--out", "same"})
            .status == kExitDone);
    CHECK(text_of(work / "out/collage.png") == text_of(work / "same/collage.png"));
}

TEST_CASE("displays with corrected colours show them at all levels, and the run says so", "[program]") {
    const Workplace work;
    std::string table;
    for (int v = 0; v < 256; ++v) table += std::to_string(255 - v) + "," + std::to_string(v / 2) + ",9\n";
    work.write("t.csv", table);
    REQUIRE(work.run({"--no-images"}).status == kExitDone);
    CHECK(work.report().at("displays")[0].at("corrected") == false);
    CHECK(work.report().at("cost").at("correction_bits") == 0);
    const auto clocks = work.report().at("core_cycles");
    REQUIRE(run_program(work, {"run", "scenario.yaml", "--out", "plain"}).status == kExitDone);
    const std::string note = "As the displays show it; colours corrected by displays.correction on display 2";
    CHECK_THAT(text_of(work / "plain/collage.png"), !Contains("displays.correction"));
    for (const std::string level : {"functional", "rtl", "tlm"}) {
        INFO(level);
        std::vector<std::string> words{
            "run",     "scenario.yaml", "--out", level,
            "--level", level,           "--set", "displays.correction=[{display: 2, lut: t.csv}]"};
        if (level != "functional") words.emplace_back("--check");
        const ProgramResult result = run_program(work, words);
        INFO(result.err);
        REQUIRE(result.status == kExitDone);
        CHECK_THAT(result.out, Contains("corrected   the colours of display 2, as their pictures show"));
        CHECK_THAT(text_of(work / level / "collage.png"), Contains(note));
        CHECK_THAT(text_of(work / level / "display_2.png"), !Contains("displays.correction"));
        CHECK(text_of(work / level / "display_1.png") == text_of(work / "plain/display_1.png"));
        CHECK(text_of(work / level / "display_2.png") != text_of(work / "plain/display_2.png"));
        CHECK(text_of(work / level / "collage.png") == text_of(work / "functional/collage.png"));
        const json report = work.report(level);
        CHECK(report.at("displays")[0].at("corrected") == false);
        CHECK(report.at("displays")[1].at("corrected") == true);
        if (level == "functional") continue;
        CHECK(report.at("core_cycles") == clocks);
        CHECK(report.at("cost").at("correction_bits") == 3 * 256 * 8);
    }
    // The run's own scenario gives the same again.
    REQUIRE(run_program(work, {"run", "rtl/effective_scenario.yaml", "--out", "again"}).status == kExitDone);
    CHECK(text_of(work / "again/collage.png") == text_of(work / "rtl/collage.png"));
}

TEST_CASE("a colour table is an input, which no result replaces", "[program]") {
    const Workplace work;
    std::string table;
    for (int v = 0; v < 256; ++v) table += "1,2,3\n";
    work.write("t.csv", table);
    const std::vector<std::string> settings{"--set", "displays.correction=[{display: 1, lut: t.csv}]"};
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"run", "scenario.yaml", "--trace", "t.csv"},
          std::vector<std::string>{"view", "scenario.yaml", "-o", "t.csv"}}) {
        INFO(words[0]);
        const ProgramResult result = run_program(work, words + settings);
        CHECK(result.status == kExitBadInput);
        CHECK(result.complains_in_one_line());
        CHECK(text_of(work / "t.csv") == table);
    }
}

TEST_CASE("all levels show the same pictures", "[program]") {
    const Workplace work;
    const std::vector<std::string> settings{"--set", "displays.supersample=2", "--set", "composition=over"};
    for (const std::string level : {"functional", "rtl", "tlm"}) {
        CHECK(run_program(work,
                          std::vector<std::string>{"run", "scenario.yaml", "--out", level, "--level", level} +
                              settings)
                  .status == kExitDone);
        CHECK(work.report(level).at("level") == level);
    }
    std::size_t pictures = 0;
    for (const auto& entry : std::filesystem::directory_iterator(work / "functional")) {
        if (entry.path().extension() != ".png") continue;
        const std::string name = entry.path().filename().string();
        INFO(name);
        for (const std::string level : {"rtl", "tlm"}) {
            CHECK(text_of(entry.path()) == text_of(work / level / name));
        }
        ++pictures;
    }
    CHECK(pictures == 7);
    json rtl = work.report("rtl");
    rtl["level"] = "tlm";
    CHECK(rtl == work.report("tlm"));
}

TEST_CASE("the level is tlm unless another is asked for or the trace needs it", "[program]") {
    const Workplace work;
    const auto level_of = [&work](const std::vector<std::string>& arguments) {
        const ProgramResult result = work.run(arguments);
        INFO(result.err);
        CHECK(result.status == kExitDone);
        CHECK_THAT(result.out, Contains("million composer clocks a second") && Contains("simulated in"));
        return work.report().at("level").get<std::string>();
    };
    CHECK(level_of({}) == "tlm");
    CHECK(level_of({"--level", "tlm"}) == "tlm");
    CHECK(level_of({"--level", "rtl"}) == "rtl");
    CHECK(level_of({"--trace", "t.json"}) == "tlm");
    CHECK(level_of({"--trace", "t.json", "--level", "tlm"}) == "tlm");
    CHECK(level_of({"--trace", "t.vcd"}) == "rtl");
    CHECK(level_of({"--trace", "t.vcd", "--level", "rtl"}) == "rtl");
}

TEST_CASE("option --no-images leaves the counters and no picture", "[program]") {
    const Workplace work;
    for (const std::string level : {"tlm", "rtl"}) {
        INFO(level);
        const std::vector<std::string> at_level{"--level", level};
        CHECK(work.run(at_level).status == kExitDone);
        CHECK(work.exists("out/display_2.0001.png"));
        const std::string report = text_of(work / "out/report.json");
        // Files whose names are not the program's own belong to the user.
        for (const char* name : {"out/display_x.png", "out/my-collage.png", "out/display_1.png.txt"}) {
            work.write(name, "mine");
        }

        const ProgramResult result = work.run(at_level + std::vector<std::string>{"--no-images"});
        CHECK(result.status == kExitDone);
        CHECK_THAT(result.out, Contains("frame rate"));
        CHECK(text_of(work / "out/report.json") == report);
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(work / "out")) {
            names.push_back(entry.path().filename().string());
        }
        std::sort(names.begin(), names.end());
        CHECK(names == std::vector<std::string>{"display_1.png.txt", "display_x.png",
                                                "effective_scenario.yaml", "my-collage.png", "report.json"});
    }
}

TEST_CASE("option --pictures chooses which pictures are written, and they are the same", "[program]") {
    const Workplace work;
    const auto pictures = [&work] {
        std::map<std::string, std::string> files;
        for (const auto& entry : std::filesystem::directory_iterator(work / "out")) {
            const std::string name = entry.path().filename().string();
            if (entry.path().extension() == ".png") files[name] = text_of(entry.path());
        }
        return files;
    };
    const auto names = [](const std::map<std::string, std::string>& files) {
        std::vector<std::string> result;
        for (const auto& [name, bytes] : files) result.push_back(name);
        return result;
    };
    const std::vector<std::string> three_frames{"--frames", "3"};
    REQUIRE(work.run(three_frames).status == kExitDone);
    const auto all = pictures();
    CHECK(names(all) == std::vector<std::string>{"collage.png", "display_1.0000.png", "display_1.0001.png",
                                                 "display_1.0002.png", "display_1.png", "display_2.0000.png",
                                                 "display_2.0001.png", "display_2.0002.png",
                                                 "display_2.png"});
    const std::vector<std::pair<std::string, std::vector<std::string>>> choices{
        {"last", {"collage.png", "display_1.png", "display_2.png"}},
        {"2", {"collage.png", "display_1.0002.png", "display_1.png", "display_2.0002.png", "display_2.png"}},
        {"1-2",
         {"collage.png", "display_1.0001.png", "display_1.0002.png", "display_1.png", "display_2.0001.png",
          "display_2.0002.png", "display_2.png"}},
        {"none", {}}};
    for (const auto& [choice, expected] : choices) {
        for (const std::string level : {"tlm", "rtl"}) {
            INFO(choice << " at level " << level);
            CHECK(work.run(three_frames + std::vector<std::string>{"--level", level, "--pictures", choice})
                      .status == kExitDone);
            const auto written = pictures();
            CHECK(names(written) == expected);
            for (const auto& [name, bytes] : written) CHECK((bytes == all.at(name)));
        }
    }
    // What is not numbered shows the last frame that was chosen.
    CHECK(work.run(three_frames + std::vector<std::string>{"--pictures", "0-1"}).status == kExitDone);
    CHECK((pictures().at("display_1.png") == all.at("display_1.0001.png")));

    const std::string three = "run scenario.yaml --out out --frames 3 --pictures";
    check_refused_commands(work, three,
                           {{"=3", {"--pictures", "frames up to 2"}},
                            {"=2-9", {"--pictures", "frames up to 2"}},
                            {"=2-1", {"--pictures", "such as 2-5"}},
                            {"=-1", {"--pictures", "such as 2-5"}},
                            {"=every", {"--pictures", "all, last, none"}},
                            {"=1-", {"--pictures", "such as 2-5"}},
                            {"=99999999999", {"--pictures", "such as 2-5"}},
                            {" last --no-images", {"--no-images", "--pictures"}}});
    CHECK(work.run({"--no-images", "--pictures", "none"}).status == kExitDone);
    CHECK(work.run({"--level", "functional", "--pictures", "none"}).status == kExitBadInput);
}

/// Its keys are judged without the program (tb/unit/report).
TEST_CASE("report.json is that of the run", "[program]") {
    const Workplace work;
    REQUIRE(work.run(kNarrow).status == kExitDone);
    const json report = work.report();
    CHECK(report.at("scenario") == "small");
    CHECK(report.at("core_cycles").get<std::int64_t>() > 0);
    CHECK(report.at("frames").size() == 2);
    REQUIRE(report.at("renderers").size() == 2);
    CHECK(report.at("renderers")[0].at("name") == "left");
    REQUIRE(report.at("composers").size() == 4);
    std::int64_t starved = 0;
    for (const json& composer : report.at("composers")) {
        starved += composer.at("starved_pixels").get<std::int64_t>();
    }
    REQUIRE(report.at("displays").size() == 2);
    for (const json& display : report.at("displays")) CHECK(display.at("frames_shown") == 2);
    CHECK(starved > 0);
    CHECK(total(report, "starved_pixels") == starved);
}

TEST_CASE("option --strict fails a run in which something starved or was rejected", "[program][repeat]") {
    const Workplace work;
    CHECK(work.run(kNarrow).status == kExitDone);
    const ProgramResult starved = work.run(kNarrow + std::vector<std::string>{"--strict"});
    CHECK(starved.status == kExitStrict);
    CHECK(starved.complains_in_one_line());
    CHECK_THAT(starved.err, Contains("--strict"));
    CHECK_THAT(starved.err, Contains(std::to_string(total(work.report(), "starved_pixels")) + " pixels"));
    CHECK(work.exists("out/display_1.png"));  // what there is to see is written all the same

    work.write("scenario.yaml",
               with("viewport: {x: 3, y: 2, multiple: 1}", "table: [[3, 0, 0, 4, 4, 0, 0, 1]]"));
    CHECK(work.run().status == kExitDone);
    CHECK(work.report().at("totals").at("rejected_rows").at("display") == 1);
    const ProgramResult row = work.run({"--strict"});
    CHECK(row.status == kExitStrict);
    CHECK(row.complains_in_one_line());

    work.write("scenario.yaml",
               std::string(kScenario) + "faults: [{renderer: right, pair: 1, kind: crc, frame: depth}]\n");
    CHECK(work.run().status == kExitDone);
    CHECK(work.report().at("totals").at("rejected_frames").at("crc") == 1);
    CHECK(work.run({"--strict"}).status == kExitStrict);

    work.write("scenario.yaml", kScenario);
    CHECK(work.run({"--strict"}).status == kExitDone);
}

TEST_CASE(
    "the watchdog ends a run in which nothing moves and says who waits for what, and the schedule stays",
    "[program][trace]") {
    const Workplace work;
    work.write("scenario.yaml",
               std::string(kScenario) +
                   "link_timeout_pairs: 1000\n"
                   "watchdog_cycles: 2000\n"
                   "faults: [{renderer: right, pair: 1, kind: delay, frame: colour, delay_pairs: 100}]\n");
    for (const std::string level : {"rtl", "tlm"}) {
        const ProgramResult result = work.run({"--level", level});
        INFO(result.err);
        CHECK(result.status == kExitWatchdog);
        CHECK_THAT(result.err, Contains("scenario.yaml"));
        CHECK_THAT(result.err, Contains("watchdog"));
        CHECK_THAT(result.err, Contains("dvi_source_2 is silent before pair 1"));
        CHECK_THAT(result.err, Contains("input_framebuffer_2 waits for pair 1"));
        CHECK_THAT(result.err, Contains("composer_2_1 waits for the table of frame 1"));
        CHECK_THAT(result.err, !Contains("dvi_source_1"));  // its pairs are all sent
        CHECK(work.exists("out/report.json"));              // so far as the run went
        CHECK(work.report().at("displays")[0].at("frames_shown") == 1);
        CHECK(work.report().at("watchdog").size() + 1 ==
              static_cast<std::size_t>(std::count(result.err.begin(), result.err.end(), '\n')));
    }
    CHECK(work.run({"--trace", "t.json"}).status == kExitWatchdog);
    CHECK(json::parse(text_of(work / "t.json")).at("traceEvents").size() > 10);
}

TEST_CASE("pictures of an earlier run in the folder go when the watchdog ends this one before them",
          "[program]") {
    const Workplace work;
    const std::vector<std::string> stuck{
        "--level",  "rtl",
        "--frames", "3",
        "--set",    "watchdog_cycles=20000",
        "--set",    "faults=[{renderer: left, display: 1, kind: busready_low, from_cycle: 0}]"};
    CHECK(work.run({"--frames", "4"}).status == 0);
    CHECK(work.exists("out/display_2.0003.png"));
    CHECK(work.run(stuck).status == kExitWatchdog);
    CHECK(work.report().at("displays").at(0).at("frames_shown") == 0);
    for (const char* const name :
         {"display_1.png", "display_2.png", "display_1.0000.png", "display_2.0003.png", "collage.png"}) {
        INFO(name);
        CHECK_FALSE(work.exists(std::string("out/") + name));
    }
}

TEST_CASE("a trace shows the paper's signals around STARTFRAME by default", "[program][trace]") {
    const Workplace work;
    const ProgramResult result =
        work.run({"--trace", "t.vcd", "--trace-before", "50", "--trace-after", "100"});
    REQUIRE(result.status == kExitDone);
    const Waveform waveform(work / "t.vcd");
    const ShownCycles cycles = shown_cycles(result);
    check_time_range(waveform, cycles);
    CHECK(cycles.last - cycles.first == 150);
    for (const char* signal : {"BUSREADY", "PIPEREADY", "STARTFRAME", "PIPEMASTER"}) {
        CHECK(waveform.has(std::string("composer_1_1.") + signal));
        CHECK(waveform.has(std::string("composer_2_2.") + signal));
    }
    CHECK(waveform.has("output_framebuffer_2.PIPEREADY"));
    CHECK(waveform.has("core_clk"));
    // The event is where it should be: after as many clocks as were asked for. STARTFRAME of the column that starts
    // first is one clock ahead of the frame's first pixel. It goes down the pipeline by one composer a clock.
    const std::int64_t startframe = (cycles.first + 50) * kPeriodPicoseconds;
    std::int64_t first_rise = std::numeric_limits<std::int64_t>::max();
    for (const std::string column : {"1", "2"}) {
        const std::int64_t rise = waveform.first_rise("composer_1_" + column + ".STARTFRAME");
        CHECK(waveform.first_rise("composer_2_" + column + ".STARTFRAME") == rise + kPeriodPicoseconds);
        first_rise = std::min(first_rise, rise);
    }
    CHECK(first_rise == startframe);
    const std::int64_t first_pixel = work.report().at("frames")[0].at("start_cycle").get<std::int64_t>();
    CHECK(startframe == (first_pixel - 1) * kPeriodPicoseconds);
}

TEST_CASE("a trace window is given by a frame, frames, clocks, or the first event",
          "[program][trace][repeat]") {
    const Workplace work;
    const auto traced = [&work](const std::string& window, const std::vector<std::string>& more = {}) {
        const ProgramResult result =
            work.run(std::vector<std::string>{"--trace", "t.vcd", "--trace-window", window, "--trace-before",
                                              "20", "--trace-after", "30"} +
                     more);
        CHECK(result.status == kExitDone);
        CHECK(result.err.empty());
        return result;
    };
    const auto start_of = [&work](std::size_t frame) {
        return work.report().at("frames").at(frame).at("start_cycle").get<std::int64_t>();
    };
    const auto end_of = [&work](std::size_t frame) {
        return work.report().at("frames").at(frame).at("end_cycle").get<std::int64_t>();
    };

    ShownCycles cycles = shown_cycles(traced("startframe:1"));
    check_time_range(Waveform(work / "t.vcd"), cycles);
    CHECK(cycles.first == start_of(1) - 1 - 20);
    CHECK(cycles.last == start_of(1) - 1 + 30);

    cycles = shown_cycles(traced("frames:0-1"));
    check_time_range(Waveform(work / "t.vcd"), cycles);
    CHECK(cycles.first == start_of(0) - 1 - 20);
    CHECK(cycles.last == end_of(1) + 30);

    cycles = shown_cycles(traced("frames:1"));
    CHECK(cycles.first == start_of(1) - 1 - 20);
    CHECK(cycles.last == end_of(1) + 30);

    cycles = shown_cycles(traced("cycles:1000-1234"));
    check_time_range(Waveform(work / "t.vcd"), cycles);
    CHECK(cycles.first == 1000);
    CHECK(cycles.last == 1234);

    cycles = shown_cycles(traced("all", {"--frames", "1"}));
    CHECK(cycles.first == 0);
    CHECK(cycles.last == work.report().at("core_cycles").get<std::int64_t>() - 1);
    const Waveform whole(work / "t.vcd");
    CHECK(whole.first_time() == 0);
    CHECK(whole.last_time() >= (cycles.last - 1) * kPeriodPicoseconds);  // the run stops in its last clock
    CHECK(whole.last_time() < (cycles.last + 1) * kPeriodPicoseconds);
}

TEST_CASE("a trace window can start at the first starved pixel", "[program][trace]") {
    const Workplace work;
    const ProgramResult result = work.run(
        kNarrow + std::vector<std::string>{"--trace", "t.vcd", "--trace-window", "first-starved-pixel",
                                           "--trace-before", "20", "--trace-after", "30"});
    REQUIRE(result.status == kExitDone);
    const ShownCycles cycles = shown_cycles(result);
    const Waveform waveform(work / "t.vcd");
    check_time_range(waveform, cycles);
    CHECK(cycles.last - cycles.first == 50);
    std::vector<std::int64_t> rises;
    for (const std::string& name : waveform.names()) {
        const bool starved = name.size() > 8 && name.substr(name.size() - 8) == ".starved";
        if (starved && waveform.first_rise(name) >= 0) rises.push_back(waveform.first_rise(name));
    }
    REQUIRE_FALSE(rises.empty());
    CHECK(*std::min_element(rises.begin(), rises.end()) == (cycles.first + 20) * kPeriodPicoseconds);
}

TEST_CASE("a trace window can start at the first BUSREADY drop in a burst", "[program][trace]") {
    const Workplace work;
    const ProgramResult result =
        work.run(kNarrow + std::vector<std::string>{"--set", "bus.width_bits=256", "--trace", "t.vcd",
                                                    "--trace-window", "first-busready-drop", "--trace-before",
                                                    "20", "--trace-after", "30"});
    REQUIRE(result.status == kExitDone);
    CHECK(total(work.report(), "busready_drops") > 0);
    const ShownCycles cycles = shown_cycles(result);
    const Waveform waveform(work / "t.vcd");
    check_time_range(waveform, cycles);
    CHECK(cycles.last - cycles.first == 50);
    const std::int64_t drop = (cycles.first + 20) * kPeriodPicoseconds;
    bool found = false;
    for (const std::string& name : waveform.names()) {
        const bool busready =
            name.rfind("composer_", 0) == 0 && name.size() > 9 && name.substr(name.size() - 9) == ".BUSREADY";
        found = found || (busready && waveform.first_fall(name) == drop);
    }
    CHECK(found);
}

TEST_CASE("a window that shows nothing leaves no waveform or schedule, says so, and is an error",
          "[program][trace]") {
    const Workplace work;
    for (const std::string window : {"cycles:90000000-90000001", "cycles:0-5"}) {
        for (const std::string trace : {"t.vcd", "t.json"}) {
            if (trace == "t.vcd" && window == "cycles:0-5") continue;  // a waveform has these clocks
            INFO(window << ", " << trace);
            const ProgramResult result = work.run({"--trace", trace, "--trace-window", window});
            CHECK(result.status == kExitBadInput);
            CHECK(result.complains_in_one_line());
            CHECK_THAT(result.err, StartsWith(trace == "t.vcd" ? "no waveform: " : "no schedule: "));
            if (window != "cycles:0-5") {
                const auto last = work.report().at("core_cycles").get<std::int64_t>() - 1;
                CHECK_THAT(result.err, Contains("begins at core clock 90000000, and the run ends at " +
                                                std::to_string(last) + "\n"));
            }
            CHECK_FALSE(work.exists(trace));
            CHECK(work.exists("out/report.json"));
        }
    }
}

TEST_CASE("an event that does not happen is refused before the run, with the option that brings it about",
          "[program][trace]") {
    const Workplace work;
    const auto no_slots = kNarrow + std::vector<std::string>{"--set", "bus.arbitration=edf"};
    const auto lost_slots = kNarrow + std::vector<std::string>{"--set", "bus.arbitration=slot-allocation"};
    const struct {
        const char* window;
        std::vector<std::string> settings;
        const char* why;
    } cases[] = {
        {"first-busready-drop", {}, "a composer takes a slot only with room for composer.ready_space_pixels"},
        {"first-starved-pixel", {}, "bus and memory bring each one in time"},
        {"first-starved-pixel",
         {"--set", "composer.on_starvation=stall"},
         "bus and memory bring each one in time"},
        {"first-recovered-slot", no_slots, "bus.arbitration edf has no slots"},
        {"first-recovered-slot", lost_slots,
         "bus.arbitration slot-allocation lets those that are not used pass"},
        {"startframe:7", {}, "the run ends with frame 1"},
        {"frames:1-2", {}, "the run ends with frame 1"},
    };
    for (const auto& [window, settings, why] : cases) {
        for (const std::string trace : {"t.vcd", "t.json"}) {
            INFO(window << ", " << trace);
            const std::vector<std::string> options =
                settings +
                std::vector<std::string>{"--no-images", "--trace", trace, "--trace-window", window};
            const ProgramResult refused = work.run(options);
            CHECK(refused.status == kExitBadInput);
            CHECK(refused.complains_in_one_line());
            CHECK_THAT(refused.err,
                       StartsWith("--trace-window " + std::string(window) + ": ") && Contains(why));
            CHECK_FALSE(work.exists(trace));
            CHECK_FALSE(work.exists("out"));

            const std::string it_does = "; it does with ";
            const std::size_t found = refused.err.find(it_does);
            REQUIRE(found != std::string::npos);
            const ProgramResult shown =
                work.run(options + words_of(refused.err.substr(found + it_does.size())));
            CHECK(shown.status == kExitDone);
            CHECK_THAT(shown.out, Contains(" at core clock ") && Contains(" in composer_"));
            CHECK(work.exists(trace));
            std::filesystem::remove(work / trace);
            std::filesystem::remove_all(work / "out");
        }
    }
    const std::vector<std::string> fault{
        "--set", "faults=[{renderer: left, display: 1, kind: busready_low, from_cycle: 5, cycles: 5}]"};
    const ProgramResult untried =
        work.run(fault + std::vector<std::string>{"--no-images", "--trace", "t.vcd", "--trace-window",
                                                  "first-starved-pixel"});
    CHECK(untried.status == kExitBadInput);
    CHECK_THAT(untried.err, Contains("; it may with --set bus.width_bits=128\n"));
    const ProgramResult never = work.run({"--set", "composer.buffer_pixels=1000000", "--no-images", "--trace",
                                          "t.json", "--trace-window", "first-busready-drop"});
    CHECK(never.status == kExitBadInput);
    CHECK_THAT(never.err, Contains("BUSREADY never drops in a burst"));
}

TEST_CASE("a run that the watchdog ends before a window's event runs, and says both", "[program][trace]") {
    const Workplace work;
    const std::string stuck =
        "faults=[{renderer: left, display: 1, kind: busready_low}, {renderer: left, display: 2, kind: "
        "busready_low}]";
    const ProgramResult result =
        work.run({"--set", "watchdog_cycles=2000", "--set", stuck, "--trace", "t.vcd"});
    CHECK(result.status == kExitWatchdog);
    CHECK_THAT(result.err, StartsWith("no waveform: ") && Contains("watchdog"));
    CHECK_FALSE(work.exists("t.vcd"));
    CHECK(work.exists("out/report.json"));
}

TEST_CASE("the clock of an event is found where a fault of level rtl moves it", "[program][trace]") {
    const Workplace work;
    const auto startframe = [&work](const std::vector<std::string>& more) {
        const ProgramResult result = work.run(
            std::vector<std::string>{"--trace", "t.vcd", "--trace-before", "0", "--trace-after", "0"} + more);
        CHECK(result.status == kExitDone);
        CHECK(result.err.empty());
        const ShownCycles cycles = shown_cycles(result);
        CHECK(cycles.first == cycles.last);
        CHECK(work.report().at("frames")[0].at("start_cycle") == cycles.first + 1);
        return cycles.first;
    };
    const std::int64_t undisturbed = startframe({});
    const std::string until =
        ", kind: pipeready_low, from_cycle: 0, cycles: " + std::to_string(undisturbed + 1000);
    CHECK(startframe({"--set", "faults=[{renderer: left, display: 1" + until +
                                   "}, {renderer: left, display: 2" + until + "}]"}) > undisturbed);
}

TEST_CASE("a waveform that misses its event since the levels differ comes with a line that says so",
          "[program][trace]") {
    const Workplace work;
    const ProgramResult result =
        run_program(METABUFFER_FAULTY_PROGRAM, work,
                    {"run", "scenario.yaml", "--out", "out", "--set", "name=window", "--trace", "t.vcd"});
    CHECK(result.status == kExitDone);
    CHECK(result.complains_in_one_line());
    CHECK_THAT(result.err, StartsWith("waveform: ") && Contains("--trace-window cycles:"));
    CHECK(work.exists("t.vcd"));
}

TEST_CASE("option --trace-modules chooses the blocks that are traced", "[program][trace]") {
    const Workplace work;
    const std::vector<std::string> some{"--trace", "t.vcd", "--trace-modules", "composer_1_*,swap_lock"};
    REQUIRE(work.run(some).status == kExitDone);
    for (const std::string& name : Waveform(work / "t.vcd").names()) {
        INFO(name);
        const bool clock_or_reset = name.find('.') == std::string::npos;
        CHECK((clock_or_reset || name.rfind("composer_1_1.", 0) == 0 || name.rfind("composer_1_2.", 0) == 0 ||
               name.rfind("swap_lock.", 0) == 0));
    }
    CHECK(Waveform(work / "t.vcd").has("composer_1_2.BUSREADY"));
    CHECK_FALSE(Waveform(work / "t.vcd").has("composer_2_1.BUSREADY"));

    // Options may stand before the scenario, too.
    const ProgramResult before = run_program(
        work, std::vector<std::string>{"run"} + some +
                  std::vector<std::string>{"--set", "bus.burst_pixels=16", "--out", "out", "scenario.yaml"});
    INFO(before.err);
    CHECK(before.status == kExitDone);
}

TEST_CASE("a trace changes nothing in the run", "[program][trace]") {
    const Workplace work;
    REQUIRE(work.run(kNarrow + std::vector<std::string>{"--level", "rtl"}).status == kExitDone);
    REQUIRE(run_program(work, std::vector<std::string>{"run", "scenario.yaml", "--out", "traced", "--trace",
                                                       "t.vcd", "--trace-window", "first-starved-pixel"} +
                                  kNarrow)
                .status == kExitDone);
    CHECK(text_of(work / "out/report.json") == text_of(work / "traced/report.json"));
    CHECK(text_of(work / "out/collage.png") == text_of(work / "traced/collage.png"));
}

TEST_CASE("a .json trace is the schedule of the whole run and changes nothing in it", "[program][trace]") {
    const Workplace work;
    REQUIRE(work.run(kNarrow).status == kExitDone);
    const std::string report = text_of(work / "out/report.json");
    const std::string collage = text_of(work / "out/collage.png");
    const ProgramResult result = work.run(kNarrow + std::vector<std::string>{"--trace", "t.json"});
    CHECK(result.status == kExitDone);
    CHECK(result.err.empty());
    CHECK_THAT(result.out, Contains("schedule t.json") && Contains("ui.perfetto.dev"));
    CHECK(text_of(work / "out/report.json") == report);
    CHECK(text_of(work / "out/collage.png") == collage);
    const json schedule = json::parse(text_of(work / "t.json"));
    CHECK(schedule.at("traceEvents").size() > 100);

    // Without pictures it is the same.
    const std::string text = text_of(work / "t.json");
    CHECK(work.run(kNarrow + std::vector<std::string>{"--trace", "t.json", "--no-images"}).status ==
          kExitDone);
    CHECK(text_of(work / "t.json") == text);
    std::size_t traces = 0;
    for (const auto& entry : std::filesystem::directory_iterator(work.path())) {
        traces += entry.path().filename().string().rfind("t.", 0) == 0 ? 1 : 0;
    }
    CHECK(traces == 1);  // no half-written file beside it
}

namespace {

/// A slice of a schedule, or (without an end) a buffer's level.
struct ScheduleEvent {
    std::string track;
    std::string name;
    std::int64_t first = 0;
    std::int64_t last = 0;
    json arguments;

    bool operator==(const ScheduleEvent& other) const {
        return track == other.track && name == other.name && first == other.first && last == other.last &&
               arguments == other.arguments;
    }
};

struct Schedule {
    std::vector<ScheduleEvent> slices;
    std::map<std::string, std::map<std::int64_t, int>> levels;  ///< by buffer and clock
    json facts;
};

Schedule schedule_of(const Workplace& work) {
    const json file = json::parse(text_of(work / "t.json"));
    const auto cycle_of = [](double microseconds) {
        return std::llround(microseconds * 1e6) / kPeriodPicoseconds;
    };
    Schedule schedule;
    schedule.facts = file.at("otherData");
    for (const json& event : file.at("traceEvents")) {
        if (event.at("ph") == "C") {
            schedule.levels[event.at("name")][cycle_of(event.at("ts"))] = event.at("args").at("pixels");
        }
        if (event.at("ph") != "X") continue;
        ScheduleEvent slice{
            event.at("pid").dump() + "/" + event.at("tid").dump(), event.at("name"), cycle_of(event.at("ts")),
            cycle_of(event.at("ts").get<double>() + event.at("dur").get<double>()) - 1, event.at("args")};
        CHECK(slice.arguments.at("first_cycle") == slice.first);
        slice.arguments.erase("first_cycle");
        schedule.slices.push_back(slice);
    }
    return schedule;
}

/// The values of a part's number of that name at the first clock of a waveform, by the block that the part is in.
std::map<std::string, int> initial_values(const std::filesystem::path& waveform, const std::string& part,
                                          const std::string& name) {
    std::map<std::string, std::string> block_of;  // by identifier
    std::map<std::string, int> values;
    std::vector<std::string> scopes;
    std::ifstream file(waveform);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string first, second, width, identifier, signal;
        words >> first >> second;
        if (first == "$scope") {
            words >> second;
            scopes.push_back(second);
        }
        if (first == "$upscope") scopes.pop_back();
        if (first == "$var" && words >> width >> identifier >> signal && signal == name &&
            scopes.back() == part) {
            block_of[identifier] = scopes[scopes.size() - 2];
        }
        const auto block = block_of.find(second);
        if (first[0] == 'b' && block != block_of.end()) {
            values.emplace(block->second, std::stoi(first.substr(1), nullptr, 2));
        }
    }
    return values;
}

/// The part of a whole run's schedule that lies in a window.
std::vector<ScheduleEvent> cut(const std::vector<ScheduleEvent>& slices, std::int64_t first,
                               std::int64_t last) {
    std::vector<ScheduleEvent> cut_slices;
    for (ScheduleEvent slice : slices) {
        if (slice.last < first || slice.first > last) continue;
        if (slice.first < first || slice.last > last) {
            slice.arguments["whole_first_cycle"] = slice.first;
            slice.arguments["whole_last_cycle"] = slice.last;
        }
        slice.first = std::max(slice.first, first);
        slice.last = std::min(slice.last, last);
        cut_slices.push_back(slice);
    }
    return cut_slices;
}

}  // namespace

TEST_CASE("a schedule's window holds what the whole schedule has there", "[program][trace]") {
    const Workplace work;
    const std::vector<std::string> busy =
        kNarrow + std::vector<std::string>{"--frames", "2", "--no-images", "--trace", "t.json"};
    REQUIRE(work.run(busy).status == kExitDone);
    const std::string whole_text = text_of(work / "t.json");
    const Schedule whole = schedule_of(work);
    CHECK_FALSE(whole.facts.contains("window_first_cycle"));
    const auto frame = [report = work.report()](std::size_t index, const char* key) {
        return report.at("frames").at(index).at(key).get<std::int64_t>();
    };
    const std::int64_t end = work.report().at("core_cycles").get<std::int64_t>() - 1;

    CHECK(work.run(busy + std::vector<std::string>{"--trace-window", "all"}).status == kExitDone);
    CHECK((text_of(work / "t.json") == whole_text));

    struct Window {
        std::vector<std::string> options;
        std::int64_t first;
        std::int64_t last;
    };
    const std::int64_t start = frame(0, "start_cycle");
    const Window windows[] = {
        {{"startframe:1"},
         frame(1, "start_cycle") - 1 - 200,
         std::min(end, frame(1, "start_cycle") - 1 + 2000)},
        {{"frames:0", "--trace-before", "0", "--trace-after", "0"}, start - 1, frame(0, "end_cycle")},
        {{"cycles:" + std::to_string(start) + "-" + std::to_string(start)}, start, start},
        {{"cycles:" + std::to_string(start + 33) + "-" + std::to_string(start + 77)}, start + 33, start + 77},
        {{"cycles:" + std::to_string(start) + "-1000000000000000"}, start, end},
    };
    for (const Window& window : windows) {
        INFO(window.options.front());
        const ProgramResult result =
            work.run(busy + std::vector<std::string>{"--trace-window"} + window.options);
        CHECK(result.status == kExitDone);
        CHECK(result.err.empty());
        CHECK_THAT(result.out, Contains("schedule t.json: core clocks " + std::to_string(window.first) +
                                        " to " + std::to_string(window.last) + ", ") &&
                                   Contains(", to be opened at"));
        const Schedule shown = schedule_of(work);
        CHECK(shown.facts.at("window_first_cycle") == window.first);
        CHECK(shown.facts.at("window_last_cycle") == window.last);
        CHECK((shown.slices == cut(whole.slices, window.first, window.last)));
        CHECK_FALSE(shown.slices.empty());
        for (const auto& [buffer, levels] : whole.levels) {
            INFO(buffer);
            std::map<std::int64_t, int> expected(levels.lower_bound(window.first),
                                                 levels.upper_bound(window.last));
            const auto from = shown.levels.find(buffer);
            std::map<std::int64_t, int> found;
            if (from != shown.levels.end()) found = from->second;
            if (levels.begin()->first < window.first) REQUIRE(found.count(window.first) == 1);
            if (found.count(window.first) == 1) expected[window.first] = found[window.first];
            // What the window begins with need not be repeated.
            for (auto level = expected.begin(); level != expected.end();) {
                const bool again = level != expected.begin() && std::prev(level)->second == level->second;
                level = again ? expected.erase(level) : std::next(level);
            }
            CHECK((found == expected));
        }
    }
}

TEST_CASE("a schedule's window is put around the event that a waveform's is put around", "[program][trace]") {
    const Workplace work;
    for (const char* window : {"first-starved-pixel", "first-busready-drop", "first-recovered-slot"}) {
        INFO(window);
        const std::vector<std::string> options =
            kNarrow + std::vector<std::string>{"--set",          "bus.width_bits=256",
                                               "--trace-window", window,
                                               "--trace-before", "20",
                                               "--trace-after",  "30"};
        const ProgramResult waveform = work.run(options + std::vector<std::string>{"--trace", "t.vcd"});
        const ShownCycles cycles = shown_cycles(waveform);
        REQUIRE(cycles.last == cycles.first + 50);
        const ProgramResult schedule_run = work.run(options + std::vector<std::string>{"--trace", "t.json"});
        REQUIRE(schedule_run.status == kExitDone);
        const Schedule schedule = schedule_of(work);
        CHECK(schedule.facts.at("window_first_cycle") == cycles.first);
        CHECK(schedule.facts.at("window_last_cycle") == cycles.last);
        // Both name the same event.
        const std::string event = waveform.out.substr(waveform.out.find(", first "));
        CHECK_THAT(schedule_run.out, Contains(event.substr(0, event.find('\n'))));
    }
}

TEST_CASE("a trace window can start at the first recovered slot", "[program][trace]") {
    const Workplace work;
    const auto arbiter_of = [&work](int clocks_before) {
        const ProgramResult result = work.run(
            kNarrow + std::vector<std::string>{"--trace", "t.vcd", "--trace-window", "first-recovered-slot",
                                               "--trace-before", std::to_string(clocks_before)});
        REQUIRE(result.status == kExitDone);
        const std::regex line(
            "first recovered slot at core clock ([0-9]+) in composer_(.)_(.) \\(renderer (left|right), "
            "column of display (.)\\)");
        std::smatch event;
        REQUIRE(std::regex_search(result.out, event, line));
        CHECK(std::stoll(event[1]) == shown_cycles(result).first + clocks_before);
        CHECK(event[4] == (event[2] == "1" ? "left" : "right"));
        CHECK(event[5] == event[3]);
        return "input_framebuffer_" + event[2].str();
    };
    // The arbiter answers in the clock before the edge that takes the grant, and is not asked a clock earlier: the burst
    // before has not ended.
    const std::string arbiter = arbiter_of(1);
    CHECK(initial_values(work / "t.vcd", "bus_arbiter", "recovered").at(arbiter) > 0);
    CHECK(arbiter_of(2) == arbiter);
    const Waveform waveform(work / "t.vcd");
    CHECK(waveform.first_rise(arbiter + ".bus_arbiter.take") == waveform.first_time() + kPeriodPicoseconds);
}

TEST_CASE("a schedule's window begins with what the buffers hold in a waveform", "[program][trace]") {
    const Workplace work;
    REQUIRE(work.run(kNarrow).status == kExitDone);
    const auto start = work.report().at("frames")[0].at("start_cycle").get<std::int64_t>();
    int held_pixels = 0;
    for (const std::int64_t cycle : {start + 1, start + 100, start + 177}) {
        INFO(cycle);
        const std::vector<std::string> options =
            kNarrow +
            std::vector<std::string>{"--no-images", "--trace-window",
                                     "cycles:" + std::to_string(cycle) + "-" + std::to_string(cycle + 50)};
        REQUIRE(work.run(options + std::vector<std::string>{"--trace", "t.json"}).status == kExitDone);
        REQUIRE(work.run(options + std::vector<std::string>{"--trace", "t.vcd"}).status == kExitDone);
        const Schedule schedule = schedule_of(work);
        const std::map<std::string, int> held =
            initial_values(work / "t.vcd", "beat_receiver", "buffer_held");
        for (const auto& [buffer, composer] :
             std::map<std::string, std::string>{{"renderer left, display 1", "composer_1_1"},
                                                {"renderer left, display 2", "composer_1_2"},
                                                {"renderer right, display 1", "composer_2_1"},
                                                {"renderer right, display 2", "composer_2_2"}}) {
            INFO(buffer);
            CHECK(schedule.levels.at(buffer).at(cycle) == held.at(composer));
            held_pixels += held.at(composer);
        }
    }
    CHECK(held_pixels > 0);
}

}  // namespace metabuffer::test::command_line_test
