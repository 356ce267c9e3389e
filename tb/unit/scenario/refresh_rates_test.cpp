#include "support/scenarios.h"
#include "unit/scenario/scenario_fixture.h"

namespace metabuffer::test {
namespace {

// The displays' mode has 96 x 23 clocks, the links' one 96 x 24.

TEST_CASE("refresh rates: the displays' clock by how often they are to be refreshed") {
    const ScenarioFixture fixture;
    const Scenario scenario = fixture.parse(fixture.minimal("clocks: {dvi_out_refresh_hz: 60}\n"));
    CHECK(scenario.clocks.dvi_out_mhz == Approx(60.0 * 96 * 23 / 1e6));
    CHECK(scenario.clocks.dvi_in_mhz == 100.0);
    // Whatever order the keys have, and however large an override makes the displays.
    CHECK(fixture.parse(fixture.minimal(), {"clocks.dvi_out_refresh_hz=60", "displays.width=20"})
              .clocks.dvi_out_mhz == Approx(60.0 * 100 * 23 / 1e6));
}

TEST_CASE("refresh rates: the links' clock by the mode of the images") {
    const ScenarioFixture fixture;
    const Scenario scenario = fixture.parse(fixture.minimal("clocks: {dvi_in_refresh_hz: 120}\n"));
    CHECK(scenario.clocks.dvi_in_mhz == Approx(120.0 * 96 * 24 / 1e6));
    CHECK(scenario.clocks.dvi_out_mhz == 100.0);
    write_black(fixture.directory() / "other.exr", 16, 9);
    const std::string two = fixture.minimal("clocks: {dvi_in_refresh_hz: 120}\n") +
                            "  - frames:\n      - {image: other.exr, viewport: {x: 0, y: 0}}\n";
    CHECK(fixture.error(two) ==
          "test.yaml:1: clocks.dvi_in_refresh_hz: needs images of one size, and 'renderer_2' and "
          "'renderer_1' differ; use dvi_in_mhz: 0.288, with which each link has 120 frames a second or more");
    // The larger image's mode has 96 x 25 clocks.
    const Scenario at_clock =
        fixture.parse(fixture.minimal("clocks: {dvi_in_mhz: 0.288}\n") + two.substr(two.rfind("  - frames")));
    CHECK(0.288 == Approx(mhz_of_refresh(120.0, at_clock.renderers[1].timing())));
    CHECK(0.288 > mhz_of_refresh(120.0, at_clock.renderers[0].timing()));
    CHECK(fixture.error(fixture.minimal("clocks: {dvi_in_refresh_hz: 1e8}\n"))
              .rfind("test.yaml:1: clocks.dvi_in_refresh_hz: 1e+08 frames of 2304 clocks need 230400 MHz; "
                     "use 0.435 to 4340277.777",
                     0) == 0);
    for (const char* const accepted : {"0.435", "4340277.777"}) {
        CHECK(fixture.error(fixture.minimal(std::string("clocks: {dvi_in_refresh_hz: ") + accepted + "}\n"))
                  .empty());
    }
    for (const char* const refused : {"0.434", "4340277.778"}) {
        CHECK_FALSE(
            fixture.error(fixture.minimal(std::string("clocks: {dvi_in_refresh_hz: ") + refused + "}\n"))
                .empty());
    }
}

TEST_CASE(
    "refresh rates: one of clock and rate is given, or both that agree, and a reset is long enough for it") {
    const ScenarioFixture fixture;
    CHECK(fixture.error(fixture.minimal("clocks: {dvi_out_refresh_hz: 1000, dvi_out_mhz: 2.208}\n")).empty());
    // A billionth of it may be lost in writing it down.
    CHECK(fixture.error(fixture.minimal("clocks: {dvi_out_refresh_hz: 1000, dvi_out_mhz: 2.208000002}\n"))
              .empty());
    CHECK_FALSE(
        fixture.error(fixture.minimal("clocks: {dvi_out_refresh_hz: 1000, dvi_out_mhz: 2.208000003}\n"))
            .empty());
    CHECK(fixture.error(fixture.minimal("clocks: {dvi_out_refresh_hz: 1000, dvi_out_mhz: 2.2}\n")) ==
          "test.yaml:1: clocks.dvi_out_mhz: 2.2 is not what dvi_out_refresh_hz needs, 2.208; use one of the "
          "two");
    CHECK(fixture.error(fixture.minimal("clocks: {dvi_in_refresh_hz: 1000, dvi_in_mhz: 2.304}\n")).empty());
    CHECK(fixture.error(fixture.minimal("clocks: {dvi_in_refresh_hz: 1000, dvi_in_mhz: 2}\n")) ==
          "test.yaml:1: clocks.dvi_in_mhz: 2 is not what dvi_in_refresh_hz needs, 2.304; use one of the two");
    const std::string text = fixture.minimal("clocks: {core_mhz: 100, dvi_in_refresh_hz: 1000}\n") +
                             "faults: [{kind: reset, from_cycle: 500, cycles: 80}]\n";
    CHECK(fixture.error(text).find(
              "faults[0].cycles: 80 core cycles are less than two of the slowest clock; use 87") !=
          std::string::npos);
}

}  // namespace
}  // namespace metabuffer::test
