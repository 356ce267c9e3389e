#include "tools/exploration/margin.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "support/images.h"
#include "support/scratch_directory.h"

namespace metabuffer::test {
namespace {

using exploration::MovedKey;

/// "key value: moved moved moved", a line for each.
std::string moves(const std::string& settings, const std::string& searched_key) {
    const ScratchDirectory scratch;
    const ScenarioTemplate scenario(
        "displays: {width: 8, height: 4}\n" + settings +
            "renderers: [{frames: [{image: view.png, z: 1, viewport: {x: 0, y: 0}}]}]\n",
        "margin.yaml", scratch.path());
    std::string lines;
    for (const MovedKey& key : exploration::moved_keys(scenario, {}, searched_key)) {
        lines += key.key + " " + key.value + ":";
        for (const std::string& moved : key.moved) lines += " " + moved;
        lines += "\n";
    }
    return lines;
}

TEST_CASE(
    "margin: times of the memory become longer, clocks move both ways, by 1, 2 and 4 or 0.1, 1 and 5 %") {
    CHECK(moves("clocks: {core_mhz: 100, dvi_in_mhz: 50}\n", "composer.buffer_pixels") ==
          "memory.page_miss_cycles 6: 7 8 10\n"
          "clocks.core_mhz 100: 99.9 99 95\n"
          "clocks.core_mhz 100: 100.1 101 105\n"
          "clocks.dvi_in_mhz 50: 49.95 49.5 47.5\n"
          "clocks.dvi_in_mhz 50: 50.05 50.5 52.5\n"
          "clocks.dvi_out_mhz 100: 99.9 99 95\n"
          "clocks.dvi_out_mhz 100: 100.1 101 105\n");
}

TEST_CASE("margin: what the scenario gives moves, and the key that is searched does not") {
    CHECK(moves("clocks: {dvi_in_refresh_hz: 60, dvi_out_refresh_hz: 50}\n"
                "memory: {banks: 4, precharge_cycles: 2, activate_cycles: 3, refresh_interval_cycles: 781, "
                "refresh_cycles: 10}\n",
                "clocks.core_mhz") ==
          "memory.activate_cycles 3: 4 5 7\n"
          "memory.refresh_cycles 10: 11 12 14\n"
          "memory.refresh_interval_cycles 781: 780 773 741\n"
          "clocks.dvi_in_refresh_hz 60: 59.94 59.4 57\n"
          "clocks.dvi_in_refresh_hz 60: 60.06 60.6 63\n"
          "clocks.dvi_out_refresh_hz 50: 49.95 49.5 47.5\n"
          "clocks.dvi_out_refresh_hz 50: 50.05 50.5 52.5\n");
    CHECK(moves("memory: {page_miss_cycles: 0}\n", "clocks.core_mhz").find("memory.") == std::string::npos);
}

}  // namespace
}  // namespace metabuffer::test
