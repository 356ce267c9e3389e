#include <catch2/catch.hpp>
#include <cstdint>
#include <string>

#include "random_scenario.h"
#include "scenario/scenario_loader.h"
#include "scenario/scenario_writer.h"
#include "support/scenario_difference.h"
#include "support/scratch_directory.h"

namespace metabuffer::test::scenario_files_test {

TEST_CASE("random scenarios survive being kept as files", "[system][random]") {
    const ScratchDirectory directory;
    for (std::uint64_t seed = 1; seed <= 600; ++seed) {
        INFO("seed " << seed);
        const Scenario scenario = random_level_scenario(seed);
        write_scenario(scenario, directory / std::to_string(seed));
        const Scenario loaded = load_scenario(directory / std::to_string(seed) / "scenario.yaml");
        CHECK(scenario_difference(scenario, loaded).empty());
    }
}

}  // namespace metabuffer::test::scenario_files_test
