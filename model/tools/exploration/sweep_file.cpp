#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "host/text.h"
#include "host/text_file.h"
#include "scenario/entry.h"
#include "scenario/limits.h"
#include "scenario/scenario_keys.h"
#include "scenario/schema.h"
#include "tools/exploration/axis_values.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/sweep_plan.h"

namespace metabuffer::exploration {
namespace {

using input::Entry;

constexpr IntegerRange kCounts{1, kMostPoints};
constexpr IntegerRange kSeeds{0, std::numeric_limits<std::int64_t>::max()};
constexpr IntegerRange kChecks{0, 10'000};
constexpr NumberRange kNumbers{-1e15, 1e15};
/// The most values of all axes together: a few lines may ask for more values than fit into memory, though they make no
/// more points than allowed.
constexpr std::size_t kMostValues = 4 * static_cast<std::size_t>(kMostPoints);

constexpr const char* kValuesMeaning = "a list of values";
constexpr const char* kRangeMeaning = "a map";
constexpr const char* kZipMeaning = "a list of keys that go together, each with values";

/// Every key of a sweep file.
const Schema& sweep_schema() {
    constexpr KeyShape kScalar = KeyShape::kScalar;
    constexpr KeyShape kMap = KeyShape::kMap;
    constexpr KeyShape kList = KeyShape::kList;
    constexpr KeyShape kFreeMap = KeyShape::kFreeMap;
    constexpr KeyShape kAny = KeyShape::kAny;
    static const Schema schema{
        "the sweep is empty; use at least the keys scenario and axes",
        {
            {"", kMap, "a map"},
            {"name", kScalar, "the sweep's name"},
            {"scenario", kScalar, "a scenario file"},
            {"set", kFreeMap, "a map from scenario keys to values"},
            {"set[]", kAny, "a value"},
            {"pictures", kScalar, "true or false"},
            {"cost", kScalar, "an expression over figures"},
            {"weights", kFreeMap, "a map from figures to what one of each costs"},
            {"weights[]", kScalar, "a number"},
            {"axes", kList, "a list of axes"},
            {"axes[]", kMap, "a map"},
            {"axes[].key", kScalar, "a scenario key"},
            {"axes[].values", kList, kValuesMeaning},
            {"axes[].values[]", kAny, "a value"},
            {"axes[].range", kMap, kRangeMeaning},
            {"axes[].range.from", kScalar, "a number"},
            {"axes[].range.to", kScalar, "a number"},
            {"axes[].range.step", kScalar, "what is added each time"},
            {"axes[].range.factor", kScalar, "what is multiplied by each time"},
            {"axes[].random", kMap, kRangeMeaning},
            {"axes[].random.from", kScalar, "a number"},
            {"axes[].random.to", kScalar, "a number"},
            {"axes[].random.count", kScalar, "how many numbers"},
            {"axes[].random.seed", kScalar, "a whole number"},
            {"axes[].zip", kList, kZipMeaning},
            {"axes[].zip[]", kMap, "a map"},
            {"axes[].zip[].key", kScalar, "a scenario key"},
            {"axes[].zip[].values", kList, kValuesMeaning},
            {"axes[].zip[].values[]", kAny, "a value"},
            {"axes[].zip[].range", kMap, kRangeMeaning},
            {"axes[].zip[].range.from", kScalar, "a number"},
            {"axes[].zip[].range.to", kScalar, "a number"},
            {"axes[].zip[].range.step", kScalar, "what is added each time"},
            {"axes[].zip[].range.factor", kScalar, "what is multiplied by each time"},
            {"axes[].zip[].random", kMap, kRangeMeaning},
            {"axes[].zip[].random.from", kScalar, "a number"},
            {"axes[].zip[].random.to", kScalar, "a number"},
            {"axes[].zip[].random.count", kScalar, "how many numbers"},
            {"axes[].zip[].random.seed", kScalar, "a whole number"},
            {"filter", kScalar, "an expression over scenario keys"},
            {"minimize", kMap, "a map"},
            {"minimize.key", kScalar, "a scenario key that holds a number"},
            {"minimize.from", kScalar, "the smallest value to try"},
            {"minimize.to", kScalar, "the largest value to try"},
            {"minimize.step", kScalar, "of a key that takes fractions: what the values are multiples of"},
            {"minimize.goal", kScalar, "an expression over figures"},
            {"minimize.checks", kScalar, "how many further values to try"},
        }};
    return schema;
}

AxisNumber read_number(const Entry& entry) {
    entry.number(kNumbers);
    const std::optional<AxisNumber> number = axis_number(entry.flow());
    if (!number) entry.fail("'" + entry.flow() + "' is not a number; use decimal digits");
    return *number;
}

std::optional<AxisNumber> read_optional_number(const Entry& entry) {
    if (!entry.present()) return std::nullopt;
    return read_number(entry);
}

std::vector<std::string> read_range(const Entry& entry) {
    const AxisRange range{read_number(entry.child("from")), read_number(entry.child("to")),
                          read_optional_number(entry.child("step")),
                          read_optional_number(entry.child("factor"))};
    if (const auto problem = problem_of(range)) entry.fail(*problem);
    return values_of(range);
}

std::vector<std::string> read_random(const Entry& entry, bool distinct) {
    RandomAxis random;
    random.from = read_number(entry.child("from"));
    random.to = read_number(entry.child("to"));
    random.count = entry.child("count").integer(kCounts);
    random.seed = static_cast<std::uint64_t>(entry.child("seed").integer(kSeeds));
    random.distinct = distinct;
    if (const auto problem = problem_of(random)) entry.fail(*problem);
    return values_of(random);
}

std::vector<std::string> read_list(const Entry& entry, bool names_files) {
    std::vector<std::string> values;
    for (const Entry& item : entry.items()) values.push_back(names_files ? item.name() : item.flow());
    if (values.empty()) entry.fail("has no entries; use at least one value");
    return values;
}

/// The three ways to give a key's values, one of which is present.
struct ValueKeys {
    Entry values;
    Entry range;
    Entry random;
};

ValueKeys read_value_keys(const Entry& entry, bool names_files) {
    ValueKeys keys{entry.child("values"), entry.child("range"), entry.child("random")};
    const int given = int{keys.values.present()} + int{keys.range.present()} + int{keys.random.present()};
    if (given != 1) {
        entry.fail((given == 0 ? "has none of " : "has more than one of ") +
                   std::string("values, range and random; use one of them"));
    }
    if (names_files && !keys.values.present()) {
        entry.fail("scenarios are neither numbers nor drawn; use values, a list of files");
    }
    return keys;
}

class AxesReader {
  public:
    Axis read(const Entry& entry) {
        Axis axis;
        const Entry zip = entry.child("zip");
        if (!zip.present()) {
            if (!entry.child("key").present()) entry.fail("has neither a key nor a zip; use one of the two");
            read_key(entry, false, axis);
            return axis;
        }
        for (const char* key : {"key", "values", "range", "random"}) {
            if (entry.child(key).present())
                entry.child(key).fail("is given together with a zip; put it into the zip");
        }
        for (const Entry& item : zip.items()) read_key(item, true, axis);
        if (axis.keys.empty()) zip.fail("has no entries; use at least one key with values");
        return axis;
    }

  private:
    /// Reads a key and its values. Values that change together with those of other keys may repeat.
    void read_key(const Entry& entry, bool goes_together, Axis& axis) {
        const Entry key = entry.child("key");
        const std::string path = key.name();
        const bool names_files = path == kScenarioAxis;
        if (!names_files) input::find_key_path(scenario_schema(), path, key.where());
        const ValueKeys keys = read_value_keys(entry, names_files);
        axis.keys.push_back(path);
        axis.where.push_back(key.where());
        if (keys.values.present()) {
            axis.values.push_back(read_list(keys.values, names_files));
        } else if (keys.range.present()) {
            axis.values.push_back(read_range(keys.range));
        } else {
            axis.values.push_back(read_random(keys.random, !goes_together));
        }
        values_ += axis.values.back().size();
        if (values_ > kMostValues) {
            entry.fail("makes " + std::to_string(values_) + " values in all axes so far; use at most " +
                       std::to_string(kMostValues));
        }
    }

    std::size_t values_ = 0;
};

std::vector<ScenarioOverride> read_fixed(const Entry& entry) {
    std::vector<ScenarioOverride> fixed;
    for (const auto& [key, value] : entry.members()) {
        input::find_key_path(scenario_schema(), key, value.where());
        fixed.push_back({key, value.flow()});
    }
    return fixed;
}

constexpr NumberRange kSteps{1e-6, 1e6};

/// Reads the cost, or makes it from weights, as a sum of products.
void read_cost(const Entry& root, SweepDescription& sweep) {
    constexpr NumberRange kWeights{-1e12, 1e12};
    const Entry cost = root.child("cost");
    const Entry weights = root.child("weights");
    if (cost.present() && weights.present())
        weights.fail("is given together with a cost; use one of the two");
    if (cost.present()) {
        sweep.cost = cost.line();
        sweep.cost_where = cost.where();
    }
    if (!weights.present()) return;
    sweep.cost_where = weights.where();
    for (const auto& [figure, weight] : weights.members()) {
        sweep.cost += (sweep.cost.empty() ? "" : " + ") + text::number(weight.number(kWeights)) + " * " +
                      quoted_name(figure);
    }
    if (sweep.cost.empty()) weights.fail("has no entries; use figures and what one of each costs");
}

SearchDescription read_search(const Entry& entry) {
    const Entry key = entry.child("key");
    const std::string path = key.name();
    const SearchDescription all = describe_search(path, std::nullopt, std::nullopt, key.where());
    const NumberRange legal =
        scenario_schema().find(input::find_key_path(scenario_schema(), path, "").pattern)->rule.number;
    const auto end_of = [&](const char* name) -> std::optional<double> {
        const Entry end = entry.child(name);
        if (!end.present()) return std::nullopt;
        return all.step > 0.0 ? end.number(legal) : static_cast<double>(end.integer({all.from, all.to}));
    };
    std::optional<double> step;
    if (const Entry given = entry.child("step"); given.present()) step = given.number(kSteps);
    SearchDescription search = describe_search(path, end_of("from"), end_of("to"), entry.where(), step);
    search.where = key.where();
    if (const Entry goal = entry.child("goal"); goal.present()) {
        search.goal = goal.line();
        search.where = goal.where();
    }
    if (const Entry checks = entry.child("checks"); checks.present()) {
        search.checks = static_cast<int>(checks.integer(kChecks));
    }
    return search;
}

std::string read_name(const Entry& entry, const std::string& default_name) {
    if (!entry.present()) return default_name;
    std::string name = entry.name();
    // The files of its results have this name, too.
    if (name.find('/') != std::string::npos || name == "." || name == "..") {
        entry.fail(text::quoted(name) + " is a path; use a plain name, without slashes");
    }
    return name;
}

}  // namespace

SweepDescription parse_sweep(const std::string& text, const std::string& origin,
                             const std::filesystem::path& base) {
    const input::Value tree = input::parse_yaml(text, std::make_shared<const std::string>(origin), true);
    input::check_structure(tree, sweep_schema());
    const Entry root(tree, sweep_schema());
    SweepDescription sweep;
    const std::string stem = text::one_line(std::filesystem::path(origin).stem().string());
    sweep.name = read_name(root.child("name"), stem.empty() ? "sweep" : stem);
    sweep.base = base;
    if (const Entry scenario = root.child("scenario"); scenario.present()) {
        sweep.scenario = base / scenario.name();
    }
    sweep.fixed = read_fixed(root.child("set"));
    if (const Entry pictures = root.child("pictures"); pictures.present()) {
        sweep.pictures = pictures.boolean();
    }
    read_cost(root, sweep);
    const Entry axes = root.child("axes");
    sweep.axes_where = axes.where();
    AxesReader reader;
    for (const Entry& axis : axes.items()) sweep.axes.push_back(reader.read(axis));
    if (const Entry filter = root.child("filter"); filter.present()) {
        sweep.filter = filter.line();
        sweep.filter_where = filter.where();
    }
    if (const Entry search = root.child("minimize"); search.present()) sweep.search = read_search(search);
    return sweep;
}

SweepDescription load_sweep(const std::filesystem::path& file) {
    return parse_sweep(input::text_of_file(file), file.string(), file.parent_path());
}

std::vector<std::string> sweep_key_paths() { return sweep_schema().paths(); }

}  // namespace metabuffer::exploration
