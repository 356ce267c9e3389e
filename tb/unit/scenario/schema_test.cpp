#include "scenario/schema.h"

#include <catch2/catch.hpp>

#include "scenario/fault_keys.h"
#include "scenario/fault_kinds.h"
#include "scenario/scenario_keys.h"

namespace metabuffer::test {

TEST_CASE("a rule says what it accepts, and accepts just that, as files write it") {
    CHECK(value_text(std::int64_t{-7}) == "-7");
    CHECK(value_text(0.001) == "0.001");
    CHECK(value_text(100.0) == "100");
    CHECK(value_text(std::string("z-alpha-key")) == "z-alpha-key");
    CHECK(value_text(std::vector<double>{0.5, 20.0}) == "[0.5, 20]");
    const ValueRule range = ValueRule::whole_numbers({1, 64});
    CHECK(range.allowed() == "1 to 64");
    CHECK(range.complaint(std::int64_t{1}).empty());
    CHECK(range.complaint(std::int64_t{64}).empty());
    CHECK(range.complaint(std::int64_t{0}) == "0 is out of range; use 1 to 64");
    CHECK(range.complaint(std::int64_t{65}) == "65 is out of range; use 1 to 64");

    const ValueRule only = ValueRule::one_of({1, 2, 4}, "a supersampling");
    CHECK(only.allowed() == "1, 2 or 4");
    CHECK(only.complaint(std::int64_t{4}).empty());
    CHECK(only.complaint(std::int64_t{3}) == "3 is not a supersampling; use 1, 2 or 4");

    const ValueRule number = ValueRule::numbers({0.5, 2.0});
    CHECK(number.complaint(0.5).empty());
    CHECK(number.complaint(2.5) == "2.5 is out of range; use 0.5 to 2");
    CHECK(ValueRule::choice_of<StarvationMode>().allowed() == "glitch or stall");
    CHECK(ValueRule().allowed().empty());
}

/// Each of these keys follows from the other two.
bool of_one_sum(const ObjectKey<Scenario>& key) {
    const std::string path = key.schema.pattern;
    return path == "memory.page_miss_cycles" || path == "memory.precharge_cycles" ||
           path == "memory.activate_cycles";
}

TEST_CASE("each setting that is written to a scenario is read back, and no other changes") {
    for (const ObjectKey<Scenario>& key : setting_rows()) {
        if (key.set == nullptr) continue;
        INFO(key.schema.pattern);
        const ValueRule& rule = key.schema.rule;
        KeyValue value = key.value(Scenario()).value_or(0.0);  // an optional one is a number
        if (auto* const whole = std::get_if<std::int64_t>(&value)) {
            *whole = rule.only.empty() ? rule.whole.high : rule.only.back();
        } else if (auto* const number = std::get_if<double>(&value)) {
            *number = rule.number.high;
        } else if (auto* const numbers = std::get_if<std::vector<double>>(&value)) {
            for (double& each : *numbers) each += 7.0;
        } else {
            value = rule.type == ValueRule::Type::kChoice ? rule.choices.back() : std::string("a name");
        }
        Scenario scenario;
        key.set(scenario, value);
        CHECK(key.value(scenario) == value);
        for (const ObjectKey<Scenario>& other : setting_rows()) {
            if (other.value == nullptr || &other == &key || (of_one_sum(other) && of_one_sum(key))) continue;
            INFO(other.schema.pattern);
            CHECK(other.value(scenario) == other.value(Scenario()));
        }
    }
}

TEST_CASE("the fields of a table's row are those of the control scanline, in its order") {
    ViewportRow row;
    std::int64_t value = 1;
    for (const TableField& field : table_fields()) field.set(row, value++);
    CHECK(row == ViewportRow{1, 2, 3, 4, 5, 6, 7, 8});
    value = 1;
    for (const TableField& field : table_fields()) CHECK(field.value(row) == value++);
}

TEST_CASE("every key of a fault goes with some kind, and every kind has what it must have") {
    for (const FaultKey& key : fault_keys()) {
        INFO(key.name());
        int kinds = 0;
        for (const FaultTraits& kind : kFaultKinds) kinds += use_of(key, kind.value) != nullptr ? 1 : 0;
        CHECK(kinds > 0);
    }
    for (const FaultTraits& kind : kFaultKinds) {
        INFO(kind.name);
        CHECK(std::string(to_string(kind.value)) == kind.name);
        CHECK_FALSE(std::string(kind.meaning).empty());
        // A fault on a link says in which pair, one inside the machine may say from which clock on.
        const char* const when = is_on_link(kind.value) ? "pair" : "from_cycle";
        bool has_when = false;
        for (const FaultKeyUse& use : fault_keys_of(kind.value)) {
            has_when = has_when || std::string(use.key->name()) == when;
        }
        CHECK(has_when);
        CHECK(kind.only_at_level_rtl() == (kind.location != FaultLocation::kFrame));
    }
}

}  // namespace metabuffer::test
