#include "host/text.h"

#include <catch2/catch.hpp>

namespace metabuffer::text {

TEST_CASE("text: a message is one line, and what is cut keeps its ends and whole characters") {
    CHECK(one_line("").empty());
    CHECK(one_line("  a\n\tb \r\n c\x01") == "a b c");
    CHECK(one_line("\xc3\xa9t\xc3\xa9") == "\xc3\xa9t\xc3\xa9");
    CHECK(text::quoted("a\nb") == "'a b'");
    CHECK(text::quoted(std::string(60, 'x')) == "'" + std::string(60, 'x') + "'");
    CHECK(text::quoted(std::string(61, 'x')) == "'" + std::string(60, 'x') + "...'");
    std::string text = "x";
    for (int n = 0; n < 40; ++n) text += "\xc3\xa9";
    CHECK(text::quoted(text) == "'" + text.substr(0, 59) + "...'");
    CHECK(message("a\nb") == "a b");
    CHECK(message(std::string(kLongestMessage, 'x')) == std::string(kLongestMessage, 'x'));
    for (const std::string& filling :
         {std::string("0"), std::string("\xc3\xa9"), std::string("\xe2\x82\xac")}) {
        std::string text = "a.yaml:3: frames: ";
        for (int n = 0; n < 1000; ++n) text += filling;
        const std::string cut = message(text + " is out of range; use 1 to 64");
        INFO(cut);
        CHECK(cut.size() <= kLongestMessage);
        CHECK(cut.size() > kLongestMessage - 8);
        CHECK(cut.find("a.yaml:3: frames: ") == 0);
        CHECK(cut.find(" is out of range; use 1 to 64") == cut.size() - 29);
        const std::size_t gap = cut.find(" ... ");
        REQUIRE(gap != std::string::npos);
        CHECK((gap - 18) % filling.size() == 0);
        CHECK((cut.size() - gap - 5 - 29) % filling.size() == 0);
    }
    CHECK(has_control("a\tb"));
    CHECK(has_control("\x7f"));
    CHECK_FALSE(has_control("a b \xc3\xa9 \x85"));
    CHECK(located("a.yaml:3", "is\nempty") == "a.yaml:3: is empty");
    CHECK(located("", "is empty") == "is empty");
}

TEST_CASE("text: literals, lists, numbers and ranges as sentences have them") {
    CHECK(literal("", '"') == "\"\"");
    CHECK(literal("it's", '\'') == "'it''s'");
    CHECK(literal("it's", '"') == "\"it's\"");
    CHECK(literal("\"\xe4\"", '"') == "\"\"\"\xe4\"\"\"");
    CHECK(number_runs({}).empty());
    CHECK(number_runs({4}) == "4");
    CHECK(number_runs({0, 1, 2, 3, 5, 7, 8}) == "0 to 3, 5, 7 to 8");
    CHECK(listed({}).empty());
    CHECK(listed({"a", "b", "c"}) == "a, b, c");
    CHECK(joined({}, "or").empty());
    CHECK(joined({"a"}, "or") == "a");
    CHECK(joined({"a", "b"}, "and") == "a and b");
    CHECK(joined({"a", "b", "c"}, "or") == "a, b or c");
    CHECK(number(0.001) == "0.001");
    CHECK(number(100.0) == "100");
    CHECK(range(IntegerRange{-3, 4}) == "-3 to 4");
    CHECK(out_of_range(std::int64_t{5}, IntegerRange{-3, 4}) == "5 is out of range; use -3 to 4");
    CHECK(out_of_range(0.5, NumberRange{1.0, 2.5}) == "0.5 is out of range; use 1 to 2.5");
}

TEST_CASE("text: the nearest is the first of those with the least edit distance") {
    CHECK(edit_distance("", "") == 0);
    CHECK(edit_distance("", "abc") == 3);
    CHECK(edit_distance("abc", "") == 3);
    CHECK(edit_distance("kitten", "sitting") == 3);
    CHECK(edit_distance("widht", "width") == 1);
    CHECK(edit_distance("ab", "ba") == 1);
    CHECK(edit_distance("same", "same") == 0);
    CHECK(nearest("b", {"a", "c"}) == "a");
    CHECK(nearest("colums", {"rows", "columns"}) == "columns");
}

}  // namespace metabuffer::text
