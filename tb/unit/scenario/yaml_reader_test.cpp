#include "scenario/yaml_reader.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "scenario/scenario_keys.h"
#include "support/random_seed.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

using input::Value;
using input::ValueKind;

Value parse(const std::string& text) {
    return input::parse_yaml(text, std::make_shared<const std::string>("test"), false);
}

std::string flow(const std::string& text) { return input::flow_text(parse(text)); }

/// Equal as far as a reader can distinguish: quotation marks count where they keep a text from being a number.
bool same(const Value& left, const Value& right) {
    if (left.kind != right.kind || left.text != right.text || left.items.size() != right.items.size() ||
        left.members.size() != right.members.size()) {
        return false;
    }
    char* end = nullptr;
    std::strtod(left.text.c_str(), &end);
    const bool is_number = !left.text.empty() && *end == '\0' && end != left.text.c_str();
    if (is_number && left.quoted != right.quoted) return false;
    for (std::size_t i = 0; i < left.items.size(); ++i) {
        if (!same(left.items[i], right.items[i])) return false;
    }
    for (std::size_t i = 0; i < left.members.size(); ++i) {
        if (left.members[i].key != right.members[i].key ||
            !same(left.members[i].value, right.members[i].value)) {
            return false;
        }
    }
    return true;
}

std::string random_text(Random& random) {
    const std::vector<std::string> pieces{"a",  "irsa", "12", "-", "+",        ".5",   "~", "null", " ", ": ",
                                          "#",  ", ",   "[",  "]", "{",        "}",    "'", "\"",   "&", "*",
                                          "\\", "\n",   "\t", "%", "\xC3\xA4", "\x01", "!", "|",    ">", "?"};
    std::string text;
    for (int i = random.between(0, 4); i > 0; --i) {
        text += pieces[static_cast<std::size_t>(random.between(0, static_cast<int>(pieces.size()) - 1))];
    }
    return text;
}

Value random_value(Random& random, int depth) {
    Value value;
    const int kind = random.between(0, depth > 0 ? 5 : 3);
    if (kind == 0) return value;
    if (kind <= 3) {
        value.kind = ValueKind::kScalar;
        const std::vector<std::string> numbers{"0", "-7", "64", ".5", "1e3", "+3", "007", "-.25"};
        if (kind == 1) {
            value.text = numbers[static_cast<std::size_t>(random.between(0, 7))];
            value.quoted = random.one_in(2);
        } else {
            value.text = random_text(random);
            value.quoted = true;
        }
    } else if (kind == 4) {
        value.kind = ValueKind::kList;
        for (int i = random.between(0, 3); i > 0; --i) value.items.push_back(random_value(random, depth - 1));
    } else {
        value.kind = ValueKind::kMap;
        for (int i = random.between(0, 3); i > 0; --i) {
            value.members.push_back(
                {{}, std::to_string(i) + random_text(random), random_value(random, depth - 1)});
        }
    }
    return value;
}

}  // namespace

TEST_CASE("yaml: merge keys bring the members of maps that the map itself does not have") {
    struct Row {
        const char* text;
        const char* flow;
    };
    for (const Row& row :
         {Row{"[&a {x: 1, y: 2}, {<<: *a, y: 3}]", "[{x: 1, y: 2}, {y: 3, x: 1}]"},
          Row{"[&a {x: 1, y: 2}, {y: 3, <<: *a}]", "[{x: 1, y: 2}, {y: 3, x: 1}]"},
          Row{"[&a {x: 1}, &b {x: 2, y: 2}, {<<: [*a, *b]}]", "[{x: 1}, {x: 2, y: 2}, {x: 1, y: 2}]"},
          Row{"[&a {x: 1}, &b {<<: *a, y: 2}, {<<: *b}]", "[{x: 1}, {y: 2, x: 1}, {y: 2, x: 1}]"},
          Row{"{'<<': {x: 1}}", "{'<<': {x: 1}}"}, Row{"{<<: {}}", "{}"}}) {
        CHECK(flow(row.text) == row.flow);
    }
    for (const char* wrong : {"{<<: 3}", "{<<: [{}, 3]}", "{<<: ~}"}) {
        const std::string error = input_error_of([wrong] { parse(wrong); });
        CHECK(error.find("<<: is ") != std::string::npos);
        CHECK(error.find("; use a map with an anchor, such as *frame, or a list of them") !=
              std::string::npos);
    }
}

TEST_CASE("flow text and quoted scalars: read back as the same, plain words and numbers as they are") {
    for (const std::string text :
         {"64", "-3", "+5", ".5", "1e3", "irsa", "slot-allocation", "case-1.yaml", "../a/b.yaml", "true",
          "[1, 2, 3]", "{x: 1, y: -2}", "[[1, 2], {}, []]", "~"}) {
        CHECK(flow(text) == text);
    }
    CHECK(flow("- 1\n- a: 2\n  b:\n    - x\n") == "[1, {a: 2, b: [x]}]");
    CHECK(flow("'irsa'") == "irsa");
    CHECK(flow("'64'") == "'64'");
    CHECK(flow("'null'") == "'null'");
    CHECK(flow("''") == "''");
    CHECK(flow("a b") == "'a b'");
    CHECK(flow("it's") == "'it''s'");
    CHECK(flow("\"a\\nb\"") == "\"a\\x0Ab\"");
    CHECK(flow("null") == "~");
    CHECK(input::quoted_scalar("it's") == "'it''s'");
    for (const std::string text : {"64", "", "a\n\"b\"\\", "\xe4.png"}) {
        const Value scalar = parse(input::quoted_scalar(text));
        CHECK(scalar.text == text);
        CHECK(scalar.quoted);
    }
    const std::uint64_t seed = random_seed(20);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    for (int i = 0; i < 5000; ++i) {
        const Value value = random_value(random, 3);
        const std::string text = input::flow_text(value);
        INFO(text);
        CHECK(text.find('\n') == std::string::npos);
        CHECK(same(parse(text), value));
    }
}

TEST_CASE("key path: written in one way, and an invalid one is reported with the nearest valid one") {
    const Schema& schema = scenario_schema();
    for (const std::string path : {"renderers.0.frames.12.viewport.x", "renderers[0].frames[12].viewport.x",
                                   "renderers.0.frames[12].viewport.x"}) {
        const input::KeyPath found = input::find_key_path(schema, path, "");
        CHECK(found.path == "renderers[0].frames[12].viewport.x");
        CHECK(found.pattern == "renderers[].frames[].viewport.x");
    }
    CHECK(input::find_key_path(schema, "bus", "").path == "bus");
    CHECK(input::find_key_path(schema, "displays.background.1", "").pattern == "displays.background[]");
    const auto error = [](const std::string& path) {
        return input_error_of([&] { input::find_key_path(scenario_schema(), path, "here"); });
    };
    check_refusals(error)({
        {"bus.widht_bits", "here: bus.widht_bits: is not a known key; the nearest is bus.width_bits"},
        {"renderers.0.frames.0.viewport.mutiple",
         "here: renderers[0].frames[0].viewport.mutiple: is not a known key; the nearest is "
         "renderers[0].frames[0].viewport.multiple"},
        {"renderers.first.name",
         "here: renderers: 'first' is not an index; use an index of renderers, from 0"},
        {"frames.0", "here: frames: has nothing inside; use frames"},
        {"bus[0]", "here: bus.0: is not a known key; the nearest is bus.width_bits"},
    });
    for (const std::string path : {"", ".", "bus.", "[0]", "renderers[0"}) {
        CHECK(
            error(path) ==
            "here: '" + path +
                "' is not a key path; use keys and indices with dots, like renderers.0.frames.1.viewport.x");
    }
    CHECK(input_error_of([] {
              input::find_key_path(scenario_schema(), "x", "");
          }).rfind("x: is not a known key; ", 0) == 0);
}

}  // namespace metabuffer::test
