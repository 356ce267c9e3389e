#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenario/scenario_template.h"
#include "tools/exploration/outcomes.h"
#include "tools/exploration/results_database.h"
#include "tools/exploration/run_process.h"
#include "tools/exploration/smallest_value_search.h"
#include "tools/exploration/sweep_plan.h"

namespace metabuffer::exploration {

/// How far an exploration is.
struct Progress {
    std::size_t points = 0;         ///< of the plan
    std::size_t points_ended = 0;   ///< including those that the results held already
    std::size_t points_reused = 0;  ///< those that the results held already
    std::size_t runs = 0;           ///< simulations that ended now
    double seconds = 0.0;           ///< since it began

    /// Points a second, without those that the results held already.
    double rate() const;
    /// Empty before the first new point has ended.
    std::optional<double> seconds_to_go() const;
};

/// Simulations at once, if nothing else is asked for: one for each processor and one more, so that no processor waits
/// while the results of short ones are stored.
int usual_process_count();

struct ExploreOptions {
    int processes = 1;                ///< simulations at once, >= 1
    double time_limit_seconds = 0.0;  ///< for one simulation, in real time; 0: none
    /// Called whenever something has ended. May be empty.
    std::function<void(const Progress&)> on_progress;
    /// A descriptor that becomes readable when the exploration is to stop, with runs under way unfinished; -1: none.
    int stop_descriptor = -1;
    /// Gives what is known of a search's point, from its scenario. The scenario's own value of the key does not matter.
    /// May be empty.
    std::function<KnownAnswer(const Scenario&)> known;
    /// Whether Exploration has every point's record. Without them memory does not grow with the plan.
    bool keeps_points = true;
    /// Called about once a second or more often. May be empty.
    std::function<void()> on_tick;
};

/// The outcome of an exploration.
struct Exploration {
    std::vector<PointRecord> points;  ///< in the order of the plan, without those that were not reached
    Outcomes outcomes;                ///< of the same points, kept or not
    Progress progress;
    bool stopped = false;
};

/// Runs the points of a plan and keeps the results. Each simulation has a process of its own, and several run at once.
class Explorer {
  public:
    /// Reads the plan's scenario files and, as far as they are valid, the images of its points. The plan must outlive
    /// it. Throws InputError.
    /// needs_pixels: whether a run without pictures needs them, too. Of other runs' images the headers are read.
    Explorer(const SweepPlan& plan, Simulate simulate, bool needs_pixels = false);

    /// What the results are made from, including the program's version and the level that simulates.
    ResultsIdentity identity(const std::string& program_version,
                             const std::string& level = kUsualLevel) const;

    /// Runs what `results` (null: keep nothing) does not hold yet, and adds each simulation as it ends. Throws
    /// InputError if no process can be started for a run, OutputError if the results cannot be written.
    Exploration run(ResultsDatabase* results, const ExploreOptions& options) const;

  private:
    class Session;

    void read_images_of(const Point& point, const ScenarioTemplate& scenario);
    std::string name_of_input(const std::filesystem::path& file) const;
    void add_input(const std::string& name, const std::filesystem::path& file);
    const std::shared_ptr<const ScenarioTemplate>& template_of(const std::vector<Setting>& settings) const;

    const SweepPlan* plan_;
    Simulate simulate_;
    bool needs_pixels_;
    std::map<std::filesystem::path, std::shared_ptr<const ScenarioTemplate>> templates_;
    std::map<std::string, std::string>
        inputs_;  ///< files of scenarios, images and colour tables: size and checksum of each
};

}  // namespace metabuffer::exploration
