#include "tools/exploration/sweep_plan.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "support/random_seed.h"
#include "tools/exploration/axis_values.h"
#include "unit/tools/exploration/sweep_fixture.h"

namespace metabuffer::test {
namespace {

using namespace exploration;
using Texts = std::vector<std::string>;

Texts parsed(const std::string& text) { return parse_values(text, "--over"); }

std::string values_error(const std::string& text) {
    return input_error_of([&] { parse_values(text, "--over"); });
}

SweepDescription description_in(const SweepFixture& fixture, std::vector<Axis> axes) {
    SweepDescription description;
    description.scenario = fixture.directory() / "case.yaml";
    description.axes = std::move(axes);
    return description;
}

std::string plan_error(const SweepDescription& description) {
    return input_error_of([&] { make_plan(description); });
}

}  // namespace

TEST_CASE("values: lists and ranges of a command line") {
    CHECK(parsed("32,64,128") == Texts{"32", "64", "128"});
    CHECK(parsed("irsa, edf") == Texts{"irsa", "edf"});
    CHECK(parsed("[1, 2, 3],[0,0,0]") == Texts{"[1, 2, 3]", "[0, 0, 0]"});
    CHECK(parsed("{x: 1, y: 2}") == Texts{"{x: 1, y: 2}"});
    CHECK(parsed("case-1.yaml,../b/case-2.yaml") == Texts{"case-1.yaml", "../b/case-2.yaml"});
    CHECK(parsed("33.5,1e3,-7") == Texts{"33.5", "1e3", "-7"});
    CHECK(parsed("'1..5'") == Texts{"1..5"});
    CHECK(parsed("64..1024*2") == Texts{"64", "128", "256", "512", "1024"});
    CHECK(parsed("64..1023*2") == Texts{"64", "128", "256", "512"});
    CHECK(parsed("16..64+16") == Texts{"16", "32", "48", "64"});
    CHECK(parsed("16..63+16") == Texts{"16", "32", "48"});
    CHECK(parsed("-2..2") == Texts{"-2", "-1", "0", "1", "2"});
    CHECK(parsed("-100..-50+25") == Texts{"-100", "-75", "-50"});
    CHECK(parsed("7..7") == Texts{"7"});
    CHECK(parsed("1,4..8*2,20..30+5,99") == Texts{"1", "4", "8", "20", "25", "30", "99"});
    // Decimals as they were meant, the end included.
    CHECK(parsed("0.1..0.5+0.1") == Texts{"0.1", "0.2", "0.3", "0.4", "0.5"});
    CHECK(parsed("100..150+12.5") == Texts{"100", "112.5", "125", "137.5", "150"});
    CHECK(parsed("0.5..4.5*3") == Texts{"0.5", "1.5", "4.5"});
    // Whole ends keep a factor's values whole, each there once.
    CHECK(parsed("1..10*1.5") == Texts{"1", "2", "3", "5", "8"});
    CHECK(parsed("64..500*1.5") == Texts{"64", "96", "144", "216", "324", "486"});
    check_refusals(values_error)({
        {"", "--over: has no values; use some, like 32,64,128 or 64..4096*2"},
        {"32,,64", "--over: ..."},
        {"32,~", "--over: '32,~' has an empty value; use values with one comma between two"},
        {"[32", "--over: not valid YAML: ..."},
        {"1],[2", "--over: ..."},
    });
    const std::string use = "is not a range; use FROM..TO, FROM..TO+STEP or FROM..TO*FACTOR";
    for (const std::string wrong :
         {"64..", "64..x", "64..128*", "64..128*x", "64..128+", "1..2..3", "1..1e999", "1..5-1"}) {
        CHECK(values_error(wrong) == "--over: '" + wrong + "' " + use);
    }
    check_refusals(values_error)({
        {"64..32*2", "--over: 64..32*2: from 64 is above to 32; use from at most to"},
        {"1..9*1", "--over: 1..9*1: factor 1 goes nowhere; use a factor above 1"},
        {"1..9+0", "--over: 1..9+0: step 0 goes nowhere; use a step above 0"},
        {"1..9+-1", "--over: 1..9+-1: step -1 goes nowhere; use a step above 0"},
        {"0..9*2", "--over: 0..9*2: from 0 does not go with a factor; use from above 0, or a step"},
        {"1..1000001", "--over: 1..1000001: makes 1000001 values; use at most 1000000"},
        {"1..1000000,7", "--over: has more than 1000000 values; use fewer"},
    });
    CHECK(parsed("1..1000000").size() == 1'000'000);
}

TEST_CASE("values: random ranges hold what a plain loop makes") {
    const std::uint64_t seed = random_seed(21);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    for (int i = 0; i < 500; ++i) {
        const int from = random.between(-50, 50);
        const int to = from + random.between(0, 200);
        const int step = random.between(1, 30);
        Texts expected;
        for (int value = from; value <= to; value += step) expected.push_back(std::to_string(value));
        CHECK(parsed(std::to_string(from) + ".." + std::to_string(to) + "+" + std::to_string(step)) ==
              expected);
        const int first = random.between(1, 50);
        const int factor = random.between(2, 5);
        expected.clear();
        for (std::int64_t value = first; value <= 1'000'000; value *= factor) {
            expected.push_back(std::to_string(value));
        }
        CHECK(parsed(std::to_string(first) + "..1000000*" + std::to_string(factor)) == expected);
    }
}

TEST_CASE("random values: the same for the same seed on every computer") {
    RandomAxis random;
    random.from = {0, true};
    random.to = {9, true};
    random.count = 10;
    random.seed = 5489;
    // The first outputs of std::mt19937_64 for this seed are in the standard's reference: 14514284786278117030,
    // 4620546740167642908, 13109570281517897720, 17462938647148434322, 355488278567739596.
    Texts first = values_of(random);
    first.resize(5);
    CHECK(first == Texts{"0", "8", "0", "2", "6"});
    random.from = {-100, true};
    random.to = {220, true};
    random.count = 10'000;
    const Texts values = values_of(random);
    CHECK(values == values_of(random));
    std::map<std::string, int> counts;
    for (const std::string& value : values) ++counts[value];
    CHECK(counts.size() == 321);  // 31 of each on average: that one is missing is next to impossible
    CHECK(counts.count("-100") == 1);
    CHECK(counts.count("220") == 1);
    random.seed = 8;
    CHECK(values != values_of(random));
}

TEST_CASE(
    "random values: as many as asked for in a range, different ones if asked for, decimals for decimal "
    "ends") {
    for (const std::int64_t count : {1, 50, 160, 161, 300, 321}) {
        RandomAxis random;
        random.from = {-100, true};
        random.to = {220, true};
        random.count = count;
        random.seed = 3;
        random.distinct = true;
        REQUIRE_FALSE(problem_of(random).has_value());
        const Texts values = values_of(random);
        CHECK(values.size() == static_cast<std::size_t>(count));
        CHECK(std::set<std::string>(values.begin(), values.end()).size() == values.size());
        for (const std::string& value : values) {
            const int number = std::stoi(value);
            CHECK((number >= -100 && number <= 220));
        }
        random.count = 322;
        CHECK(problem_of(random) ==
              "has 321 numbers to draw 322 different ones from; use a smaller count or a wider range");
    }
    RandomAxis random;
    random.from = {1.5, false};
    random.to = {2, true};
    random.count = 100;
    random.distinct = true;
    REQUIRE_FALSE(problem_of(random).has_value());
    std::set<std::string> values;
    for (const std::string& value : values_of(random)) {
        values.insert(value);
        CHECK((std::stod(value) >= 1.5 && std::stod(value) <= 2.0));
        CHECK(value.size() <= 14);
    }
    CHECK(values.size() == 100);
    random.to = {1.5, false};
    CHECK(problem_of(random) ==
          "from 1.5 to 1.5 is too narrow for 100 different numbers; use a smaller count or a wider range");
}

TEST_CASE("plan: the axes multiplied out with the last one fastest") {
    const SweepFixture fixture;
    const SweepPlan plan = make_plan(description_in(
        fixture, {{{"bus.width_bits"}, {{"32", "64"}}, {}},
                  {{"bus.burst_pixels", "composer.ready_space_pixels"}, {{"8", "16"}, {"9", "17"}}, {}},
                  {{"bus.arbitration"}, {{"irsa", "edf"}}, {}}}));
    CHECK(point_texts(plan) ==
          Texts{"bus.width_bits=32 bus.burst_pixels=8 composer.ready_space_pixels=9 bus.arbitration=irsa",
                "bus.width_bits=32 bus.burst_pixels=8 composer.ready_space_pixels=9 bus.arbitration=edf",
                "bus.width_bits=32 bus.burst_pixels=16 composer.ready_space_pixels=17 bus.arbitration=irsa",
                "bus.width_bits=32 bus.burst_pixels=16 composer.ready_space_pixels=17 bus.arbitration=edf",
                "bus.width_bits=64 bus.burst_pixels=8 composer.ready_space_pixels=9 bus.arbitration=irsa",
                "bus.width_bits=64 bus.burst_pixels=8 composer.ready_space_pixels=9 bus.arbitration=edf",
                "bus.width_bits=64 bus.burst_pixels=16 composer.ready_space_pixels=17 bus.arbitration=irsa",
                "bus.width_bits=64 bus.burst_pixels=16 composer.ready_space_pixels=17 bus.arbitration=edf"});
    CHECK(plan.keys ==
          Texts{"bus.width_bits", "bus.burst_pixels", "composer.ready_space_pixels", "bus.arbitration"});
    CHECK(plan.points.filtered() == 0);
}

TEST_CASE("plan: no axis is one point") {
    const SweepFixture fixture;
    const SweepPlan plan = make_plan(description_in(fixture, {}));
    REQUIRE(plan.points.size() == 1);
    CHECK(points_of(plan)[0].settings.empty());
    CHECK(plan.keys.empty());
}

TEST_CASE("plan: random axes multiply as plain loops do and filters take away what they should") {
    const SweepFixture fixture;
    const std::uint64_t seed = random_seed(22);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    const Texts keys{"bus.burst_pixels", "composer.buffer_pixels", "memory.page_words",
                     "renderers.0.frames.0.viewport.x"};
    for (int round = 0; round < 100; ++round) {
        std::vector<Axis> axes;
        std::vector<Texts> expected{{}};  // settings' texts of each point
        for (int i = 0; i < random.between(1, 4); ++i) {
            const int count = random.between(1, 5);
            Axis axis{{keys[static_cast<std::size_t>(i)]}, {{}}, {}};
            for (int n = 0; n < count; ++n)
                axis.values[0].push_back(std::to_string(random.between(0, 9) * 10 + n));
            std::vector<Texts> multiplied;
            for (const Texts& before : expected) {
                for (const std::string& value : axis.values[0]) {
                    multiplied.push_back(before);
                    multiplied.back().push_back(value);
                }
            }
            expected = multiplied;
            axes.push_back(axis);
        }
        SweepDescription description = description_in(fixture, axes);
        const int least = random.between(0, 60);
        description.filter = "bus.burst_pixels >= " + std::to_string(least);
        std::vector<Texts> kept;
        for (const Texts& point : expected) {
            if (std::stoi(point[0]) >= least) kept.push_back(point);
        }
        if (kept.empty()) {
            CHECK(plan_error(description) == "'" + description.filter + "' lets none of the " +
                                                 std::to_string(expected.size()) +
                                                 " points through; use a wider filter");
            continue;
        }
        const SweepPlan plan = make_plan(description);
        CHECK(plan.points.filtered() == expected.size() - kept.size());
        REQUIRE(plan.points.size() == kept.size());
        const std::vector<Point> points = points_of(plan);
        for (std::size_t i = 0; i < kept.size(); ++i) {
            REQUIRE(points[i].settings.size() == kept[i].size());
            for (std::size_t k = 0; k < kept[i].size(); ++k) {
                CHECK(points[i].settings[k] == Setting{keys[k], kept[i][k]});
            }
        }
    }
}

TEST_CASE("plan: shards are parts of the sweep, each point in one of them, whatever their number") {
    const SweepFixture fixture;
    const std::uint64_t seed = random_seed(23);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    const Texts keys{"bus.burst_pixels", "composer.buffer_pixels", "memory.page_words"};
    for (int round = 0; round < 40; ++round) {
        std::vector<Axis> axes;
        for (const std::string& key : keys) {
            Axis axis{{key}, {{}}, {""}};
            const int count = random.between(1, 9);
            for (int n = 1; n <= count; ++n) axis.values[0].push_back(std::to_string(n));
            axes.push_back(axis);
        }
        SweepDescription description = description_in(fixture, axes);
        // Half of them with a filter that depends on the axis that changes fastest.
        const bool filtered = random.between(0, 1) == 1;
        if (filtered) description.filter = "memory.page_words % 2 = 1";
        const SweepPlan whole = make_plan(description);
        const std::vector<std::string> expected = point_texts(whole);
        const int count = random.between(1, 12);
        CAPTURE(round, count, expected.size(), filtered);
        std::multiset<std::string> together;
        std::size_t left_out = 0;
        for (int index = 0; index < count; ++index) {
            const SweepPlan part = make_plan(description, {index, count});
            CHECK(part.digest == whole.digest);
            CHECK(part.shard == Shard{index, count});
            const std::vector<std::string> points = point_texts(part);
            CHECK(points.size() == part.points.size());
            together.insert(points.begin(), points.end());
            left_out += part.points.filtered();
            // In the order of the sweep.
            std::size_t found_at = 0;
            for (const std::string& point : points) {
                found_at = std::find(expected.begin() + static_cast<std::ptrdiff_t>(found_at), expected.end(),
                                     point) -
                           expected.begin();
                REQUIRE(found_at < expected.size());
            }
            if (!filtered) CHECK(points.size() - expected.size() / count <= 1);
        }
        CHECK(together == std::multiset<std::string>(expected.begin(), expected.end()));
        CHECK(left_out == whole.points.filtered());
    }
}

TEST_CASE("plan: no shard is in step with an axis") {
    // Axes as long as the number of shards, twice as long, and of two values, which plain counting would distribute
    // badly.
    for (const std::int64_t count : {2, 3, 5, 8, 15, 16}) {
        for (const std::int64_t period : {std::int64_t{2}, count, 2 * count}) {
            constexpr std::int64_t kRows = 2000;
            for (std::int64_t index = 0; index < count; ++index) {
                std::vector<std::int64_t> seen(static_cast<std::size_t>(period));
                for (std::int64_t row = 0; row < kRows; ++row) {
                    ++seen[static_cast<std::size_t>(Shard{index, count}.number_in(row) % period)];
                }
                CAPTURE(count, period, index);
                // Five standard deviations of a random distribution.
                const double mean = static_cast<double>(kRows) / static_cast<double>(period);
                for (const std::int64_t times : seen) {
                    CHECK(std::abs(static_cast<double>(times) - mean) < 5.0 * std::sqrt(mean));
                }
            }
        }
    }
}

TEST_CASE("plan: axes or a filter that differ make another digest, and points have a canonical text") {
    const SweepFixture fixture;
    SweepDescription description = description_in(fixture, {Axis{{"bus.width_bits"}, {{"32", "64"}}, {""}}});
    const std::string digest = make_plan(description).digest;
    description.name = "other";
    description.axes[0].where = {"other.yaml:3: axes[0]"};
    CHECK(make_plan(description).digest == digest);
    description.filter = "bus.width_bits >= 32";
    CHECK(make_plan(description).digest != digest);
    description.filter = "";
    description.axes[0].values[0] = {"32", "128"};
    CHECK(make_plan(description).digest != digest);
    CHECK(canonical_text({}) == "{}");
    CHECK(canonical_text({{"scenario", "case \"1\".yaml"}, {"bus.width_bits", "64"}, {"a", ""}}) ==
          R"({"scenario":"case \"1\".yaml","bus.width_bits":"64","a":""})");
    CHECK(canonical_text({{"b", "1"}, {"a", "2"}}) != canonical_text({{"a", "2"}, {"b", "1"}}));
    CHECK_NOTHROW(canonical_text({{"scenario", "\xFF"}}));
}

TEST_CASE("plan: a filter sees settings and defaults and fixed values and keys inside of lists") {
    const SweepFixture fixture;
    SweepDescription description =
        description_in(fixture, {{{"bus.burst_pixels"}, {{"16", "48"}}, {}},
                                 {{"renderers.0.frames.0.viewport.x"}, {{"-5", "5"}}, {}}});
    const auto points = [&](const std::string& filter) {
        description.filter = filter;
        return point_texts(make_plan(description)).size();
    };
    CHECK(points("bus.burst_pixels > 16") == 2);
    CHECK(points("renderers.0.frames.0.viewport.x < 0") == 2);
    CHECK(points("composer.ready_space_pixels = bus.burst_pixels") == 4);  // the default follows
    CHECK(points("frames = 2 and bus.width_bits = 64 and bus.arbitration = 'irsa'") == 4);
    CHECK(points("name = 'case' and bus.burst_pixels = 16") == 2);
    description.fixed = {{"composer.ready_space_pixels", "20"}};
    CHECK(points("composer.ready_space_pixels >= bus.burst_pixels") == 2);
}

TEST_CASE("plan: points that make no scenario are kept for their run to report") {
    const SweepFixture fixture;
    SweepDescription description = description_in(
        fixture, {{{"bus.width_bits"}, {{"48", "64"}}, {}}, {{"renderers.7.name"}, {{"a"}}, {}}});
    description.filter = "composer.buffer_pixels < 0";
    const SweepPlan plan = make_plan(description);
    CHECK(plan.points.size() == 2);  // neither has a renderer 7
    description.axes.pop_back();
    CHECK(point_texts(make_plan(description)) == Texts{"bus.width_bits=48"});
}

TEST_CASE("plan: where a point's scenario and overrides come from") {
    const SweepFixture fixture;
    SweepDescription description = description_in(
        fixture, {{{kScenarioAxis}, {{"case.yaml", "'wide.yaml'"}}, {}}, {{"frames"}, {{"1"}}, {}}});
    description.scenario.clear();
    description.base = fixture.directory().path();
    description.fixed = {{"bus.burst_pixels", "8"}};
    description.filter = "bus.width_bits = 128";
    const SweepPlan plan = make_plan(description);
    CHECK(point_texts(plan) == Texts{"scenario='wide.yaml' frames=1"});
    CHECK(plan.scenario_file(points_of(plan)[0].settings) == fixture.directory() / "wide.yaml");
    const std::vector<ScenarioOverride> overrides = plan.overrides_of(points_of(plan)[0].settings);
    REQUIRE(overrides.size() == 2);
    CHECK(overrides[0].path == "bus.burst_pixels");
    CHECK(overrides[1].path == "frames");
    description.filter = "scenario = 'case.yaml'";
    CHECK(make_plan(description).points.size() == 1);
    CHECK(make_plan(description_in(fixture, {})).scenario_file({}) == fixture.directory() / "case.yaml");
}

TEST_CASE("plan: keys that undo each other") {
    const SweepFixture fixture;
    const auto error = [&](const Texts& keys) {
        std::vector<Axis> axes;
        for (const std::string& key : keys) axes.push_back({{key}, {{"1"}}, {"--over " + key}});
        return plan_error(description_in(fixture, axes));
    };
    check_refusals<Texts>(error)({
        {{"bus.width_bits", "frames", "bus.width_bits"},
         "--over bus.width_bits: bus.width_bits is an axis already; use each key once"},
        {{"renderers.0.name", "renderers[0].name"},
         "--over renderers[0].name: renderers[0].name is an axis already; use each key once"},
        {{"bus.width_bits", "bus"},
         "--over bus: bus replaces all of it, bus.width_bits too, which is an axis; use the keys inside of "
         "bus"},
        {{"bus", "bus.width_bits"}, ""},
        {{"frames", "bus.burst_pixels"}, ""},
        {{"bus.widht_bits"},
         "--over bus.widht_bits: bus.widht_bits: is not a known key; the nearest is bus.width_bits"},
    });

    SweepDescription description = description_in(fixture, {{{"bus.width_bits"}, {{"32"}}, {}}});
    description.fixed = {{"bus.width_bits", "64"}};
    CHECK(plan_error(description) ==
          "bus.width_bits is set to one value for every point already; use each key once");
    description.fixed = {{"bus", "{burst_pixels: 8}"}};
    CHECK(plan_error(description).empty());
    description.fixed = {{"bus.widht", "64"}};
    CHECK(plan_error(description) ==
          "--set bus.widht=64: bus.widht: is not a known key; the nearest is bus.width_bits");
    description.fixed.clear();
    description.search = describe_search("bus.width_bits", {}, {}, "--minimize");
    CHECK(plan_error(description) == "--minimize: bus.width_bits is an axis already; use each key once");
    description.search = describe_search("composer.buffer_pixels", {}, {}, "--minimize");
    CHECK(plan_error(description).empty());
    description.search->goal = "starved_pixel = 0";
    CHECK(plan_error(description).find("starved_pixels") != std::string::npos);
    description.search->goal = "starved_pixels <= bus.width_bits + composer.buffer_pixels";
    CHECK(plan_error(description).empty());
}

TEST_CASE("plan: invalid axes and too many points") {
    const SweepFixture fixture;
    const auto error = [&](const std::vector<Axis>& axes) {
        return plan_error(description_in(fixture, axes));
    };
    check_refusals<std::vector<Axis>>(error)({
        {{{{}, {}, {}}}, "the axis has no keys; use at least one, with values"},
        {{{{"frames"}, {{}}, {}}}, "frames has no values; use at least one"},
        {{{{"frames", "name"}, {{"1", "2"}, {"a"}}, {"x", "y"}}},
         "y: name has 1 values and frames has 2; use as many for each of the keys that go together"},
        {{{{"frames"}, {{"1", "2", "1"}}, {}}}, "frames has 1 twice, as values 1 and 3; use each once"},
        {{{{"frames", "name"}, {{"1", "2", "1"}, {"a", "b", "a"}}, {}}},
         "frames and name has 1 and a twice, as values 1 and 3; use each once"},
        {{{{"frames", "name"}, {{"1", "2", "1"}, {"a", "b", "c"}}, {}}}, ""},
    });
    const Texts thousand = parsed("1..1000");
    const Texts two = parsed("1..2");
    std::vector<Axis> axes{{{"frames"}, {thousand}, {}},
                           {{"bus.burst_pixels"}, {thousand}, {}},
                           {{"composer.buffer_pixels"}, {two}, {}}};
    CHECK(error(axes) == "the axes make 2000000 points or more; use at most 1000000");

    SweepDescription description = description_in(fixture, {});
    description.scenario.clear();
    CHECK(plan_error(description) == "there is no scenario; use the key scenario, or an axis of that name");
    description.axes = {{{kScenarioAxis}, {{"case.yaml"}}, {}}};
    description.scenario = fixture.directory() / "case.yaml";
    CHECK(plan_error(description) ==
          "an axis names the scenarios, and the sweep names one as well; use one of the two");
    description.axes.clear();
    description.scenario = fixture.directory() / "none.yaml";
    CHECK(plan_error(description).find("none.yaml: cannot be read: No such file") != std::string::npos);
}

TEST_CASE("search: a key is searched by whole numbers or steps over what it accepts, for the default goal") {
    const SearchDescription buffer = describe_search("composer.buffer_pixels", {}, {}, "--minimize");
    CHECK(buffer.key == "composer.buffer_pixels");
    CHECK(buffer.from == 1);
    CHECK(buffer.to == 16777216);
    CHECK(buffer.candidates.empty());
    CHECK(buffer.goal == default_goal());
    CHECK(buffer.checks == 16);
    const SearchDescription part = describe_search("composer.buffer_pixels", 16, 4096, "--minimize");
    CHECK(part.from == 16);
    CHECK(part.to == 4096);
    using Candidates = std::vector<std::int64_t>;
    CHECK(describe_search("bus.width_bits", {}, {}, "").candidates == Candidates{16, 32, 64, 128, 256, 512});
    CHECK(describe_search("bus.width_bits", 33, 256, "").candidates == Candidates{64, 128, 256});
    CHECK(describe_search("displays.supersample", {}, {}, "").candidates == Candidates{1, 2, 4});
    CHECK(describe_search("renderers.0.frames.2.viewport.x", -5, 5, "").from == -5);
    CHECK(describe_search("renderers[0].copies", {}, {}, "").to == 65536);
    const SearchDescription clock = describe_search("clocks.core_mhz", 50, 100.25, "--minimize", 0.5);
    CHECK(clock.step == 0.5);
    CHECK(clock.from == 100);
    CHECK(clock.to == 200);
    CHECK(clock.text_of(133) == "66.5");
    CHECK(clock.number_of(133) == 66.5);
    const SearchDescription usual = describe_search("clocks.core_mhz", {}, {}, "--minimize");
    CHECK(usual.step == 0.1);
    CHECK(usual.from == 1);  // 0.001 is not a multiple
    CHECK(usual.to == 100'000);
    CHECK(usual.text_of(3) == "0.3");  // and not 0.30000000000000004
    CHECK(usual.text_of(666) == "66.6");
    CHECK(describe_search("composer.buffer_pixels", {}, {}, "").text_of(64) == "64");
    CHECK(describe_search("composer.buffer_pixels", {}, {}, "").number_of(64) == 64.0);
    const auto error = [](std::optional<double> from, std::optional<double> to, double step) {
        return input_error_of([&] { describe_search("clocks.core_mhz", from, to, "where", step); });
    };
    CHECK(error(10.1, 10.4, 0.5) ==
          "where: clocks.core_mhz: no multiple of 0.5 lies from 10.1 to 10.4; use a smaller step or a wider "
          "range");
    CHECK(error(1.0, 2.0, 0.0) == "where: clocks.core_mhz: a step of 0 goes nowhere; use one above 0");
    CHECK(error(1.0, 20'000.0, 1.0) == "where: clocks.core_mhz: 20000 is out of range; use 0.001 to 10000");
    CHECK(input_error_of([&] { describe_search("composer.buffer_pixels", {}, {}, "where", 0.5); }) ==
          "where: composer.buffer_pixels: takes whole numbers, and no step; leave it out");
    CHECK(input_error_of([&] { describe_search("composer.buffer_pixels", 1.5, {}, "where"); }) ==
          "where: composer.buffer_pixels: 1.5 is not a whole number; use one");
    const SweepFixture fixture;
    SweepDescription description = description_in(fixture, {});
    description.search = describe_search("composer.buffer_pixels", {}, {}, "");
    CHECK(make_plan(description).search->goal == default_goal());
}

TEST_CASE("search: only keys that take numbers and what they take") {
    const auto error = [](const std::string& key, std::optional<double> from, std::optional<double> to) {
        return input_error_of([&] { describe_search(key, from, to, "--minimize"); });
    };
    for (const std::string key :
         {"bus.arbitration", "bus", "name", "scenario", "renderers", "renderers.0.frames.0.table.0.1"}) {
        CHECK(error(key, {}, {}) == "--minimize: " + key +
                                        " does not hold a number, and only those can be minimized; use a key "
                                        "like composer.buffer_pixels");
    }
    CHECK(error("composer.bufer_pixels", {}, {}) ==
          "--minimize: composer.bufer_pixels: is not a known key; the nearest is composer.buffer_pixels");
    CHECK(error("composer.buffer_pixels", 0, {}) ==
          "--minimize: composer.buffer_pixels: 0 is out of range; use 1 to 16777216");
    CHECK(error("composer.buffer_pixels", {}, 1 << 25) ==
          "--minimize: composer.buffer_pixels: 33554432 is out of range; use 1 to 16777216");
    CHECK(error("composer.buffer_pixels", 9, 8) ==
          "--minimize: composer.buffer_pixels: from 9 is above to 8; use from at most to");
    CHECK(error("bus.width_bits", 65, 127) ==
          "--minimize: bus.width_bits: none of its values is from 65 to 127; use a range that has one of 16, "
          "32, 64, 128, 256 and 512");
}

}  // namespace metabuffer::test
