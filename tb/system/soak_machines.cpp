#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <systemc>
#include <vector>

#include "random_scenario.h"
#include "scenario/scenario_writer.h"
#include "tlm_run.h"

// Random machines at both levels, for scripts/soak: one process runs one batch in one elaboration.

using namespace metabuffer;
using namespace metabuffer::test;

namespace {

constexpr int kUsage = 2;
constexpr int kDifferent = 5;

constexpr const char* kHelp =
    "usage: soak_machines FIRST_SEED COUNT    runs the machines of the seeds at levels rtl and tlm; prints "
    "for\n"
    "                                         each 'seed S identical' or 'seed S different' and, indented, "
    "how\n"
    "       soak_machines --write SEED DIR    writes a seed's scenario to files\n"
    "Exit status: 0 all identical; 5 some differ; 1 a model failed; 2 bad arguments.\n";

std::optional<std::uint64_t> whole_number(std::string_view text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

int compare_levels(std::uint64_t first, std::uint64_t count) {
    std::vector<LevelRuns> runs;
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        runs.emplace_back("machine_" + std::to_string(seed), random_level_scenario(seed));
    }
    simulate_until([&runs] {
        return std::all_of(runs.begin(), runs.end(), [](const LevelRuns& run) { return run.finished(); });
    });
    bool all_identical = true;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::vector<std::string> differences = level_differences(runs[i]);
        all_identical = all_identical && differences.empty();
        std::cout << "seed " << first + i << (differences.empty() ? " identical\n" : " different\n");
        for (const std::string& line : differences) std::cout << "  " << line << '\n';
    }
    return all_identical ? EXIT_SUCCESS : kDifferent;
}

int run(const std::vector<std::string_view>& words) {
    if (words.size() == 3 && words[0] == "--write") {
        if (const auto seed = whole_number(words[1])) {
            write_scenario(random_level_scenario(*seed), words[2]);
            return EXIT_SUCCESS;
        }
    }
    if (words.size() == 2) {
        const auto first = whole_number(words[0]);
        const auto count = whole_number(words[1]);
        if (first && count && *count <= std::numeric_limits<std::uint64_t>::max() - *first) {
            return compare_levels(*first, *count);
        }
    }
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
    // The kernel's banner would stand among the results.
    setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);
    return sc_core::sc_elab_and_sim(argc, argv);
}
