#include "tools/exploration/table_text.h"

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/random_seed.h"
#include "tools/exploration/results_database.h"

namespace metabuffer::exploration {
namespace {

using Rows = std::vector<std::vector<std::string>>;

/// Reads CSV by the grammar of RFC 4180 and fails on everything else.
Rows rows_of(const std::string& csv) {
    Rows rows;
    std::size_t position = 0;
    while (position < csv.size()) {
        std::vector<std::string>& row = rows.emplace_back();
        for (;;) {
            std::string field;
            if (csv.at(position) == '"') {
                ++position;
                while (csv.at(position) != '"' || csv.compare(position, 2, "\"\"") == 0) {
                    if (csv.at(position) == '"') ++position;
                    field += csv.at(position++);
                }
                ++position;
            } else {
                while (std::string(",\r\n\"").find(csv.at(position)) == std::string::npos) {
                    field += csv.at(position++);
                }
            }
            row.push_back(field);
            if (csv.at(position) != ',') break;
            ++position;
        }
        REQUIRE(csv.substr(position, 2) == "\r\n");
        position += 2;
    }
    return rows;
}

std::string written(TableFormat format, const ResultsReader::Table& table) {
    std::string text;
    TableText writer(format, table.columns, [&text](std::string_view bytes) { text += bytes; });
    for (const std::vector<Value>& row : table.rows) writer.add(row);
    writer.end();
    return text;
}
std::string csv_text(const ResultsReader::Table& table) { return written(TableFormat::kCsv, table); }
std::string json_text(const ResultsReader::Table& table) { return written(TableFormat::kJson, table); }

std::string random_text(test::Random& random) {
    const std::string characters = "ab,\"'\r\n ;\t\xc3\xa9";
    std::string text;
    for (int n = random.between(0, 6); n > 0; --n) {
        text +=
            characters[static_cast<std::size_t>(random.between(0, static_cast<int>(characters.size()) - 1))];
    }
    return text;
}

}  // namespace

TEST_CASE("table text: CSV is as RFC 4180 has it, and JSON repairs texts that are not UTF-8") {
    const ResultsReader::Table table{{"point", "a,b", "reason"},
                                     {{std::int64_t{1}, 0.5, std::string("says \"no\"\nand ends")},
                                      {std::int64_t{2}, Value(), std::string()}}};
    CHECK(csv_text(table) == "point,\"a,b\",reason\r\n1,0.5,\"says \"\"no\"\"\nand ends\"\r\n2,,\r\n");
    CHECK(csv_text({{"a"}, {}}) == "a\r\n");
    CHECK(rows_of(csv_text({{"a"}, {{Value()}, {std::int64_t{1}}}})) == Rows{{"a"}, {""}, {"1"}});
    CHECK(csv_text({{"a"}, {{Value()}}}) == "a\r\n\"\"\r\n");
    const auto json = nlohmann::json::parse(json_text({{"a"}, {{std::string("x\xff")}}}));
    CHECK(json[0]["a"] == "x\xef\xbf\xbd");
    CHECK(json_text({{"a"}, {}}) == "[\n]\n");
}

namespace {

/// A text that a spreadsheet would read as a formula has an apostrophe before it; numbers have not.
std::string harmless_text(const Value& value) {
    const auto* words = std::get_if<std::string>(&value);
    const bool is_formula = words != nullptr && !words->empty() &&
                            std::string("=+-@\t\r").find(words->front()) != std::string::npos;
    return is_formula ? "'" + *words : text_of(value);
}

}  // namespace

TEST_CASE("table text: random tables read back from CSV and JSON") {
    const std::uint64_t seed = test::random_seed(6);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int n = 0; n < 300; ++n) {
        ResultsReader::Table table;
        Rows expected(1);
        const int columns = random.between(1, 5);
        for (int column = 0; column < columns; ++column) {
            table.columns.push_back(std::to_string(column) + random_text(random));
            expected[0].push_back(harmless_text(table.columns.back()));
        }
        for (int row = random.between(0, 5); row > 0; --row) {
            auto& values = table.rows.emplace_back();
            auto& texts = expected.emplace_back();
            for (int column = 0; column < columns; ++column) {
                switch (random.between(0, 3)) {
                    case 0:
                        values.emplace_back();
                        break;
                    case 1:
                        values.emplace_back(std::int64_t{random.between(-1000, 1000)});
                        break;
                    case 2:
                        values.emplace_back(random.between(-1000, 1000) / 8.0);
                        break;
                    default:
                        values.emplace_back(random_text(random));
                }
                texts.push_back(harmless_text(values.back()));
            }
        }
        REQUIRE(rows_of(csv_text(table)) == expected);

        const auto json = nlohmann::ordered_json::parse(json_text(table));
        REQUIRE(json.is_array());
        REQUIRE(json.size() == table.rows.size());
        for (std::size_t row = 0; row < json.size(); ++row) {
            REQUIRE(json[row].size() == table.columns.size());
            std::size_t column = 0;
            for (const auto& [key, value] : json[row].items()) {
                const Value& original = table.rows[row][column];
                if (std::holds_alternative<std::monostate>(original)) CHECK(value.is_null());
                if (std::holds_alternative<std::int64_t>(original)) {
                    CHECK(value.is_number_integer());
                    CHECK(value.get<std::int64_t>() == std::get<std::int64_t>(original));
                }
                if (std::holds_alternative<double>(original)) {
                    CHECK(value.get<double>() == std::get<double>(original));
                }
                ++column;
            }
        }
    }
}

}  // namespace metabuffer::exploration
