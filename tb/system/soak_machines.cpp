#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <systemc>
#include <vector>

#include "host/errors.h"
#include "random_scenario.h"
#include "scenario/scenario_loader.h"
#include "scenario/scenario_writer.h"
#include "shrink.h"
#include "soak_judge.h"

// Random machines under every check and at both levels, for scripts/soak: one process runs one batch in one
// elaboration. A machine that fails is shrunk by trying smaller ones, each in a process of its own.

using namespace metabuffer;
using namespace metabuffer::test;

namespace {

constexpr int kUsage = 2;
constexpr int kFailed = 5;
constexpr int kMostRuns = 600;    // of smaller machines
constexpr int kMostSeconds = 30;  // for each of them

constexpr const char* kHelp =
    "usage: soak_machines [--plain|--stalled] FIRST_SEED COUNT\n"
    "           runs the machines of the seeds; prints 'seed S KIND' for each and, indented, what is wrong\n"
    "       soak_machines [--plain|--stalled] --write SEED DIR\n"
    "           writes a seed's scenario to files\n"
    "       soak_machines [--plain|--stalled] --shrink SEED DIR [RUNS [SECONDS]]\n"
    "           makes a machine that fails as small as it can be while failing, with RUNS tries of SECONDS "
    "each,\n"
    "           and writes it to files, with DIR/failure.txt\n"
    "       soak_machines --judge FILE\n"
    "           runs the machine of a scenario file\n"
    "KIND: identical (all is well), different (levels rtl and tlm), check, violation RULE, error, crash, "
    "hang.\n"
    "--plain: machines of few frames, as `random systems` has them. --stalled: such machines with every "
    "handshake\n"
    "of some rows held back at random, at level rtl.\n"
    "Exit status: 0 all is well; 5 some machine fails; 1 a model failed; 2 bad arguments.\n";

using Words = std::vector<std::string_view>;

std::optional<std::uint64_t> whole_number(std::string_view text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

using RandomMachine = Scenario (*)(std::uint64_t seed);

SoakMachine machine_of(std::uint64_t seed, RandomMachine random_machine) {
    return {seed, random_machine(seed)};
}

std::string indented(const std::string& text) {
    std::string result;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) result += "  " + line + '\n';
    return result;
}

int print_verdict(std::uint64_t seed, const SoakVerdict& verdict) {
    std::cout << "seed " << seed << ' ' << verdict.kind << '\n' << indented(verdict.text);
    return verdict.good() ? EXIT_SUCCESS : kFailed;
}

int run_batch(std::uint64_t first, std::uint64_t count, RandomMachine random_machine) {
    if (count == 1) return print_verdict(first, judge_machine(machine_of(first, random_machine)));
    std::vector<SoakMachine> machines;
    for (std::uint64_t seed = first; seed < first + count; ++seed)
        machines.push_back(machine_of(seed, random_machine));
    const std::vector<SoakVerdict> verdicts = judge_machines(machines);
    int status = EXIT_SUCCESS;
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
        status = std::max(status, print_verdict(machines[i].seed, verdicts[i]));
    }
    return status;
}

/// How large a scenario is, in words.
std::string size_of(const Scenario& scenario) {
    std::size_t rows = 0;
    std::int64_t pixels = 0;
    for (const Renderer& renderer : scenario.renderers) {
        for (const RendererFrame& frame : renderer.frames) rows += frame.table.size();
        pixels += std::int64_t{renderer.image_width_pixels} * renderer.image_height_pixels;
    }
    std::ostringstream text;
    text << scenario.renderers.size() << " renderers, " << scenario.displays.count() << " displays of "
         << scenario.displays.raster_width_pixels() << "x" << scenario.displays.raster_height_pixels() << ", "
         << scenario.frames << " frames, " << rows << " table rows, " << scenario.faults.size() << " faults, "
         << pixels << " image pixels";
    return text.str();
}

int shrink_machine(const SoakMachine& machine, const std::filesystem::path& directory, int most_runs,
                   int most_seconds) {
    const SoakVerdict verdict = judge_in_child(machine, most_seconds);
    if (verdict.good()) {
        std::cout << "seed " << machine.seed << " does not fail\n";
        return EXIT_SUCCESS;
    }
    const Shrunk shrunk = shrink(
        machine.scenario,
        [&](const Scenario& scenario) {
            return judge_in_child({machine.seed, scenario}, most_seconds).kind == verdict.kind;
        },
        most_runs);
    write_scenario(shrunk.scenario, directory);
    const std::filesystem::path file = directory / "scenario.yaml";
    const SoakVerdict replayed = judge_in_child({machine.seed, load_scenario(file)}, most_seconds);

    std::ostringstream text;
    text << "seed " << machine.seed << ' ' << verdict.kind << ", shrunk\n"
         << replayed.text << "\nbefore: " << size_of(machine.scenario)
         << "\nafter:  " << size_of(shrunk.scenario) << "\n\n"
         << describe(shrunk.scenario) << "\n\n"
         << shrunk.steps.size() << " steps, " << shrunk.runs << " machines tried, "
         << (shrunk.at_its_smallest ? "no smaller one fails" : "smaller ones have not all been tried")
         << '\n';
    for (const std::string& step : shrunk.steps) text << "  " << step << '\n';
    const bool replays = replayed.kind == verdict.kind;
    text << "\nThe files "
         << (replays ? "fail in the same way" : "do not fail in the same way: " + replayed.kind)
         << ". To see it again:\n  soak_machines --judge " << file.string() << "\n  metabuffer compare "
         << file.string() << '\n';
    std::cout << text.str();
    std::ofstream out(directory / "failure.txt");
    out << text.str() << std::flush;
    if (!out) throw OutputError((directory / "failure.txt").string() + ": cannot be written");
    return kFailed;
}

/// Nothing if the words are not a command.
std::optional<int> run_command(const Words& words, RandomMachine random_machine) {
    if (words.size() == 2 && words[0] == "--judge") {
        return print_verdict(0, judge_machine({0, load_scenario(std::filesystem::path(words[1]))}));
    }
    if (words.size() == 3 && words[0] == "--write") {
        const auto seed = whole_number(words[1]);
        if (!seed) return std::nullopt;
        write_scenario(machine_of(*seed, random_machine).scenario, words[2]);
        return EXIT_SUCCESS;
    }
    if (words.size() >= 3 && words.size() <= 5 && words[0] == "--shrink") {
        const auto seed = whole_number(words[1]);
        const auto runs = words.size() > 3 ? whole_number(words[3]) : kMostRuns;
        const auto seconds = words.size() > 4 ? whole_number(words[4]) : kMostSeconds;
        constexpr std::uint64_t kMost = 1'000'000;
        if (!seed || !runs || !seconds || *runs > kMost || *seconds < 1 || *seconds > kMost)
            return std::nullopt;
        return shrink_machine(machine_of(*seed, random_machine), words[2], static_cast<int>(*runs),
                              static_cast<int>(*seconds));
    }
    if (words.size() == 2) {
        const auto first = whole_number(words[0]);
        const auto count = whole_number(words[1]);
        if (first && count && *count <= std::numeric_limits<std::uint64_t>::max() - *first) {
            return run_batch(*first, *count, random_machine);
        }
    }
    return std::nullopt;
}

int run(Words words) {
    RandomMachine random_machine = random_level_scenario;
    if (!words.empty() && (words.front() == "--plain" || words.front() == "--stalled")) {
        random_machine = words.front() == "--plain" ? random_scenario : random_stalled_scenario;
        words.erase(words.begin());
    }
    if (const std::optional<int> status = run_command(words, random_machine)) return *status;
    std::cerr << kHelp;
    return kUsage;
}

}  // namespace

int sc_main(int argc, char** argv) {
    // A warning of the model fails the machine as its errors do.
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_THROW);
    sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_THROW);
    try {
        return run({argv + 1, argv + argc});
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}

int main(int argc, char** argv) {
    // The kernel's banner would appear among the results.
    setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);
    return sc_core::sc_elab_and_sim(argc, argv);
}
