#include "tools/program/keys_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "report/text_table.h"
#include "scenario/fault_keys.h"
#include "scenario/fault_kinds.h"
#include "scenario/scenario_keys.h"
#include "scenario/scenario_loader.h"

namespace metabuffer {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kKindOfFault = "faults[].kind";
constexpr const char* kKeysFooter =
    "Without a prefix it lists every key. A list's entries are written []: in --set use an index instead.\n"
    "Examples:\n"
    "  metabuffer keys\n"
    "  metabuffer keys bus\n"
    "  metabuffer keys faults --json\n"
    "Exit status: 0 done; 2 no key begins like that.";

const char* type_name(const SchemaKey& key) {
    switch (key.shape) {
        case KeyShape::kMap:
        case KeyShape::kFreeMap:
            return "map";
        case KeyShape::kList:
            return "list";
        case KeyShape::kScalar:
        case KeyShape::kAny:
            break;
    }
    switch (key.rule.type) {
        case ValueRule::Type::kWholeNumber:
            return "whole number";
        case ValueRule::Type::kNumber:
            return "number";
        case ValueRule::Type::kChoice:
            return "choice";
        case ValueRule::Type::kText:
            return "text";
        case ValueRule::Type::kAny:
            break;
    }
    return "value";
}

std::vector<std::string> key_names(const FaultTraits& kind) {
    std::vector<std::string> names;
    for (const FaultKeyUse& use : fault_keys_of(kind.value)) names.emplace_back(use.key->name());
    return names;
}

Json kinds_json() {
    Json json = Json::array();
    for (const FaultTraits& kind : kFaultKinds) {
        json.push_back({{"name", kind.name},
                        {"keys", key_names(kind)},
                        {"only_at_level_rtl", kind.only_at_level_rtl()},
                        {"meaning", kind.meaning}});
    }
    return json;
}

Json key_json(const SchemaKey& key) {
    Json json{{"path", key.pattern}, {"type", type_name(key)}, {"unit", key.unit}};
    const ValueRule& rule = key.rule;
    if (rule.type == ValueRule::Type::kChoice) json["choices"] = rule.choices;
    if (!rule.only.empty()) json["choices"] = rule.only;
    if (rule.type == ValueRule::Type::kWholeNumber) {
        json["minimum"] = rule.whole.low;
        json["maximum"] = rule.whole.high;
    }
    if (rule.type == ValueRule::Type::kNumber) {
        json["minimum"] = rule.number.low;
        json["maximum"] = rule.number.high;
    }
    json["default"] = key.fallback;
    json["meaning"] = key.meaning;
    if (std::string_view(key.pattern) == kKindOfFault) json["kinds"] = kinds_json();
    return json;
}

std::string kinds_text() {
    TextTable table({0, 1, 2});
    table.add({"kind of fault", "keys besides renderer and kind", "what goes wrong"});
    for (const FaultTraits& kind : kFaultKinds) {
        table.add({kind.name, text::joined(key_names(kind), "and"),
                   std::string(kind.meaning) + (kind.only_at_level_rtl() ? "; level rtl only" : "")});
    }
    return "\n" + table.text();
}

std::string keys_text(const std::vector<const SchemaKey*>& keys) {
    TextTable table({0, 1, 2, 3, 4});
    table.add({"key", "values", "unit", "default", "meaning"});
    bool has_kinds = false;
    for (const SchemaKey* key : keys) {
        if (key->shape == KeyShape::kMap) continue;  // its keys have lines of their own
        const bool is_kind = std::string_view(key->pattern) == kKindOfFault;
        has_kinds = has_kinds || is_kind;
        const std::string allowed = is_kind ? std::string("see below") : key->rule.allowed();
        table.add({key->pattern, allowed.empty() ? type_name(*key) : allowed, key->unit, key->fallback,
                   key->meaning});
    }
    return table.text() + (has_kinds ? kinds_text() : "");
}

}  // namespace

KeysCommand::KeysCommand(CLI::App& program)
    : Command(program, "keys", "List the keys of scenarios: values, units, defaults, meanings") {
    command().add_option("PREFIX", prefix_, "How the keys begin: bus, composer.b");
    command().add_flag("--json", json_, "As JSON");
    command().footer(kKeysFooter);
}

ExitStatus KeysCommand::execute() {
    std::vector<const SchemaKey*> keys;
    for (const SchemaKey& key : scenario_schema().keys()) {
        const std::string_view path = key.pattern;
        const bool ends_in_key = !path.empty() && path.back() != ']';
        if (ends_in_key && path.substr(0, prefix_.size()) == prefix_) keys.push_back(&key);
    }
    if (keys.empty()) {
        throw InputError("keys: " + text::quoted(prefix_) + " begins no key; the nearest is " +
                         text::nearest(prefix_, scenario_key_paths()));
    }
    if (json_) {
        Json json = Json::array();
        for (const SchemaKey* key : keys) json.push_back(key_json(*key));
        std::cout << json.dump(2) << '\n';
    } else {
        std::cout << keys_text(keys);
    }
    return kExitDone;
}

}  // namespace metabuffer
