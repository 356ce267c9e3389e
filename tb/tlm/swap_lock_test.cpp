#include "tlm/swap_lock.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "scenario/scenario.h"
#include "support/random_seed.h"
#include "tlm/column_time.h"

namespace metabuffer::test::swap_lock_test {
namespace {

struct Swap {
    int frame = 0;
    std::int64_t pipeready_cycle = 0;
    std::int64_t shown_picoseconds = 0;
    friend bool operator==(const Swap& a, const Swap& b) {
        return a.frame == b.frame && a.pipeready_cycle == b.pipeready_cycle &&
               a.shown_picoseconds == b.shown_picoseconds;
    }
};

/// Frame by frame and display by display: core clocks from PIPEREADY to the last pixel.
using Lengths = std::vector<std::vector<int>>;

/// The output framebuffers and the swap lock edge by edge, with two registers at each crossing.
class NaiveSwaps {
  public:
    NaiveSwaps(std::int64_t core_period, std::int64_t dvi_period, int width, int height,
               const Lengths& lengths)
        : core_period_(core_period),
          dvi_period_(dvi_period),
          line_clocks_(width + 80),
          height_(height),
          lengths_(lengths),
          done_(lengths.front().size(), false) {
        const std::int64_t reset_ends = 2 * core_period - core_period / 2;
        while (first_dvi_edge_ * dvi_period < reset_ends) ++first_dvi_edge_;
        line_ = 6 + height + 1;  // the link comes up with a vertical sync
    }

    std::int64_t first_dvi_edge() const { return first_dvi_edge_; }
    std::vector<std::int64_t> swap_times;
    std::vector<std::vector<std::int64_t>> done_clocks;  ///< by frame and display

    std::vector<Swap> run() {
        std::int64_t core = 0;
        std::int64_t dvi = 0;
        while (swaps_.size() < lengths_.size() || swaps_.back().shown_picoseconds < 0) {
            const std::int64_t time = std::min(core * core_period_, dvi * dvi_period_);
            // Both domains read the values before the edge.
            const bool swaplock = swaplock_;
            const bool swapped = swapped_;
            if (time == core * core_period_) core_edge(core++, swapped);
            if (time == dvi * dvi_period_) dvi_edge(dvi++, swaplock, time);
            swaplock_ = next_swaplock_;
            swapped_ = next_swapped_;
        }
        return swaps_;
    }

  private:
    void core_edge(std::int64_t clock, bool swapped) {
        if (clock < 2) return;  // reset
        core_sync_[1] = core_sync_[0];
        core_sync_[0] = swapped;
        const bool synchronized = core_sync_[1];
        const bool rises = synchronized && !last_synchronized_;
        last_synchronized_ = synchronized;
        if (rises) {
            done_.assign(done_.size(), false);
            ready_ = true;
            pipeready_ = clock;
            swaps_[static_cast<std::size_t>(frame_) - 1].pipeready_cycle = clock;
        }
        if (clock == 2) pipeready_ = 2;
        if (static_cast<std::size_t>(frame_) < lengths_.size() && ready_) {
            const std::vector<int>& lengths = lengths_[static_cast<std::size_t>(frame_)];
            bool all = true;
            for (std::size_t d = 0; d < done_.size(); ++d) {
                if (clock == pipeready_ + lengths[d]) done_[d] = true;
                all = all && done_[d];
            }
            if (all) {
                std::vector<std::int64_t> clocks;
                for (const int length : lengths) clocks.push_back(pipeready_ + length);
                done_clocks.push_back(clocks);
                swaps_.push_back({frame_++, -1, -1});
                ready_ = false;
            }
        }
        // FRAMEDONE of all of them, and so SWAPLOCK.
        bool all = true;
        for (const bool done : done_) all = all && done;
        next_swaplock_ = all && !synchronized;
    }

    void dvi_edge(std::int64_t edge, bool swaplock, std::int64_t time) {
        if (edge < first_dvi_edge_) return;
        dvi_sync_[1] = dvi_sync_[0];
        dvi_sync_[0] = swaplock;
        if (!dvi_sync_[1]) {
            next_swapped_ = false;
        } else if (!swapped_) {
            pending_ = true;
        }
        // The display reads the vertical sync a clock after the edge that drives it.
        if (vsync_driven_) {
            for (Swap& swap : swaps_) {
                if (swap.frame < static_cast<int>(swap_times.size()) && swap.shown_picoseconds < 0) {
                    swap.shown_picoseconds = time;
                }
            }
        }
        vsync_driven_ = false;
        if (x_ == 0) {
            if (line_ == 6 + height_ + 1 + 8) line_ = 0;
            if (line_ == 0 && pending_) {
                pending_ = false;
                swap_times.push_back(time);
                next_swapped_ = true;
            }
            vsync_driven_ = line_ == 6 + height_ + 1;
        }
        if (++x_ == line_clocks_) {
            x_ = 0;
            ++line_;
        }
    }

    std::int64_t core_period_;
    std::int64_t dvi_period_;
    int line_clocks_;
    int height_;
    const Lengths& lengths_;
    std::int64_t first_dvi_edge_ = 0;
    std::vector<bool> done_;
    bool ready_ = true;
    std::int64_t pipeready_ = 0;
    int frame_ = 0;
    bool core_sync_[2] = {};
    bool dvi_sync_[2] = {};
    bool last_synchronized_ = false;
    bool swaplock_ = false;
    bool next_swaplock_ = false;
    bool swapped_ = false;
    bool next_swapped_ = false;
    bool pending_ = false;
    bool vsync_driven_ = false;
    int line_ = 0;
    int x_ = 0;
    std::vector<Swap> swaps_;
};

void compare(const Scenario& scenario, const Lengths& lengths);

void compare(Random& random, double core_mhz, double dvi_mhz) {
    INFO("core " << core_mhz << " MHz, DVI output " << dvi_mhz << " MHz");
    Scenario scenario;
    scenario.displays.columns = random.between(1, 3);
    scenario.displays.width_pixels = random.between(1, 6);
    scenario.displays.height_pixels = random.between(1, 4);
    scenario.clocks.core_mhz = core_mhz;
    scenario.clocks.dvi_out_mhz = dvi_mhz;
    scenario.frames = random.between(1, 5);
    Lengths lengths;
    for (int frame = 0; frame < scenario.frames; ++frame) {
        lengths.emplace_back();
        const int longest = random.one_in(2) ? 5 : 4000;
        for (int d = 0; d < scenario.displays.count(); ++d)
            lengths.back().push_back(random.between(3, 3 + longest));
    }
    compare(scenario, lengths);
}

void compare(const Scenario& scenario, const Lengths& lengths) {
    const auto core_period = static_cast<std::int64_t>(1.0e6 / scenario.clocks.core_mhz + 0.5);
    const auto dvi_period = static_cast<std::int64_t>(1.0e6 / scenario.clocks.dvi_out_mhz + 0.5);
    NaiveSwaps naive(core_period, dvi_period, scenario.displays.width_pixels, scenario.displays.height_pixels,
                     lengths);
    const std::vector<Swap> wanted = naive.run();

    tlm::SwapLock lock(sc_core::sc_gen_unique_name("swap_lock"), scenario, naive.first_dvi_edge(), 2);
    std::vector<std::vector<Swap>> heard(static_cast<std::size_t>(scenario.displays.count()));
    for (std::vector<Swap>& swaps : heard) {
        lock.on_swap([&swaps](int frame, std::int64_t pipeready_cycle, std::int64_t shown_picoseconds) {
            swaps.push_back({frame, pipeready_cycle, shown_picoseconds});
        });
    }
    CHECK(lock.pipeready_cycle() == 2);
    for (int frame = 0; frame < scenario.frames; ++frame) {
        INFO("frame " << frame);
        REQUIRE(lock.end_picoseconds() == tlm::kUnknownCycle);
        for (int d = 0; d < scenario.displays.count(); ++d) {
            REQUIRE(heard.front().size() == static_cast<std::size_t>(frame));
            lock.frame_done(frame,
                            naive.done_clocks[static_cast<std::size_t>(frame)][static_cast<std::size_t>(d)]);
        }
        REQUIRE(heard.front().size() == static_cast<std::size_t>(frame) + 1);
        const Swap& swap = heard.front().back();
        REQUIRE(swap.frame == frame);
        // The last swap may not have come back to the core clock when its frame has been shown.
        const Swap& truth = wanted[static_cast<std::size_t>(frame)];
        REQUIRE(swap.shown_picoseconds == truth.shown_picoseconds);
        if (truth.pipeready_cycle >= 0) REQUIRE(swap.pipeready_cycle == truth.pipeready_cycle);
        REQUIRE(lock.pipeready_cycle() == swap.pipeready_cycle);
        const std::int64_t time = naive.swap_times[static_cast<std::size_t>(frame)];
        REQUIRE(lock.swaps_before(time) == frame);
        REQUIRE(lock.swaps_before(time + 1) == frame + 1);
    }
    for (const std::vector<Swap>& swaps : heard) REQUIRE(swaps == heard.front());
    REQUIRE(lock.end_picoseconds() == wanted.back().shown_picoseconds);
}

/// Clock ratios whose edges coincide, nearly coincide, or never do.
void compare_clocks(std::uint64_t default_seed, const std::vector<double>& dvi_mhz) {
    const auto seed = random_seed(default_seed);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    for (const double mhz : dvi_mhz) {
        for (int trial = 0; trial < 25; ++trial) compare(random, 100.0, mhz);
    }
}

TEST_CASE("swap lock: displays of the core's clock swap where two registers have passed SWAPLOCK") {
    compare_clocks(541, {100.0});
}

TEST_CASE("swap lock: displays of a slower clock swap where two registers have passed SWAPLOCK") {
    compare_clocks(542, {99.9, 50.0, 33.3, 25.175, 7.0});
}

TEST_CASE("swap lock: displays of a faster clock swap where two registers have passed SWAPLOCK") {
    compare_clocks(543, {100.1, 200.0, 165.0, 700.0, 999.0});
}

TEST_CASE(
    "swap lock: a frame that is done at any clock of a DVI frame is shown from the next frame's start on") {
    Scenario scenario;
    scenario.displays.width_pixels = 1;
    scenario.displays.height_pixels = 1;
    scenario.clocks.core_mhz = scenario.clocks.dvi_out_mhz = 100.0;
    scenario.frames = 1;
    constexpr int kFrameClocks = (1 + 80) * (1 + 15);
    for (int clocks = 3; clocks < 3 + kFrameClocks; ++clocks) {
        INFO("done after " << clocks << " clocks");
        compare(scenario, Lengths{{clocks}});
    }
}

}  // namespace
}  // namespace metabuffer::test::swap_lock_test
