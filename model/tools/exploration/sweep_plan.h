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

/// The key of an axis with scenario files as values instead of settings.
constexpr const char* kScenarioAxis = "scenario";

/// The most points that a sweep may have, including those that its filter leaves out.
constexpr std::int64_t kMostPoints = 1'000'000;

/// The setting of that key, or null.
const Setting* find_setting(const std::vector<Setting>& settings, const std::string& key);

/// The settings as one text that is the same for the same settings: a JSON object of texts in the order given.
std::string canonical_text(const std::vector<Setting>& settings);

/// The search, at each point, for the smallest value of a key at which a goal is met.
struct SearchDescription {
    std::string key;  ///< "composer.buffer_pixels"
    /// For a key that takes fractions ("clocks.core_mhz"): candidates, from and to count steps of this size. 0 for a
    /// key that takes whole numbers: they are its values.
    double step = 0.0;
    std::vector<std::int64_t> candidates;  ///< ascending, if the key takes only these; else empty
    std::int64_t from = 0;                 ///< without candidates: the range, both ends included
    std::int64_t to = 0;
    std::string goal;   ///< an Expression over figures and settings
    int checks = 16;    ///< further values tried to check whether the goal is monotonic
    std::string where;  ///< begins messages about it; may be empty

    /// The key's value for a candidate, as a number or as a text.
    double number_of(std::int64_t candidate) const;
    std::string text_of(std::int64_t candidate) const;
    std::int64_t candidate_of(double number) const;
    /// "composer.buffer_pixels=64".
    std::string setting_text(std::int64_t candidate) const { return key + "=" + text_of(candidate); }
};

/// The step for keys that take fractions, if a search names none.
constexpr double kUsualStep = 0.1;

/// A search over that key with the default goal. It covers all values that the key takes, or those in from..to. For a
/// key that takes fractions these are whole multiples of the step. Throws InputError, with a message that begins with
/// `where`, for an unknown key, a key that takes no numbers, an empty range, a step for whole numbers, or a step that
/// is not above 0.
SearchDescription describe_search(const std::string& key, std::optional<double> from,
                                  std::optional<double> to, const std::string& where,
                                  std::optional<double> step = std::nullopt);

/// The goal if none is given: the pictures are whole, and no column stalls.
std::string default_goal();

/// What a goal may name: the figures, and the settings that a run has.
std::vector<std::string> goal_names(const std::vector<std::string>& axis_keys, const std::string& search_key);

/// What a sweep's cost may name: the same, except the cost itself.
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
    /// A checksum of the axes' entries and the filter: all shards of a sweep have the same.
    std::string digest;
    bool pictures = false;  ///< keep each display's last picture of every point
    /// An Expression over figures and settings for figure `cost`; empty: the usual weights.
    std::string cost;
    std::optional<SearchDescription> search;

    /// The scenario file of a point with these settings.
    std::filesystem::path scenario_file(const std::vector<Setting>& settings) const;
    /// The overrides that make that scenario the point's: the fixed ones, then the settings.
    std::vector<ScenarioOverride> overrides_of(const std::vector<Setting>& settings) const;
};

/// A sweep as a file or a command line describes it; the points are not made yet.
struct SweepDescription {
    std::string name;
    std::filesystem::path scenario;  ///< empty if an axis names the scenarios
    std::filesystem::path base;      ///< what that axis' values are relative to
    std::vector<ScenarioOverride> fixed;
    std::vector<Axis> axes;
    std::string axes_where;    ///< begins messages about all of them; may be empty
    std::string filter;        ///< an Expression over scenario keys; empty: every point
    std::string filter_where;  ///< begins the message if the filter is not an expression
    bool pictures = false;
    std::string cost;
    std::string cost_where;  ///< begins the message if the cost is not an expression
    std::optional<SearchDescription> search;
};

/// Makes all combinations of the axes' entries (the last axis changes fastest) and filters them. Reads the scenario
/// files, not their images. A filter sees the keys of the axes, and every scenario key that is a single value outside
/// of lists, with the point's settings and the defaults applied. Points with settings that the scenario does not take
/// (say, a key out of range) are kept: their runs report why.
///
/// Throws InputError for unknown keys, a key that two axes set, repeated entries of an axis, no points at all or too
/// many of them, scenario files that cannot be read, and a bad filter, cost or goal.
///
/// A shard may be without points. The filter is applied to its own combinations only.
SweepPlan make_plan(const SweepDescription& description, Shard shard = {});

/// Reads a sweep file; paths in it are relative to it. Throws InputError with the file, the line, what is wrong and
/// what would be right.
SweepDescription load_sweep(const std::filesystem::path& file);

/// The same from text; `origin` names it in messages and `base` is what scenarios' paths are relative to.
SweepDescription parse_sweep(const std::string& text, const std::string& origin,
                             const std::filesystem::path& base);

/// Every key that a sweep file may have, in the form of scenario_key_paths().
std::vector<std::string> sweep_key_paths();

/// The values of a range or list as a command line gives them: "32,64,128", "64..4096*2", "16..128+16" and any mix
/// with commas; "1..5" means all whole numbers in it. Values are YAML in flow style. Throws InputError, which begins
/// with `where`.
std::vector<std::string> parse_values(const std::string& text, const std::string& where);

}  // namespace metabuffer::exploration
