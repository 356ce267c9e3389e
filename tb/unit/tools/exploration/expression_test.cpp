#include "tools/exploration/expression.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "host/errors.h"
#include "support/random_seed.h"

namespace metabuffer::exploration {
namespace {

using Values = std::map<std::string, Value>;

const Values& machine() {
    static const Values values{{"bus.width_bits", std::int64_t{64}},
                               {"bus.arbitration", std::string("edf")},
                               {"renderers.0.frames.0.viewport.x", std::int64_t{-3}},
                               {"frames", std::int64_t{2}},
                               {"clocks.core_mhz", 33.5},
                               {"small-bus", std::int64_t{5}},
                               {"small", std::int64_t{100}},
                               {"bus", std::int64_t{1}},
                               {"latency_cycles", Value()},
                               {"n\xc3\xa4me", std::int64_t{8}},
                               {"od\"d", std::int64_t{9}}};
    return values;
}

std::vector<std::string> names_of(const Values& values) {
    std::vector<std::string> names;
    for (const auto& [name, value] : values) names.push_back(name);
    return names;
}

Value evaluated(const std::string& text, const Values& values = machine()) {
    return Expression(text, names_of(values), "WHERE").evaluate([&values](const std::string& name) {
        return values.at(name);
    });
}

bool holds(const std::string& text) {
    return Expression(text, names_of(machine()), "WHERE").holds([](const std::string& name) {
        return machine().at(name);
    });
}

std::string refusal(const std::string& text) {
    try {
        evaluated(text);
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

}  // namespace

TEST_CASE("expression: the longest whole name stands for its value") {
    CHECK(evaluated("bus.width_bits") == Value(std::int64_t{64}));
    CHECK(evaluated("bus.width_bits+1") == Value(std::int64_t{65}));
    CHECK(evaluated("renderers.0.frames.0.viewport.x * frames") == Value(std::int64_t{-6}));
    CHECK(evaluated("clocks.core_mhz*2") == Value(67.0));
    CHECK(evaluated("latency_cycles") == Value());
    CHECK(evaluated("bus.arbitration") == Value(std::string("edf")));
    CHECK(evaluated("\"bus.width_bits\" / 2") == Value(std::int64_t{32}));
    CHECK(evaluated("n\xc3\xa4me") == Value(std::int64_t{8}));
    CHECK(evaluated("\"od\"\"d\"") == Value(std::int64_t{9}));
    CHECK(evaluated("small-bus") == Value(std::int64_t{5}));
    CHECK(evaluated("small - bus") == Value(std::int64_t{99}));
    CHECK(evaluated("small-frames") == Value(std::int64_t{98}));
    CHECK(evaluated("small-bus-bus") == Value(std::int64_t{4}));
    CHECK(evaluated("bus.width_bits-bus") == Value(std::int64_t{63}));
    CHECK(refusal("bus.width_bitsx").find("'bus.width_bitsx' is not known") != std::string::npos);
    CHECK(refusal("frames.count").find("'frames.count' is not known") != std::string::npos);
    CHECK(refusal("xframes").find("'xframes' is not known") != std::string::npos);
    const Expression expression("frames > 1 and bus.width_bits > frames", names_of(machine()), "");
    CHECK(expression.names() == std::vector<std::string>{"frames", "bus.width_bits"});
    CHECK(expression.text() == "frames > 1 and bus.width_bits > frames");
}

TEST_CASE("expression: texts stay texts, and values that one could hide in are bound and not read") {
    CHECK(evaluated("'bus.width_bits'") == Value(std::string("bus.width_bits")));
    CHECK(evaluated("'it''s frames'") == Value(std::string("it's frames")));
    CHECK(holds("bus.arbitration = 'edf' and 'edf' <> 'EDF'"));
    CHECK(holds("bus.arbitration < 'irsa'"));
    CHECK(holds("bus.arbitration in ('irsa', 'edf')"));
    CHECK(holds("bus.arbitration LIKE 'E%'"));
    const Values hostile{{"a", std::string("' or 1=1 --")}};
    CHECK(evaluated("a = ''' or 1=1 --'", hostile) == Value(std::int64_t{1}));
    CHECK(evaluated("a = 'x'", hostile) == Value(std::int64_t{0}));
}

TEST_CASE("expression: null and zero are not true, and one without a value says so") {
    CHECK(holds("1"));
    CHECK(holds("0.5"));
    CHECK(holds("-1"));
    CHECK_FALSE(holds("0"));
    CHECK_FALSE(holds("0.0"));
    CHECK_FALSE(holds("null"));
    CHECK_FALSE(holds("latency_cycles < 5"));
    CHECK_FALSE(holds("not (latency_cycles < 5)"));
    CHECK_THROWS_WITH(holds("bus.arbitration"),
                      "WHERE: 'bus.arbitration' is the text 'edf', neither true nor false; use a comparison");
    const Values values{{"a", std::numeric_limits<std::int64_t>::min()}};
    const Expression expression("abs(a)", {"a"}, "goal");
    CHECK_THROWS_WITH(expression.evaluate([&values](const std::string& name) { return values.at(name); }),
                      "goal: 'abs(a)' has no value: integer overflow");
    // And it can be used again.
    CHECK(expression.evaluate([](const std::string&) { return Value(std::int64_t{-2}); }) ==
          Value(std::int64_t{2}));
}

TEST_CASE("expression: unknown names are reported with the nearest") {
    CHECK(refusal("bus.width_bit = 3") ==
          "WHERE: 'bus.width_bit' is not known; the nearest is bus.width_bits");
    CHECK(refusal("bus.arbitration = edf").find("write 'edf'") != std::string::npos);
    CHECK(refusal("bus.arbitration = \"edf\"").find("write 'edf'") != std::string::npos);
    CHECK(refusal("rund(1.5)") ==
          "WHERE: 'rund' is no function that can be used here; the nearest is round()");
    CHECK_THROWS_WITH(Expression("x", {}, ""), "'x' is not known; if it is a text, write 'x'");
}

TEST_CASE(
    "expression: an invalid one is refused on one line, and reaches no table, file or setting of SQLite") {
    const auto refused = [](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) {
            CAPTURE(text);
            const std::string message = refusal(text);
            CHECK(message.rfind("WHERE: ", 0) == 0);
            CHECK(message.find('\n') == std::string::npos);
        }
    };
    refused({"", "  ", "> 1", "1 +", "()", "(1", "1)", "*", "{1}", "1;", "; 1", "?", "?1", "\\", "#"});
    refused({"1, 2", "(1, 2)", "'open", "\"open", "64bits", "1.2.3", "in (1)", "round()", "max(1)", ":frames",
             "@frames", "$frames", "x'00'", "a b c", "min(1)"});
    refused({"frames >",     "frames frames", "frames as text", "1) or (1",       "1 from frames",
             "distinct 1",   "round(1,)",     "count(*)",       "frames.*",       "frames = [1]",
             "`frames`",     "1 -- more",     "1 /* more */",   "(select 1)",     "(values (1))",
             "1 group by 1", "1 limit 1",     "edit('x')",      "random()",       "raise(ignore)",
             "json('[]')",   "'[1]' -> 0",    "'[1]' ->> 0",    "sum(1) over ()", "1 match 2",
             "1 regexp 2",   "1 collate evil"});
    refused({"case when 1 then", "1; drop table x", "current_timestamp", "exists (select 1)",
             "1 in (select 1)", "1 union select 2", "attach 'x' as y", "sqlite_version()", "group_concat(1)",
             "randomblob(1000000000)", "pragma_database_list", "1 from sqlite_master", "zeroblob(1000000000)",
             "row_number() over ()", "load_extension('x')", "writefile('x', 'y')", "last_insert_rowid()",
             "fts3_tokenizer('x')", "1 in sqlite_master"});
    refused({"(with recursive t(x) as (select 1 union all select x + 1 from t) select x from t)",
             "(SELECT sql FROM sqlite_master)", "1 in pragma_table_info('x')", "sqlite_compileoption_get(1)",
             "1 in pragma_database_list", "load_extension /**/ ('x')", "printf('%1000000000d', 1)",
             "\"load_extension\"('x')", "readfile('/etc/passwd')", std::string("'\0'", 3),
             std::string("1\0", 2)});
}

TEST_CASE("expression: one that is too long or too deep is refused") {
    const auto repeated = [](const std::string& text, int times) {
        std::string result;
        for (int n = 0; n < times; ++n) result += text;
        return result;
    };
    CHECK(evaluated(repeated("(", 50) + "1" + repeated(")", 50)) == Value(std::int64_t{1}));
    CHECK(refusal(repeated("(", 51) + "1" + repeated(")", 51)) ==
          "WHERE: parentheses are nested deeper than 50");
    CHECK(refusal(std::string(10'001, '1')) ==
          "WHERE: the expression has 10001 characters; use at most 10000");
    CHECK(evaluated("1" + repeated("+1", 500)) == Value(std::int64_t{501}));
    for (const std::string& text :
         {"1" + repeated("+1", 4000), repeated("not ", 2000) + "1", repeated("- ", 4000) + "1",
          repeated("case when 1 then ", 500) + "1", std::string(9'000, 'x'), repeated("x.", 4000) + "x"}) {
        const std::string message = refusal(text);
        CHECK(message.rfind("WHERE: ", 0) == 0);
        CHECK(message.size() < 20'000);
    }
}

TEST_CASE("expression: SQL for columns has the names in quotes, and a list is split at its own commas") {
    const std::vector<std::string> names = names_of(machine());
    CHECK(sql_expression("bus.width_bits>=64 AND small-bus<>'bus.width_bits'", names, "") ==
          "\"bus.width_bits\">=64 AND \"small-bus\"<>'bus.width_bits'");
    CHECK(sql_expression("\"od\"\"d\" + frames", names, "") == "\"od\"\"d\" + \"frames\"");
    CHECK_THROWS_WITH(sql_expression("bus.width_bit", names, "--where"),
                      "--where: 'bus.width_bit' is not known; the nearest is bus.width_bits");
    CHECK_THROWS_AS(sql_expression("frames) or (1", names, ""), InputError);
    CHECK(split_expressions("a") == std::vector<std::string>{"a"});
    CHECK(split_expressions(" a , max(b, 1),'x,y' , \"c,d\"") ==
          std::vector<std::string>{"a", "max(b, 1)", "'x,y'", "\"c,d\""});
    CHECK(split_expressions("a,,") == std::vector<std::string>{"a", "", ""});
    CHECK(split_expressions("'it''s, ' || a, b") == std::vector<std::string>{"'it''s, ' || a", "b"});
    CHECK(split_expressions("").size() == 1);
    using Parts = std::vector<std::string>;
    CHECK(conjuncts("whole") == Parts{"whole"});
    CHECK(conjuncts("(a AND (b or c and d and e)) and sand > 'x and y'") ==
          Parts{"a", "b or c and d and e", "sand > 'x and y'"});
    CHECK(conjuncts("(a) or (b and c)") == Parts{"(a) or (b and c)"});
}

namespace {

/// Random formulas that come with their values, made together: SQL's three-valued logic in C++.
class Formulas {
  public:
    struct Number {
        std::string text;
        std::optional<double> value;
    };
    struct Truth {
        std::string text;
        std::optional<bool> value;
    };

    explicit Formulas(test::Random& random) : random_(random) {
        for (const char* name : {"a", "a.b", "a-b", "bus.width_bits", "x_1.0.y"}) {
            if (random_.one_in(4)) {
                numbers_[name] = Value();
            } else if (random_.one_in(2)) {
                numbers_[name] = std::int64_t{random_.between(-9, 9)};
            } else {
                numbers_[name] = random_.between(-9, 9) + 0.25;
            }
        }
        for (const char* name : {"policy", "t.policy"}) texts_[name] = word();
    }

    Values values() const {
        Values all = numbers_;
        for (const auto& [name, word] : texts_) all[name] = word;
        return all;
    }

    Number number(int depth) {
        if (depth == 0 || random_.one_in(4)) return leaf();
        if (random_.one_in(8)) {
            const Truth condition = truth(depth - 1);
            const Number yes = number(depth - 1);
            const Number no = number(depth - 1);
            return {
                "case when " + condition.text + space() + " then " + yes.text + " else " + no.text + " end",
                condition.value.value_or(false) ? yes.value : no.value};
        }
        const Number left = number(depth - 1);
        const Number right = number(depth - 1);
        const bool known = left.value && right.value;
        const auto with = [&](const std::string& sign, double value) {
            return Number{"(" + left.text + space() + sign + " " + right.text + space() + ")",
                          known ? std::optional(value) : std::nullopt};
        };
        switch (random_.between(0, 2)) {
            case 0:
                return with("+", left.value.value_or(0) + right.value.value_or(0));
            case 1:
                return with("-", left.value.value_or(0) - right.value.value_or(0));
            default:
                return with("*", left.value.value_or(0) * right.value.value_or(0));
        }
    }

    Truth truth(int depth) {
        if (depth == 0 || random_.one_in(3)) return random_.one_in(3) ? text_comparison() : comparison(depth);
        const Truth left = truth(depth - 1);
        if (random_.one_in(4)) {
            return {"(nOt " + left.text + ")", left.value ? std::optional(!*left.value) : std::nullopt};
        }
        const Truth right = truth(depth - 1);
        const bool is_and = random_.one_in(2);
        Truth result{"(" + left.text + (is_and ? " and " : " OR ") + right.text + ")", std::nullopt};
        // A side that decides does so whatever the other is.
        const bool decisive = !is_and;
        if (left.value == decisive || right.value == decisive) {
            result.value = decisive;
        } else if (left.value && right.value) {
            result.value = !decisive;
        }
        return result;
    }

  private:
    std::string space() { return random_.one_in(2) ? "" : random_.one_in(2) ? " " : "\n\t"; }

    std::string word() {
        constexpr std::array<const char*, 5> kWords{"edf", "irsa", "it's", "a.b", "EDF"};
        return kWords[static_cast<std::size_t>(random_.between(0, 4))];
    }

    Number leaf() {
        if (random_.one_in(2)) {
            const int whole = random_.between(0, 9);
            if (random_.one_in(2)) return {std::to_string(whole), whole};
            return {std::to_string(whole) + ".5", whole + 0.5};
        }
        auto entry = numbers_.begin();
        std::advance(entry, random_.between(0, static_cast<int>(numbers_.size()) - 1));
        std::optional<double> value;
        if (const auto* whole = std::get_if<std::int64_t>(&entry->second)) {
            value = static_cast<double>(*whole);
        } else if (const auto* number = std::get_if<double>(&entry->second)) {
            value = *number;
        }
        const bool is_quoted = random_.one_in(4);
        return {is_quoted ? "\"" + entry->first + "\"" : entry->first, value};
    }

    Truth comparison(int depth) {
        const Number left = number(depth == 0 ? 0 : depth - 1);
        if (random_.one_in(6)) return {"(" + left.text + " is null)", !left.value};
        const Number right = number(depth == 0 ? 0 : depth - 1);
        const bool known = left.value && right.value;
        const double a = left.value.value_or(0);
        const double b = right.value.value_or(0);
        const auto with = [&](const std::string& sign, bool value) {
            return Truth{"(" + left.text + " " + sign + space() + " " + right.text + ")",
                         known ? std::optional(value) : std::nullopt};
        };
        switch (random_.between(0, 5)) {
            case 0:
                return with("<", a < b);
            case 1:
                return with("<=", a <= b);
            case 2:
                return with(">", a > b);
            case 3:
                return with(">=", a >= b);
            case 4:
                return with("=", a == b);
            default:
                return with("<>", a != b);
        }
    }

    Truth text_comparison() {
        auto entry = texts_.begin();
        std::advance(entry, random_.between(0, static_cast<int>(texts_.size()) - 1));
        const std::string other = word();
        std::string literal = "'";
        for (const char character : other) literal += character == '\'' ? "''" : std::string(1, character);
        literal += "'";
        if (random_.one_in(2))
            return {"(" + entry->first + space() + "=" + literal + ")", entry->second == other};
        return {"(" + entry->first + " < " + literal + ")", entry->second < other};
    }

    test::Random& random_;
    Values numbers_;
    std::map<std::string, std::string> texts_;
};

std::optional<double> number_of(const Value& value) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
    if (const auto* number = std::get_if<double>(&value)) return *number;
    return std::nullopt;
}

}  // namespace

TEST_CASE("expression: random formulas have the values that C++ gives them") {
    const std::uint64_t seed = test::random_seed(4);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    int true_ones = 0;
    for (int n = 0; n < 2000; ++n) {
        Formulas formulas(random);
        const Values values = formulas.values();
        const Formulas::Number number = formulas.number(4);
        CAPTURE(number.text);
        REQUIRE(number_of(evaluated(number.text, values)) == number.value);

        const Formulas::Truth truth = formulas.truth(4);
        CAPTURE(truth.text);
        const Expression expression(truth.text, names_of(values), "");
        REQUIRE(expression.holds([&values](const std::string& name) { return values.at(name); }) ==
                truth.value.value_or(false));
        true_ones += truth.value.value_or(false) ? 1 : 0;
    }
    CHECK(true_ones > 200);
    CHECK(true_ones < 1800);
}

TEST_CASE("expression: any words in any order have a value or an error of one line") {
    const std::uint64_t seed = test::random_seed(5);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    std::istringstream list(
        "frames bus.width_bits small-bus 1 0.5 'x' \"frames\" ( ) ( ) and or not + - * / % < > = || & ~ , in "
        "is null between like case when then else end cast as integer text collate nocase distinct from max "
        "round abs select sqlite_master ; -- ' \" . ?");
    std::vector<std::string> words{std::istream_iterator<std::string>(list), {}};
    words.emplace_back("\n");
    int accepted = 0;
    for (int n = 0; n < 20000; ++n) {
        std::string text;
        const int count = random.between(1, 7);
        for (int word = 0; word < count; ++word) {
            text += words[static_cast<std::size_t>(random.between(0, static_cast<int>(words.size()) - 1))];
            if (!random.one_in(4)) text += ' ';
        }
        const std::string message = refusal(text);
        if (message == "accepted") {
            ++accepted;
            continue;
        }
        CAPTURE(text);
        REQUIRE(message.rfind("WHERE: ", 0) == 0);
        REQUIRE(message.find('\n') == std::string::npos);
    }
    CHECK(accepted > 100);
}

}  // namespace metabuffer::exploration
