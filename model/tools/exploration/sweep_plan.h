#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/errors.h"
#include "scenario/scenario_loader.h"
#include "scenario/scenario_template.h"
#include "tools/exploration/point_sequence.h"
#include "tools/exploration/value.h"

namespace metabuffer::exploration {

/// The key of an axis whose values are scenario files instead of settings.
constexpr const char* kScenarioAxis = "scenario";

/// Points that a sweep may have, those that its filter does not let through included.
constexpr std::int64_t kMostPoints = 1'000'000;

/// The setting of that key, or null.
const Setting* find_setting(const std::vector<Setting>& settings, const std::string& key);

/// The settings as one text that is the same for the same settings: a JSON object of texts in the order given.
std::string canonical_text(const std::vector<Setting>& settings);

/// Looking for the smallest value of a key at which a goal is met, at each point.
struct SearchDescription {
    std::string key;  ///< "composer.buffer_pixels"
    /// Of a key that takes fractions ("clocks.core_mhz"): candidates, from and to count steps of that size. 0: of one that
    /// takes whole numbers, and they are its values.
    double step = 0.0;
    std::vector<std::int64_t> candidates;  ///< ascending, if the key takes only these; else empty, and
    std::int64_t from = 0;                 ///< the range that is searched, both ends included
    std::int64_t to = 0;
    std::string goal;   ///< an Expression over figures and settings
    int checks = 16;    ///< further values looked at to see whether the goal is monotonic
    std::string where;  ///< begins messages about it; may be empty

    /// A candidate as the key has it.
    double number_of(std::int64_t candidate) const;
    std::string text_of(std::int64_t candidate) const;
};

/// Of keys that take fractions, if a search names none.
constexpr double kUsualStep = 0.1;

/// What a search for that key looks at with the default goal: all that the key takes, or what of it lies in from..to.
/// Of a key that takes fractions it looks at whole multiples of a step. Throws InputError, which begins with `where`:
/// unknown keys, keys that take no numbers, an empty range, a step for whole numbers or none.
SearchDescription describe_search(const std::string& key, std::optional<double> from,
                                  std::optional<double> to, const std::string& where,
                                  std::optional<double> step = std::nullopt);

/// The goal if none is given: nothing starved, stalled or rejected.
std::string default_goal();

/// What a goal may name: the figures, and the settings that a run has.
std::vector<std::string> goal_names(const std::vector<std::string>& axis_keys, const std::string& search_key);

/// What a sweep's cost may name: the same, but itself.
std::vector<std::string> cost_names(const std::vector<std::string>& axis_keys, const std::string& search_key);

/// What to explore: the points, in the order in which they run.
struct SweepPlan {
    std::string name;
    std::filesystem::path scenario;       ///< empty if an axis names the scenarios
    std::filesystem::path base;           ///< what that axis' values are relative to
    std::vector<ScenarioOverride> fixed;  ///< the same for every point
    std::vector<std::string> keys;        ///< of all axes: the settings that points have
    PointSequence points;                 ///< those of the shard that the filter lets through
    Shard shard;                          ///< of the sweep; usually all of it
    /// Stands for the axes' entries and the filter: all shards of a sweep have the same.
    std::string digest;
    bool pictures = false;  ///< keep each display's last picture of every point
    std::string
        cost;  ///< an Expression over figures and settings, for figure `cost`; empty: the usual weights
    std::optional<SearchDescription> search;

    /// The file of the scenario that a point is of.
    std::filesystem::path scenario_file(const std::vector<Setting>& settings) const;
    /// What makes that scenario the point's: the fixed overrides, then the settings.
    std::vector<ScenarioOverride> overrides_of(const std::vector<Setting>& settings) const;
};

/// What a sweep is described by, from a file or a command line; points are not made yet.
struct SweepDescription {
    std::string name;
    std::filesystem::path scenario;  ///< empty if an axis names the scenarios
    std::filesystem::path base;      ///< what that axis' values are relative to
    std::vector<ScenarioOverride> fixed;
    std::vector<Axis> axes;
    std::string axes_where;    ///< begins messages about all of them; may be empty
    std::string filter;        ///< an Expression over scenario keys; empty: every point
    std::string filter_where;  ///< begins the message if it is none
    bool pictures = false;
    std::string cost;
    std::string cost_where;  ///< begins the message if it is none
    std::optional<SearchDescription> search;
};

/// The axes multiplied out (the last axis changes fastest) and filtered. Reads the scenario files, not their images.
/// A filter sees every scenario key that is a single value and stands outside of lists, with the point's settings and
/// defaults in place, and the keys of the axes. Points whose settings the scenario does not take (say, a key out of
/// range) are kept: running them tells why.
/// Throws InputError: unknown keys, a key that two axes set, entries that are there twice, no points at all or too many
/// of them, scenario files that cannot be read, a bad filter or goal.
/// A shard may be without points. The filter is applied to its own combinations only.
SweepPlan make_plan(const SweepDescription& description, Shard shard = {});

/// Reads a sweep file; paths in it are relative to it. Throws InputError: file, line, what is wrong, what would be
/// right.
SweepDescription load_sweep(const std::filesystem::path& file);

/// The same from text; `origin` names it in messages and `base` is what scenarios' paths are relative to.
SweepDescription parse_sweep(const std::string& text, const std::string& origin,
                             const std::filesystem::path& base);

/// Every key that a sweep file may have, as scenario_key_paths() has those of scenarios.
std::vector<std::string> sweep_key_paths();

/// The values of a range or list as a command line gives them: "32,64,128", "64..4096*2", "16..128+16" and any mix
/// with commas; of "1..5" all whole numbers. Values are YAML in flow style. Throws InputError, which begins with
/// `where`.
std::vector<std::string> parse_values(const std::string& text, const std::string& where);

}  // namespace metabuffer::exploration
