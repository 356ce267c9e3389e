#include "rtl/bus_arbiter.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <vector>

#include "lockstep/lockstep.h"
#include "support/random_seed.h"

namespace metabuffer::test::bus_arbiter_test {
namespace {

using rtl::BusArbiter;
using rtl::FrontTable;

constexpr int kLines = 4;

/// What the scenario says of the arbiter.
struct Setup {
    const char* name;
    Arbitration arbitration;
    int grant_cycles = 0;
    SlotTableMaker slot_table = SlotTableMaker::kHost;

    BusConfig bus() const {
        BusConfig config;
        config.arbitration = arbitration;
        config.grant_cycles = grant_cycles;
        config.slot_table = slot_table;
        return config;
    }
};

/// Asks the rows one by one, and the slots one by one from the pointer on.
class Arbiter final : public Lockstep<BusArbiter> {
  public:
    Arbiter(LockstepBench& bench, const Setup& setup)
        : Lockstep(bench, setup.name,
                   [&setup](const char* name, rtl::ClockGating) {
                       return std::make_unique<BusArbiter>(name, setup.bus(), kLines);
                   }),
          setup_(setup) {
        for (std::size_t line = 0; line < kLines; ++line) {
            pending_.push_back(&in(&BusArbiter::pending_i, line));
            ready_.push_back(&in(&BusArbiter::ready_i, line));
            if (by_deadline()) deadline_.push_back(&in(&BusArbiter::deadline_i, line));
            grant_.push_back(&out(&BusArbiter::grant_o, line));
            wires_.add(*pending_.back(), 6);
            wires_.add(*ready_.back(), 4);
        }
        wires_.add(take_, 3);
    }

    void stimulate() override {
        constexpr std::array<std::uint64_t, 5> kDeadlines{0, 1, 2, 1U << 31U, (std::uint64_t{1} << 32U) - 1};
        constexpr int kClocksToStart = 40;
        constexpr int kClocksToDeadline = 12;
        Random& random = bench_.random;
        const bool stands = quiet_ > 0;
        if (!stands) wires_.stimulate(bench_);
        quiet_ = stands ? quiet_ - 1 : random.one_in(200) ? 30 : 0;
        if (decided_) take_ = true;  // the bus waits for the answer
        if (random.one_in(kClocksToDeadline) && !deadline_.empty()) {
            *deadline_[static_cast<std::size_t>(random.between(0, kLines - 1))] = one_of(random, kDeadlines);
        }
        start_ = !decided_ && build_ == 0 && random.one_in(kClocksToStart);
        if (start_) table_ = random_table();
    }
    void expect() override {
        candidate_ = build_ == 0 ? choice() : Answer{};
        const bool stands = decided_ && wait_ == 0;
        answer_ = setup_.grant_cycles == 0 ? candidate_ : stands ? chosen_ : Answer{};
        for (int line = 0; line < kLines; ++line)
            *grant_[static_cast<std::size_t>(line)] = line == answer_.row;
        grant_valid_ = answer_.row >= 0;
        lost_ = answer_.lost;
        recovered_ = answer_.recovered;
        search_ = build_ > 0 || (setup_.grant_cycles > 0 && !stands && (decided_ || candidate_.counts()));
        slot_pin_ = static_cast<std::uint16_t>(slot_);
    }
    void edge() override {
        bench_.happened["an answer was taken"] += take_ && answer_.counts() ? 1 : 0;
        bench_.happened["slots were recovered past the table's end"] +=
            take_ && !start_ && answer_.recovered > 0 && slot_ + answer_.recovered >= slots_.size() ? 1 : 0;
        if (start_) {
            rows_ = table_->rows.size();
            slots_ = table_->slots;
            slot_ = 0;
            build_ = setup_.slot_table == SlotTableMaker::kBuilt ? slots_.size() : 0;
        } else if (build_ > 0) {
            --build_;
        } else if (take_ && answer_.counts()) {
            decided_ = false;
            if (!slots_.empty()) slot_ = (slot_ + answer_.recovered + 1) % slots_.size();
        } else if (decided_) {
            --wait_;
        } else if (take_ && setup_.grant_cycles > 0 && candidate_.counts()) {
            decided_ = true;
            chosen_ = candidate_;
            wait_ = setup_.grant_cycles - 1;
        }
    }
    void reset() override {
        rows_ = slot_ = build_ = 0;
        slots_.clear();
        decided_ = false;
    }

  private:
    struct Answer {
        int row = -1;
        bool lost = false;
        std::uint16_t recovered = 0;
        bool counts() const { return row >= 0 || lost; }
    };

    bool by_deadline() const { return setup_.arbitration == Arbitration::kEdf; }
    /// Each row owns a slot at least, in any order.
    FrontTable random_table() const {
        Random& random = bench_.random;
        FrontTable table;
        table.rows = ViewportTable(static_cast<std::size_t>(random.between(0, kLines)));
        const auto rows = static_cast<int>(table.rows.size());
        if (by_deadline() || rows == 0) return table;
        for (int row = 0; row < rows; ++row) table.slots.push_back(row);
        for (int extra = random.between(0, 6); extra > 0; --extra) {
            const int index = random.between(0, static_cast<int>(table.slots.size()));
            table.slots.insert(table.slots.begin() + index, random.between(0, rows - 1));
        }
        return table;
    }
    bool usable(std::size_t row) const { return row < rows_ && *pending_[row] && *ready_[row]; }
    Answer choice() const {
        Answer answer;
        if (by_deadline()) {
            for (std::size_t row = 0; row < rows_; ++row) {
                if (!usable(row)) continue;
                if (answer.row < 0 || *deadline_[row] < *deadline_[static_cast<std::size_t>(answer.row)]) {
                    answer.row = static_cast<int>(row);
                }
            }
            return answer;
        }
        for (std::size_t passed = 0; passed < slots_.size(); ++passed) {
            const int row = slots_[(slot_ + passed) % slots_.size()];
            if (usable(static_cast<std::size_t>(row)))
                return {row, false, static_cast<std::uint16_t>(passed)};
            if (setup_.arbitration == Arbitration::kSlotAllocation) return {-1, true, 0};
        }
        return answer;
    }

    const Setup& setup_;
    std::vector<Input<bool>*> pending_, ready_;
    std::vector<Input<std::uint64_t>*> deadline_;
    std::vector<Output<bool>*> grant_;
    Input<bool>& start_ = in(&BusArbiter::start_i);
    Input<FrontTable>& table_ = in(&BusArbiter::table_i);
    Input<bool>& take_ = in(&BusArbiter::take_i);
    Output<bool>& grant_valid_ = out(&BusArbiter::grant_valid_o);
    Output<bool>& search_ = out(&BusArbiter::search_o);
    Output<bool>& lost_ = out(&BusArbiter::lost_o);
    Output<std::uint16_t>& recovered_ = out(&BusArbiter::recovered_o);
    Output<std::uint16_t>& slot_pin_ = out(&BusArbiter::slot_o);
    FreeWires wires_;
    int quiet_ = 0;  ///< clocks in which nothing changes but a deadline, or a frame starts
    // The frame's table.
    std::size_t rows_ = 0;
    std::vector<int> slots_;
    std::size_t slot_ = 0;   ///< the pointer
    std::size_t build_ = 0;  ///< slots that are still to be built
    // An answer that takes clocks.
    bool decided_ = false;
    int wait_ = 0;
    Answer chosen_;
    // Of the clock.
    Answer candidate_, answer_;
};

TEST_CASE("bus arbiter: in lockstep with its reference") {
    static constexpr std::array kSetups{
        Setup{"irsa", Arbitration::kIrsa},
        Setup{"irsa_built", Arbitration::kIrsa, 0, SlotTableMaker::kBuilt},
        Setup{"irsa_built_3", Arbitration::kIrsa, 3, SlotTableMaker::kBuilt},
        Setup{"slot_allocation", Arbitration::kSlotAllocation},
        Setup{"slot_allocation_2", Arbitration::kSlotAllocation, 2},
        Setup{"round_robin", Arbitration::kRoundRobin},
        Setup{"round_robin_1", Arbitration::kRoundRobin, 1},
        Setup{"edf", Arbitration::kEdf},
        Setup{"edf_built_4", Arbitration::kEdf, 4, SlotTableMaker::kBuilt},
    };
    LockstepBench bench(181);
    bench.clocks_to_reset = 300;
    std::vector<std::unique_ptr<Arbiter>> arbiters;
    for (const Setup& setup : kSetups) arbiters.push_back(std::make_unique<Arbiter>(bench, setup));
    bench.run(20'000, {{"an answer was taken", 2000}, {"slots were recovered past the table's end", 100}});
}

}  // namespace
}  // namespace metabuffer::test::bus_arbiter_test
