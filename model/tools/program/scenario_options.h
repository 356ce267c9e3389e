#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/errors.h"
#include "scenario/scenario_loader.h"

namespace CLI {
class App;
}

namespace metabuffer {

/// The arguments that name a scenario and change it, the same for every command: SCENARIO, --set, --frames.
class ScenarioOptions {
  public:
    /// Adds the options to a command, which keeps references to this object.
    explicit ScenarioOptions(CLI::App& command);
    ScenarioOptions(const ScenarioOptions&) = delete;
    ScenarioOptions& operator=(const ScenarioOptions&) = delete;

    const std::string& file() const { return file_; }
    /// For an argument that names a scenario in another way than by its file.
    void set_file(std::string file) { file_ = std::move(file); }
    /// The words that name the scenario and its changes on another command line.
    std::vector<std::string> words() const;
    /// The changes that --set and --frames request. Throws InputError.
    std::vector<ScenarioOverride> overrides() const;
    /// Throws InputError.
    Scenario load(LiveRenderers live = LiveRenderers::kRefused) const;
    bool names_frames() const { return frames_.has_value(); }

  private:
    std::string file_;
    std::vector<std::string> overrides_;
    std::optional<int> frames_;
};

}  // namespace metabuffer
