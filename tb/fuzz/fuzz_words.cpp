#include <cstdlib>
#include <iostream>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/scenario_keys.h"
#include "scenario/scenario_loader.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/sweep_plan.h"

// Prints the words of the tables of keys and figures as a dictionary for libFuzzer:
//   fuzz_words scenario|sweep

using namespace metabuffer;

namespace {

using Words = std::set<std::string>;

/// The keys of a path, each on its own.
void add_keys(Words& words, std::string_view path) {
    for (std::size_t at = 0; at < path.size();) {
        const std::size_t end = std::min(path.find('.', at), path.size());
        words.emplace(path.substr(at, std::min(path.find('[', at), end) - at));
        at = end + 1;
    }
}

void add_scenario_words(Words& words) {
    for (const SchemaKey& key : scenario_schema().keys()) {
        add_keys(words, key.pattern);
        words.insert(key.rule.choices.begin(), key.rule.choices.end());
    }
}

void add_sweep_words(Words& words) {
    for (const std::string& path : exploration::sweep_key_paths()) add_keys(words, path);
    for (const exploration::FigureKind& figure : exploration::figure_kinds()) words.insert(figure.name);
    // Axes and expressions name a scenario's keys by their paths.
    for (const std::string& path : scenario_key_paths()) words.insert(path);
}

}  // namespace

int main(int argc, char** argv) {
    const std::string_view kind = argc == 2 ? argv[1] : "";
    Words words;
    if (kind == "scenario") {
        add_scenario_words(words);
    } else if (kind == "sweep") {
        add_sweep_words(words);
    } else {
        std::cerr << "usage: fuzz_words scenario|sweep\n";
        return EXIT_FAILURE;
    }
    words.erase("");
    for (const std::string& word : words) std::cout << '"' << word << "\"\n";
    return EXIT_SUCCESS;
}
