#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>

#include "load_scenario.h"
#include "random_scenario.h"
#include "starvation_run.h"
#include "support/random_seed.h"
#include "tools/analysis/bandwidth_analysis.h"
#include "tools/analysis/buffer_bound.h"

// Every machine runs in a process of its own, which run_with_buffer starts; nothing is elaborated in this one.

namespace metabuffer::test::analysis_safety_test {

namespace {

constexpr int kQuickMachines = 200;
constexpr int kMachinesPerSlowCase = 1000;
constexpr int kSlowCases = 8;

/// Some table sends pixels of an apron that no raster pixel is mixed of. These may come after their release.
bool has_unused_pixels(const Scenario& scenario) {
    const DisplayConfig& displays = scenario.displays;
    for (const Renderer& renderer : scenario.renderers) {
        for (const RendererFrame& entry : renderer.frames) {
            for (const ViewportRow& row : entry.table) {
                const Segment segment(row, displays.raster_width_pixels(), displays.raster_height_pixels(),
                                      scenario.composer.smoothing);
                if (segment.has_unused_pixels()) return true;
            }
        }
    }
    return false;
}

/// A machine sized by the bound must not starve, nor must one that is a little larger, if the bound says so.
void check_machine(std::uint64_t seed) {
    const Scenario scenario = random_load_scenario(seed);
    const analysis::BufferBound bound(scenario);
    const std::optional<analysis::BufferBound::Result> found = bound.find();
    const std::int64_t pixels = found ? found->pixels : bound.whole_segment_pixels();
    INFO("METABUFFER_SEED=" << seed << " replays this machine alone");
    INFO(describe(scenario) << ", buffers of " << pixels << " pixels");
    REQUIRE(pixels <= bound.whole_segment_pixels());
    REQUIRE(bound.is_safe(pixels));
    for (const std::int64_t tried : {pixels, pixels + pixels / 16 + 1}) {
        if (tried > pixels && !bound.is_safe(tried)) continue;
        const Starvation starvation = run_with_buffer(scenario, static_cast<int>(tried));
        CHECK(starvation.starved_pixels == 0);
        if (!has_unused_pixels(scenario)) CHECK(starvation.late_pixels == 0);
        CHECK(starvation.rejected_for_buffer == 0);
        CHECK(starvation.watchdog_lines == 0);
        if (!starvation.none()) {
            FAIL_CHECK("renderer " << starvation.most_starved_renderer << ", display "
                                   << starvation.most_starved_display << " starved with " << tried
                                   << " pixels");
        }
    }
}

void check_machines(std::uint64_t first_seed, int count) {
    if (std::getenv("METABUFFER_SEED") != nullptr) {
        check_machine(random_seed(0));
        return;
    }
    for (int machine = 0; machine < count; ++machine)
        check_machine(first_seed + static_cast<std::uint64_t>(machine));
}

class SlowBatch final : public Catch::ITestInvoker {
  public:
    explicit SlowBatch(std::uint64_t first_seed) : first_seed_(first_seed) {}
    void invoke() const override { check_machines(first_seed_, kMachinesPerSlowCase); }

  private:
    std::uint64_t first_seed_;
};

bool register_slow_batches() {
    for (int batch = 0; batch < kSlowCases; ++batch) {
        const std::uint64_t first =
            kQuickMachines + 1 + static_cast<std::uint64_t>(batch) * kMachinesPerSlowCase;
        const std::string name = "machines sized by the bound do not starve of seeds " +
                                 std::to_string(first) + " to " +
                                 std::to_string(first + kMachinesPerSlowCase - 1);
        // Registers in its constructor, as the macro does for a function.
        const Catch::AutoReg registration(new SlowBatch(first), CATCH_INTERNAL_LINEINFO, Catch::StringRef(),
                                          Catch::NameAndTags{name, "[system][analysis][random][slow]"});
    }
    return true;
}

const bool kRegistered = register_slow_batches();

}  // namespace

TEST_CASE("machines sized by the bound do not starve of seeds 1 to 200",
          "[system][analysis][random][repeat]") {
    REQUIRE(kRegistered);
    check_machines(1, kQuickMachines);
}

TEST_CASE("half of the buffer is too small for most machines of each kind", "[system][analysis][random]") {
    struct Kind {
        int machines = 0;
        int close = 0;
    };
    std::map<std::string, Kind> kinds;
    for (std::uint64_t seed = 1; seed <= kQuickMachines; ++seed) {
        const Scenario scenario = random_load_scenario(seed);
        if (scenario.composer.ready_space_pixels < scenario.bus.burst_pixels) continue;
        const analysis::BufferBound bound(scenario);
        const std::optional<analysis::BufferBound::Result> found = bound.find();
        REQUIRE(found.has_value());
        const std::int64_t half = found->pixels / 2;
        const bool close =
            half < bound.smallest_legal_pixels() || !run_with_buffer(scenario, static_cast<int>(half)).none();
        for (const std::string& name : machine_kinds(scenario)) {
            ++kinds[name].machines;
            kinds[name].close += close ? 1 : 0;
        }
    }
    CHECK(kinds.size() == 5);
    for (const auto& [name, kind] : kinds) {
        INFO(name << ": " << kind.close << " of " << kind.machines);
        CHECK(kind.machines >= kQuickMachines / 10);
        CHECK(kind.close > kind.machines / 2);
    }
}

TEST_CASE("machines that the bound is tested on have loads below and above what their buses carry",
          "[system][analysis][random]") {
    int below = 0;
    int about = 0;
    int above = 0;
    int decided_by_legal_size = 0;
    for (int seed = 1; seed <= kQuickMachines; ++seed) {
        const Scenario scenario = random_load_scenario(static_cast<std::uint64_t>(seed));
        const analysis::Analysis analysis = analysis::analyze(scenario);
        double load = 0.0;
        for (const analysis::TableAnalysis& table : analysis.tables) {
            load = std::max(load, table.load);
        }
        ++(load < 0.8 ? below : load <= 1.0 ? about : above);
        decided_by_legal_size += analysis.safe_buffer_pixels == analysis.least_buffer_pixels ? 1 : 0;
    }
    CHECK(below > kQuickMachines / 5);
    CHECK(about > kQuickMachines / 20);
    CHECK(above > kQuickMachines / 5);
    // Where the bound is no more than the smallest legal size, the rules are not tested.
    CHECK(decided_by_legal_size < kQuickMachines / 2);
}

TEST_CASE(
    "a machine with its simulated minimum less a pixel starves although a bound with less would be smaller",
    "[system][analysis]") {
    // The trial itself must be able to see starvation: a buffer far below the bound of an overloaded bus starves.
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        const Scenario scenario = random_load_scenario(seed);
        const analysis::BufferBound bound(scenario);
        const std::optional<analysis::BufferBound::Result> found = bound.find();
        if (!found || found->pixels < 8 * bound.smallest_legal_pixels()) continue;
        const auto least = static_cast<int>(bound.smallest_legal_pixels());
        if (run_with_buffer(scenario, least).starved_pixels > 0) return;
    }
    FAIL("no machine with the smallest legal buffer starved");
}

TEST_CASE("a frame has as many bursts and beats on each bus as the analysis says",
          "[system][analysis][random]") {
    int compared = 0;
    for (std::uint64_t seed = 1; seed <= 400 && compared < 100; ++seed) {
        Scenario scenario = random_load_scenario(seed);
        scenario.frames = 1;
        scenario.pacing = Pacing::kLockstep;
        scenario.faults.clear();
        if (scenario.composer.ready_space_pixels < scenario.bus.burst_pixels) continue;
        const bool interrupted = scenario.memory.refreshes() || scenario.memory.shared();
        ++compared;
        INFO("seed " << seed << ": " << describe(scenario));
        const analysis::Analysis analysis = analysis::analyze(scenario);
        const Starvation run = run_with_buffer(
            scenario, static_cast<int>(analysis.safe_buffer_pixels.value_or(analysis.whole_buffer_pixels)));
        std::int64_t bursts = 0;
        std::int64_t beats = 0;
        std::int64_t page_misses = 0;
        std::int64_t table_cycles = 0;
        bool alone = true;
        for (const analysis::TableAnalysis& table : analysis.tables) {
            for (const analysis::ComposerAnalysis& composer : table.composers) bursts += composer.bursts;
            beats += table.supply.beats;
            page_misses += table.supply.page_misses;
            table_cycles += table.supply.table_cycles;
            alone = alone && table.composers.size() <= 1;
        }
        CHECK(run.bus.bursts == bursts);
        CHECK(run.bus.busy_cycles == beats * cycles_per_beat(scenario.bus));
        CHECK(run.bus.table_cycles == table_cycles);
        // Pages that were open before a refresh or a write are opened again. With banks some pages stay open.
        if (!interrupted) CHECK(run.bus.page_misses <= page_misses);
        if (alone && !interrupted && scenario.memory.banks == 1) CHECK(run.bus.page_misses == page_misses);
    }
    CHECK(compared >= 50);
}

}  // namespace metabuffer::test::analysis_safety_test
