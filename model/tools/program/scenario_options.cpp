#include "tools/program/scenario_options.h"

#include <CLI/CLI.hpp>

namespace metabuffer {

ScenarioOptions::ScenarioOptions(CLI::App& command) {
    command.add_option("SCENARIO", file_, "The scenario, a YAML file")->required();
    command.add_option("--set", overrides_, "PATH=VALUE: override a scenario key, e.g. bus.width_bits=128")
        ->take_all()
        ->allow_extra_args(false);
    command.add_option("--frames", frames_, "Composited frames to show, instead of the scenario's number")
        ->check(CLI::Range(1, 1'000'000));
}

std::vector<ScenarioOverride> ScenarioOptions::overrides() const {
    std::vector<ScenarioOverride> overrides;
    overrides.reserve(overrides_.size() + 1);
    for (const std::string& text : overrides_) overrides.push_back(parse_override(text));
    if (frames_) overrides.push_back({"frames", std::to_string(*frames_)});
    return overrides;
}

std::vector<std::string> ScenarioOptions::words() const {
    std::vector<std::string> words{file_};
    for (const std::string& text : overrides_) words.insert(words.end(), {"--set", text});
    if (frames_) words.insert(words.end(), {"--frames", std::to_string(*frames_)});
    return words;
}

Scenario ScenarioOptions::load(LiveRenderers live) const { return load_scenario(file_, overrides(), live); }

}  // namespace metabuffer
