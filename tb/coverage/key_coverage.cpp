#include "key_coverage.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "scenario/fault_keys.h"
#include "scenario/scenario_keys.h"

namespace metabuffer::coverage {
namespace {

using Names = std::vector<std::string>;

std::string name_of(const SchemaKey& key, const std::string& value) { return key.pattern + (" " + value); }

/// Of the whole machine, not of an entry of a list.
bool is_setting(const SchemaKey& key) {
    return std::string_view(key.pattern).find('[') == std::string_view::npos;
}

/// Of each value of a key that has few. In lists only names count: the numbers of faults, say, are drawn.
Names names_of(const SchemaKey& key) {
    constexpr std::int64_t kMany = 16;
    const ValueRule& rule = key.rule;
    const auto [low, high] = rule.whole;
    std::vector<std::int64_t> numbers;
    if (is_setting(key) && rule.type == ValueRule::Type::kWholeNumber) {
        numbers = rule.only;
        const bool is_short = numbers.empty() && high - low < kMany;
        for (std::int64_t number = low; is_short && number <= high; ++number) numbers.push_back(number);
    }
    Names names;
    for (const std::string& choice : rule.choices) names.push_back(name_of(key, choice));
    for (const std::int64_t number : numbers) names.push_back(name_of(key, std::to_string(number)));
    return names;
}

/// Settings that are one of several kinds, not more or less of something.
bool is_paired(const SchemaKey& key) {
    return is_setting(key) && !(key.rule.choices.empty() && key.rule.only.empty());
}

/// A test makes its machines without files.
bool says_how_files_are_read(const SchemaKey& key) {
    constexpr std::array<std::string_view, 3> kKeys{"depth_integers", "depth_bits", "colour_encoding"};
    return std::find(kKeys.begin(), kKeys.end(), key.pattern) != kKeys.end();
}

}  // namespace

KeyGoals::KeyGoals(Coverage& coverage) {
    CoverGroup values(coverage, {"scenario/values", "values of keys that have few"});
    CoverGroup pairs(coverage, {"scenario/pairs", "values of two keys that meet"});
    Names paired;
    for (const SchemaKey& key : scenario_schema().keys()) {
        if (says_how_files_are_read(key)) continue;
        const Names names = names_of(key);
        for (const std::string& name : names) {
            bins_.emplace(name, values.bin(name));
            if (!is_paired(key)) continue;
            for (const std::string& other : paired) {
                bins_.emplace(other + ", " + name, pairs.bin(other + ", " + name));
            }
        }
        if (is_paired(key)) paired.insert(paired.end(), names.begin(), names.end());
    }
}

void KeyGoals::hit_if_goal(const std::string& name) const {
    if (const auto found = bins_.find(name); found != bins_.end()) found->second.hit();
}

void KeyGoals::cover(const Scenario& scenario) const {
    Names earlier;
    for (const ObjectKey<Scenario>& key : setting_rows()) {
        if (key.value == nullptr) continue;
        const std::optional<KeyValue> value = key.value(scenario);
        if (!value) continue;
        const std::string name = name_of(key.schema, value_text(*value));
        hit_if_goal(name);
        for (const std::string& other : earlier) hit_if_goal(other + ", " + name);
        earlier.push_back(name);
    }
}

void KeyGoals::cover(const Fault& fault) const {
    hit_if_goal(std::string("faults[].kind ") + to_string(fault.kind));
    for (const FaultKeyUse& use : fault_keys_of(fault.kind)) {
        const std::optional<KeyValue> value = use.key->value(fault);
        if (value) hit_if_goal(name_of(use.key->schema, value_text(*value)));
    }
}

}  // namespace metabuffer::coverage
