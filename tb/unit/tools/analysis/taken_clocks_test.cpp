#include "tools/analysis/taken_clocks.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "formats/dvi_timing.h"
#include "scenario/derived_timing.h"
#include "support/random_seed.h"
#include "support/scenarios.h"

using namespace metabuffer;
using namespace metabuffer::analysis;

namespace {

/// A machine whose memory writes blocks of 16 of the link's words, at two words a clock.
Scenario shared_ports() {
    Scenario scenario = test::with_renderer(
        test::small_scenario(40, 20), test::renderer_of({PixelImage(40, 20)}, {{1, 0, 0, 40, 20, 0, 0, 1}}));
    scenario.clocks.core_mhz = 100.0;
    scenario.clocks.dvi_in_mhz = 50.0;
    scenario.memory.ports = MemoryPorts::kShared;
    scenario.memory.words_per_cycle = 2;
    scenario.memory.write_block_words = 16;
    scenario.memory.page_words = 512;
    scenario.memory.page_miss_cycles = 5;
    return scenario;
}

}  // namespace

TEST_CASE("a memory with nothing else to do takes no clocks", "[analysis]") {
    const TakenClocks taken = taken_clocks(test::small_scenario(40, 20), 0, true);
    CHECK(taken.share == 0.0);
    CHECK(taken.stretch() == 1.0);
    CHECK(taken.latency() == 0.0);
}

TEST_CASE("a refresh takes its clocks and those to open the page again", "[analysis]") {
    Scenario scenario = test::small_scenario(40, 20);
    scenario.memory.refresh_interval_cycles = 100;
    scenario.memory.refresh_cycles = 16;
    scenario.memory.page_miss_cycles = 6;
    scenario.memory.precharge_cycles = 2;
    const TakenClocks taken = taken_clocks(scenario, 0, true);
    CHECK(taken.share == Approx(0.20));
    // A whole refresh in a window of its own length.
    CHECK(taken.share * 20 + taken.once == Approx(20.0));
    // Two, at the ends of a window.
    CHECK(taken.share * 120 + taken.once == Approx(40.0));
    CHECK(taken.stretch() == Approx(1.25));
    // One that fell between two bursts costs the second one its page.
    CHECK(taken_clocks(scenario, 0, false).once == Approx(taken.once + 4));
}

TEST_CASE("a block of the link's words opens its page and closes the burst's", "[analysis]") {
    const Scenario scenario = shared_ports();
    CHECK(write_cycles(scenario.memory) == 5 + 8 + 5);
    const Interruption writes = link_writes(scenario, 0);
    // A line of 40 words in 120 clocks of the link, which are 240 of the core.
    CHECK(writes.per_cycle == Approx(40.0 / 240 / 16));
    CHECK(writes.share() == Approx(0.1875));
    // 800 words are 50 blocks on two pages.
    CHECK(least_write_cycles(scenario.memory, 800) == 2 * 5 + 50 * 8);
    CHECK(least_write_cycles(scenario.memory, 801) == 2 * 5 + 50 * 8 + 1);
}

TEST_CASE("no window has more blocks and refreshes than its share and once", "[analysis][random]") {
    const std::uint64_t seed = test::random_seed(31);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int round = 0; round < 20; ++round) {
        Scenario scenario = shared_ports();
        MemoryConfig& memory = scenario.memory;
        memory.write_block_words = 1 << random.between(2, 6);
        memory.words_per_cycle = random.between(1, 8);
        memory.page_miss_cycles = random.between(0, 9);
        scenario.clocks.dvi_in_mhz = random.between(10, 60);
        if (random.one_in(2)) {
            memory.refresh_cycles = random.between(1, 20);
            memory.refresh_interval_cycles =
                static_cast<int>(least_refresh_interval_cycles(memory)) + random.between(0, 200);
        }
        const TakenClocks taken = taken_clocks(scenario, 0, true);
        // The clocks that are taken, one by one: of refreshes from some phase on, and of blocks as the link fills them,
        // each as late as any phase allows or at once.
        constexpr std::int64_t kCycles = 6000;
        std::vector<double> clocks(kCycles + 1000, 0.0);
        const int phase = random.between(0, 1000);
        for (std::int64_t at = phase; memory.refreshes() && at < kCycles;
             at += memory.refresh_interval_cycles) {
            for (int i = 0; i < memory.refresh_cycles + memory.activate_cycles(); ++i)
                ++clocks[static_cast<std::size_t>(at + i)];
        }
        const DviTiming timing = scenario.renderers.front().timing();
        const double per_link_clock = scenario.clocks.core_mhz / scenario.clocks.dvi_in_mhz;
        const int waits =
            longest_write_delay_cycles(memory) - 3 - longest_write_cycles(memory, memory.write_block_words);
        std::int64_t words = 0;
        std::int64_t free_from = 0;
        for (std::int64_t edge = 0;; ++edge) {
            const auto ready = static_cast<std::int64_t>(static_cast<double>(edge) * per_link_clock) + 1;
            if (ready >= kCycles) break;
            if (edge % timing.line_clocks() >= 40) continue;
            if (++words % memory.write_block_words != 0) continue;
            const std::int64_t begin =
                std::max(free_from, ready + (random.one_in(2) ? random.between(0, waits) : 0));
            free_from = begin + static_cast<std::int64_t>(write_cycles(memory));
            for (std::int64_t at = begin; at < free_from; ++at) ++clocks[static_cast<std::size_t>(at)];
        }
        double worst = 0.0;
        for (std::size_t from = 0; from < kCycles; from += 7) {
            double sum = 0.0;
            for (std::size_t until = from; until < kCycles; ++until) {
                sum += clocks[until];
                const double most = taken.share * static_cast<double>(until - from + 1) + taken.once;
                worst = std::max(worst, sum - most);
            }
        }
        INFO("round " << round << ", share " << taken.share << ", once " << taken.once);
        CHECK(worst <= 1e-6);
    }
}
