#include "tools/exploration/value.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>

#include "support/random_seed.h"

namespace metabuffer::exploration {

TEST_CASE("value: a text or a setting that is a number in full is one") {
    CHECK(value_of("64") == Value(std::int64_t{64}));
    CHECK(value_of("-7") == Value(std::int64_t{-7}));
    CHECK(value_of("9223372036854775807") == Value(std::numeric_limits<std::int64_t>::max()));
    CHECK(value_of("33.5") == Value(33.5));
    CHECK(value_of("1e3") == Value(1000.0));
    CHECK(value_of("9223372036854775808") == Value(9223372036854775808.0));
    CHECK(value_of("") == Value());
    for (const std::string text : {"irsa", "64 ", " 64", "64bits", "0x10", "inf", "-inf", "nan", "-nan",
                                   "INF", "1e999", "1,2", "[1, 2]", "-", ".", "e5", "'64'"}) {
        CAPTURE(text);
        CHECK(value_of(text) == Value(text));
    }
    CHECK(value_of_setting("64") == Value(std::int64_t{64}));
    CHECK(value_of_setting("+64") == Value(std::int64_t{64}));
    CHECK(value_of_setting("'64'") == Value(std::string("64")));
    CHECK(value_of_setting("'it''s'") == Value(std::string("it's")));
    CHECK(value_of_setting("\"a b\"") == Value(std::string("a b")));
    CHECK(value_of_setting("{x: 1, y: 2}") == Value(std::string("{x: 1, y: 2}")));
    CHECK(value_of_setting("edf") == Value(std::string("edf")));
    CHECK(value_of_setting("") == Value());
}

TEST_CASE("value: texts of numbers read back the same") {
    const std::uint64_t seed = test::random_seed(1);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int n = 0; n < 2000; ++n) {
        const auto whole = static_cast<std::int64_t>(random.bits() >> random.between(0, 63));
        CHECK(value_of(text_of(Value(whole))) == Value(whole));
        const double number = static_cast<double>(whole) / 1024.0 + 1.0 / 4096.0;
        CHECK(std::stod(text_of(Value(number))) == number);
    }
    CHECK(text_of(Value()).empty());
    CHECK(text_of(Value(std::string("edf"))) == "edf");
    CHECK(text_of(Value(33.33)) == "33.33");
}

}  // namespace metabuffer::exploration
