#include "tools/exploration/sweep_plan.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "host/text.h"
#include "scenario/scenario_keys.h"
#include "scenario/yaml_reader.h"
#include "tools/exploration/axis_values.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/figures.h"

namespace metabuffer::exploration {
namespace {

[[noreturn]] void fail(const std::string& where, const std::string& message) {
    throw InputError(text::located(where, message));
}

/// Whether the path `inner` names something inside of what `outer` names, or the same. Both must be written in the same
/// way.
bool lies_in(const std::string& inner, const std::string& outer) {
    return inner.rfind(outer, 0) == 0 &&
           (inner.size() == outer.size() || inner[outer.size()] == '.' || inner[outer.size()] == '[');
}

/// The settings that a point has, in the order in which they are put into the scenario.
class KeyOrder {
  public:
    /// Fails if the key would undo one that comes before it.
    void add(const std::string& key, const std::string& where, const char* what) {
        const std::string path =
            key == kScenarioAxis ? key : input::find_key_path(scenario_schema(), key, where).path;
        for (const Earlier& earlier : earlier_) {
            if (!lies_in(earlier.path, path)) continue;
            if (earlier.path == path) {
                fail(where, key + " is " + earlier.what + " already; use each key once");
            }
            std::string message = key + " replaces all of it, ";
            message += earlier.path + " too, which is " + earlier.what + "; use the keys inside of " + key;
            fail(where, message);
        }
        earlier_.push_back({path, what});
    }
    /// Adds a setting of all points, which later keys must not undo.
    void add_fixed(const ScenarioOverride& fixed) {
        std::string where = "--set ";
        where += fixed.path + "=" + fixed.value;
        earlier_.push_back({input::find_key_path(scenario_schema(), fixed.path, where).path,
                            "set to one value for every point"});
    }

  private:
    struct Earlier {
        std::string path;
        std::string what;
    };
    std::vector<Earlier> earlier_;
};

std::string where_of(const Axis& axis, std::size_t key) {
    return key < axis.where.size() ? axis.where[key] : std::string();
}

/// The first entry that is the same as an earlier one: the earlier one's index, then its own.
std::optional<std::pair<std::size_t, std::size_t>> find_repeated(const Axis& axis) {
    std::vector<std::size_t> order(axis.values.front().size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto compare = [&axis](std::size_t left, std::size_t right) {
        for (const std::vector<std::string>& values : axis.values) {
            if (const int difference = values[left].compare(values[right]); difference != 0)
                return difference;
        }
        return 0;
    };
    std::stable_sort(order.begin(), order.end(),
                     [&compare](std::size_t left, std::size_t right) { return compare(left, right) < 0; });
    std::optional<std::pair<std::size_t, std::size_t>> first;
    for (std::size_t i = 1; i < order.size(); ++i) {
        if (compare(order[i - 1], order[i]) != 0) continue;
        if (!first || order[i] < first->second) first.emplace(order[i - 1], order[i]);
    }
    return first;
}

void check_axis(const Axis& axis) {
    if (axis.keys.empty() || axis.keys.size() != axis.values.size()) {
        fail(where_of(axis, 0), "the axis has no keys; use at least one, with values");
    }
    const std::size_t count = axis.values.front().size();
    for (std::size_t key = 0; key < axis.keys.size(); ++key) {
        if (axis.values[key].size() != count) {
            fail(where_of(axis, key), axis.keys[key] + " has " + std::to_string(axis.values[key].size()) +
                                          " values and " + axis.keys.front() + " has " +
                                          std::to_string(count) +
                                          "; use as many for each of the keys that go together");
        }
    }
    if (count == 0) fail(where_of(axis, 0), axis.keys.front() + " has no values; use at least one");
    if (const auto twice = find_repeated(axis)) {
        std::vector<std::string> values;
        values.reserve(axis.keys.size());
        for (const std::vector<std::string>& of_key : axis.values) values.push_back(of_key[twice->second]);
        fail(where_of(axis, 0), text::joined(axis.keys, "and") + " has " + text::joined(values, "and") +
                                    " twice, as values " + std::to_string(twice->first + 1) + " and " +
                                    std::to_string(twice->second + 1) + "; use each once");
    }
}

/// The number of all points, filtered or not. Throws InputError if there are too many.
std::int64_t count_points(const SweepDescription& description) {
    std::int64_t points = 1;
    for (const Axis& axis : description.axes) {
        // Cannot overflow: no axis is longer than memory, and the loop ends at the first product that is too large.
        points *= static_cast<std::int64_t>(axis.values.front().size());
        if (points > kMostPoints) {
            fail(description.axes_where, "the axes make " + std::to_string(points) +
                                             " points or more; use at most " + std::to_string(kMostPoints));
        }
    }
    return points;
}

void check_keys(const SweepDescription& description) {
    KeyOrder order;
    for (const ScenarioOverride& fixed : description.fixed) order.add_fixed(fixed);
    bool scenario_axis = false;
    for (const Axis& axis : description.axes) {
        check_axis(axis);
        for (std::size_t key = 0; key < axis.keys.size(); ++key) {
            order.add(axis.keys[key], where_of(axis, key), "an axis");
            scenario_axis = scenario_axis || axis.keys[key] == kScenarioAxis;
        }
    }
    if (description.search) {
        const std::string& key = description.search->key;
        order.add(key, description.search->where, "what is minimized");
    }
    if (scenario_axis && !description.scenario.empty()) {
        fail(description.axes_where,
             "an axis names the scenarios, and the sweep names one as well; use one of the two");
    }
    if (!scenario_axis && description.scenario.empty()) {
        fail(description.axes_where, "there is no scenario; use the key scenario, or an axis of that name");
    }
}

std::vector<std::string> keys_of(const std::vector<Axis>& axes) {
    std::vector<std::string> keys;
    for (const Axis& axis : axes) keys.insert(keys.end(), axis.keys.begin(), axis.keys.end());
    return keys;
}

/// Every scenario of a plan, read once.
class Scenarios {
  public:
    /// Throws InputError for one that cannot be read.
    Scenarios(const SweepPlan& plan, const SweepDescription& description) {
        if (!plan.scenario.empty()) read(plan.scenario, "");
        for (const Axis& axis : description.axes) {
            for (std::size_t key = 0; key < axis.keys.size(); ++key) {
                if (axis.keys[key] != kScenarioAxis) continue;
                for (const std::string& value : axis.values[key]) {
                    read(plan.scenario_file({{kScenarioAxis, value}}), where_of(axis, key));
                }
            }
        }
    }

    const ScenarioTemplate& at(const std::filesystem::path& file) const { return templates_.at(file); }

  private:
    void read(const std::filesystem::path& file, const std::string& where) {
        if (templates_.count(file) != 0) return;
        try {
            templates_.emplace(file, file).first->second.refuse_live();
        } catch (const InputError& error) {
            fail(where, error.what());
        }
    }

    std::map<std::filesystem::path, ScenarioTemplate> templates_;
};

class Filter {
  public:
    Filter(const SweepPlan& plan, const SweepDescription& description, const Scenarios& scenarios)
        : plan_(plan), scenarios_(scenarios) {
        where_ = description.filter_where;
        if (description.filter.empty()) return;
        std::vector<std::string> names = setting_keys();
        names.insert(names.end(), plan.keys.begin(), plan.keys.end());
        std::sort(names.begin(), names.end());
        names.erase(std::unique(names.begin(), names.end()), names.end());
        expression_.emplace(description.filter, names, description.filter_where);
        const std::vector<std::string>& used = expression_->names();
        needs_scenario_ = std::any_of(used.begin(), used.end(), [&plan](const std::string& name) {
            return std::find(plan.keys.begin(), plan.keys.end(), name) == plan.keys.end();
        });
    }

    /// The test of a point's settings; empty if all of them pass. Must not outlive the filter.
    PointSequence::Filter test() const {
        if (!expression_) return {};
        return [this](const std::vector<Setting>& settings) { return lets_through(settings); };
    }

  private:
    bool lets_through(const std::vector<Setting>& settings) const {
        std::map<std::string, std::string> values;
        if (needs_scenario_) {
            try {
                values = scenarios_.at(plan_.scenario_file(settings)).settings(plan_.overrides_of(settings));
            } catch (const InputError&) {
                return true;  // the point's run reports what is wrong with it
            }
        }
        return expression_->holds([&](const std::string& name) {
            if (const Setting* const setting = find_setting(settings, name)) {
                return value_of_setting(setting->value);
            }
            const auto found = values.find(name);
            if (found != values.end()) return value_of_setting(found->second);
            if (name == kLinkClock && values.count(kLinkRefresh) != 0) {
                fail(where_, name + " is not known before the images are read; use " + kLinkRefresh);
            }
            return Value();
        });
    }

    const SweepPlan& plan_;
    const Scenarios& scenarios_;
    std::optional<Expression> expression_;
    bool needs_scenario_ = false;  ///< for names that are not in the settings
    std::string where_;
    static constexpr const char* kLinkClock = "clocks.dvi_in_mhz";
    static constexpr const char* kLinkRefresh = "clocks.dvi_in_refresh_hz";
};

/// A checksum of what the points are made from. It leaves out scenario and fixed settings: the results' identity has
/// these.
std::string digest_of(const SweepDescription& description) {
    nlohmann::json all = {description.filter};
    for (const Axis& axis : description.axes) all.push_back({axis.keys, axis.values});
    const std::string text = all.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    return fmt::format("{:08x}", crc32_z(0, reinterpret_cast<const Bytef*>(text.data()), text.size()));
}

/// The values of "64..4096*2", "16..128+16" or "1..5". Nothing if the text is a value and not a range.
std::optional<std::vector<std::string>> range_values(const std::string& text, const std::string& where) {
    const std::size_t dots = text.find("..");
    if (dots == std::string::npos) return std::nullopt;
    const std::optional<AxisNumber> from = axis_number(text.substr(0, dots));
    if (!from) return std::nullopt;  // a path
    const std::string rest = text.substr(dots + 2);
    const std::size_t sign = rest.find_first_of("*+", 1);
    const std::optional<AxisNumber> to = axis_number(rest.substr(0, sign));
    AxisRange range{*from, to.value_or(AxisNumber()), std::nullopt, std::nullopt};
    bool good = to.has_value();
    if (sign != std::string::npos) {
        const std::optional<AxisNumber> by = axis_number(rest.substr(sign + 1));
        good = good && by.has_value();
        (rest[sign] == '*' ? range.factor : range.step) = by;
    }
    if (!good) {
        fail(where, text::quoted(text) + " is not a range; use FROM..TO, FROM..TO+STEP or FROM..TO*FACTOR");
    }
    if (const auto problem = problem_of(range)) fail(where, text + ": " + *problem);
    return values_of(range);
}

std::string with_bytes_written_out(const std::string& text) {
    std::string result;
    for (const char character : text) {
        const auto byte = static_cast<unsigned char>(character);
        if (byte < 0x80) {
            result += character;
            continue;
        }
        result += fmt::format("\\x{:02x}", byte);
    }
    return result;
}

/// Throws InputError if the goal names no figure of a run: such a goal is met always or never.
void check_goal(const SweepPlan& plan) {
    const SearchDescription& search = *plan.search;
    const Expression goal(search.goal, goal_names(plan.keys, search.key), search.where);
    const std::vector<std::string>& used = goal.names();
    const bool names_figure = std::any_of(
        used.begin(), used.end(), [](const std::string& name) { return figure_index(name).has_value(); });
    if (!names_figure) {
        fail(search.where, "the goal " + text::quoted(search.goal) +
                               " names no figure of a run; use one, as in whole or starved_pixels < 100");
    }
}

}  // namespace

const Setting* find_setting(const std::vector<Setting>& settings, const std::string& key) {
    const auto found = std::find_if(settings.begin(), settings.end(),
                                    [&key](const Setting& setting) { return setting.key == key; });
    return found == settings.end() ? nullptr : &*found;
}

std::string canonical_text(const std::vector<Setting>& settings) {
    nlohmann::ordered_json text = nlohmann::ordered_json::object();
    for (const Setting& setting : settings) text[setting.key] = setting.value;
    try {
        return text.dump();
    } catch (const nlohmann::ordered_json::type_error&) {
        // A file's name may hold bytes that are not UTF-8; two such names must stay different.
        for (auto& value : text) value = with_bytes_written_out(value.get<std::string>());
        return text.dump();
    }
}

std::string default_goal() { return std::string(kWhole) + " and stalled_cycles = 0"; }

std::vector<std::string> cost_names(const std::vector<std::string>& axis_keys,
                                    const std::string& search_key) {
    std::vector<std::string> names = goal_names(axis_keys, search_key);
    names.erase(std::remove_if(names.begin(), names.end(),
                               [](const std::string& name) { return name.empty() || name == kCost; }),
                names.end());
    return names;
}

std::vector<std::string> goal_names(const std::vector<std::string>& axis_keys,
                                    const std::string& search_key) {
    std::vector<std::string> names = axis_keys;
    names.push_back(search_key);
    for (const FigureKind& kind : figure_kinds()) names.emplace_back(kind.name);
    return names;
}

double SearchDescription::number_of(std::int64_t candidate) const {
    constexpr double kDigits = 1e9;  // so that 665 steps of 0.1 are 66.5 and not 66.50000000000001
    return step > 0.0 ? std::round(static_cast<double>(candidate) * step * kDigits) / kDigits
                      : static_cast<double>(candidate);
}

std::int64_t SearchDescription::candidate_of(double number) const {
    return std::llround(step > 0.0 ? number / step : number);
}

std::string SearchDescription::text_of(std::int64_t candidate) const {
    return step > 0.0 ? text::number(number_of(candidate)) : std::to_string(candidate);
}

namespace {

/// Sets the ends of the range, counted in steps and rounded inwards.
void set_fractions(SearchDescription& search, const NumberRange& range, const std::string& where) {
    constexpr double kRounding = 1e-9;
    const double first = std::ceil(range.low / search.step - kRounding);
    const double last = std::floor(range.high / search.step + kRounding);
    constexpr double kMostSteps = 1e15;
    if (first > last || last > kMostSteps) {
        fail(where, search.key + ": no multiple of " + text::number(search.step) + " lies from " +
                        text::number(range.low) + " to " + text::number(range.high) +
                        "; use a smaller step or a wider range");
    }
    search.from = static_cast<std::int64_t>(first);
    search.to = static_cast<std::int64_t>(last);
}

void set_whole_numbers(SearchDescription& search, const ValueRule& rule, const NumberRange& range) {
    search.from = static_cast<std::int64_t>(range.low);
    search.to = static_cast<std::int64_t>(range.high);
    for (const std::int64_t value : rule.only) {
        if (search.from <= value && value <= search.to) search.candidates.push_back(value);
    }
    if (rule.only.empty() || !search.candidates.empty()) return;
    std::vector<std::string> all;
    for (const std::int64_t value : rule.only) all.push_back(std::to_string(value));
    fail(search.where, search.key + ": none of its values is from " + std::to_string(search.from) + " to " +
                           std::to_string(search.to) + "; use a range that has one of " +
                           text::joined(all, "and"));
}

}  // namespace

SearchDescription describe_search(const std::string& key, std::optional<double> from,
                                  std::optional<double> to, const std::string& where,
                                  std::optional<double> step) {
    const std::string pattern =
        key == kScenarioAxis ? std::string() : input::find_key_path(scenario_schema(), key, where).pattern;
    const ValueRule& rule = scenario_schema().find(pattern)->rule;
    const bool whole = rule.type == ValueRule::Type::kWholeNumber;
    if (!whole && rule.type != ValueRule::Type::kNumber) {
        fail(where, key +
                        " does not hold a number, and only those can be minimized; use a key like "
                        "composer.buffer_pixels");
    }
    if (whole && step) fail(where, key + ": takes whole numbers, and no step; leave it out");
    SearchDescription search;
    search.key = key;
    search.goal = default_goal();
    search.where = where;
    if (!whole) search.step = step.value_or(kUsualStep);
    if (!whole && !(search.step > 0.0))
        fail(where, key + ": a step of " + text::number(search.step) + " goes nowhere; use one above 0");
    const NumberRange legal =
        whole ? NumberRange{static_cast<double>(rule.whole.low), static_cast<double>(rule.whole.high)}
              : rule.number;
    const NumberRange range{from.value_or(legal.low), to.value_or(legal.high)};
    const std::string prefix = key + ": ";
    for (const double end : {range.low, range.high}) {
        if (whole && end != std::floor(end)) {
            fail(where, prefix + text::number(end) + " is not a whole number; use one");
        }
        const std::string complaint =
            whole ? rule.complaint(static_cast<std::int64_t>(end)) : rule.complaint(end);
        const bool is_end_of_list = !rule.only.empty() && rule.whole.contains(static_cast<std::int64_t>(end));
        if (!complaint.empty() && !is_end_of_list) fail(where, prefix + complaint);
    }
    if (range.low > range.high) {
        fail(where, key + ": from " + text::number(range.low) + " is above to " + text::number(range.high) +
                        "; use from at most to");
    }
    if (whole) {
        set_whole_numbers(search, rule, range);
    } else {
        set_fractions(search, range, where);
    }
    return search;
}

std::filesystem::path SweepPlan::scenario_file(const std::vector<Setting>& settings) const {
    const Setting* const setting = find_setting(settings, kScenarioAxis);
    if (setting == nullptr) return scenario;
    // A command line's value is YAML: a name may be in quotation marks.
    if (setting->value.find_first_of("'\"") != 0) return base / setting->value;
    const auto origin = std::make_shared<const std::string>(kScenarioAxis);
    return base / input::parse_yaml(setting->value, origin, false).text;
}

std::vector<ScenarioOverride> SweepPlan::overrides_of(const std::vector<Setting>& settings) const {
    std::vector<ScenarioOverride> overrides = fixed;
    for (const Setting& setting : settings) {
        if (setting.key != kScenarioAxis) overrides.push_back({setting.key, setting.value});
    }
    return overrides;
}

SweepPlan make_plan(const SweepDescription& description, Shard shard) {
    check_keys(description);
    const std::int64_t count = count_points(description);
    SweepPlan plan;
    plan.name = description.name;
    plan.scenario = description.scenario;
    plan.base = description.base;
    plan.fixed = description.fixed;
    plan.keys = keys_of(description.axes);
    plan.pictures = description.pictures;
    plan.search = description.search;
    plan.cost = description.cost;
    if (!plan.cost.empty()) {
        const std::string search_key = plan.search ? plan.search->key : std::string();
        Expression(plan.cost, cost_names(plan.keys, search_key), description.cost_where);
    }
    if (plan.search) check_goal(plan);
    const Scenarios scenarios(plan, description);
    const Filter filter(plan, description, scenarios);
    plan.points = PointSequence(description.axes, shard, filter.test());
    plan.shard = shard;
    plan.digest = digest_of(description);
    if (plan.points.empty() && shard.count == 1) {
        fail(description.filter_where, text::quoted(description.filter) + " lets none of the " +
                                           std::to_string(count) + " points through; use a wider filter");
    }
    return plan;
}

std::vector<std::string> parse_values(const std::string& text, const std::string& where) {
    const auto origin = std::make_shared<const std::string>(where);
    std::vector<std::string> values;
    for (const input::Value& item : input::parse_yaml("[" + text + "]", origin, false).items) {
        if (item.kind == input::ValueKind::kNothing) {
            fail(where, text::quoted(text) + " has an empty value; use values with one comma between two");
        }
        std::optional<std::vector<std::string>> range;
        if (item.kind == input::ValueKind::kScalar && !item.quoted) range = range_values(item.text, where);
        if (range) {
            values.insert(values.end(), range->begin(), range->end());
        } else {
            values.push_back(input::flow_text(item));
        }
        if (values.size() > static_cast<std::size_t>(kMostPoints)) {
            fail(where, "has more than " + std::to_string(kMostPoints) + " values; use fewer");
        }
    }
    if (values.empty()) fail(where, "has no values; use some, like 32,64,128 or 64..4096*2");
    return values;
}

}  // namespace metabuffer::exploration
