#include "analysis/slot_share.h"

#include <algorithm>
#include <utility>

namespace metabuffer::analysis {
namespace {

/// Beyond it, looking at every window of a table takes too long, and a whole rotation stands for each.
constexpr std::size_t kLargestExactTable = 512;

}  // namespace

SlotShares::SlotShares(std::vector<int> table, std::size_t rows, bool passed_over)
    : table_(std::move(table)), slots_(rows, 0), sure_grants_(rows, 0), passed_over_(passed_over) {
    for (std::size_t slot = 0; slot < table_.size(); ++slot) {
        const auto row = static_cast<std::size_t>(table_[slot]);
        ++slots_[row];
        sure_grants_[row] += is_sure(slot) ? 1 : 0;
    }
}

/// A slot that its row gets even if it had the one before. A row that has the whole table gets every slot: passed
/// over, it is alone, and the bus asks again.
bool SlotShares::is_sure(std::size_t slot) const {
    const std::size_t before = slot == 0 ? table_.size() - 1 : slot - 1;
    const int row = table_[slot];
    return !passed_over_ || table_[before] != row ||
           slots_[static_cast<std::size_t>(row)] == static_cast<std::int64_t>(table_.size()) || rows() == 1;
}

SlotShares::Wait SlotShares::wait(std::size_t row, const std::vector<double>& slot_cycles,
                                  double own_lost_cycles) const {
    Wait wait;
    const auto grants = static_cast<std::size_t>(sure_grants_[row]);
    wait.most.assign(grants + 1, 0.0);
    const std::size_t count = table_.size();
    const auto cycles_of = [&](std::size_t slot) {
        const auto owner = static_cast<std::size_t>(table_[slot]);
        return owner == row ? own_lost_cycles : slot_cycles[owner];
    };
    double rotation = 0.0;
    for (std::size_t slot = 0; slot < count; ++slot) {
        const bool own_grant = table_[slot] == static_cast<int>(row) && is_sure(slot);
        rotation += own_grant ? 0.0 : cycles_of(slot);
    }
    wait.rate = rotation / static_cast<double>(grants);
    if (count > kLargestExactTable) {
        std::fill(wait.most.begin() + 1, wait.most.end(), rotation);
        wait.spread = rotation;
        return wait;
    }
    for (std::size_t start = 0; start < count; ++start) {
        double cycles = 0.0;
        std::size_t granted = 0;
        for (std::size_t step = 0; granted < grants; ++step) {
            const std::size_t slot = (start + step) % count;
            if (table_[slot] == static_cast<int>(row) && is_sure(slot)) {
                ++granted;
                wait.most[granted] = std::max(wait.most[granted], cycles);
            } else {
                cycles += cycles_of(slot);
            }
        }
    }
    for (std::size_t granted = 1; granted <= grants; ++granted) {
        wait.spread = std::max(wait.spread, wait.most[granted] - wait.rate * static_cast<double>(granted));
    }
    return wait;
}

SlotShares::Fairness SlotShares::fairness(std::size_t row, std::size_t rival) const {
    Fairness fairness;
    fairness.rate = static_cast<double>(sure_grants_[rival]) / static_cast<double>(slots_[row]);
    const std::size_t count = table_.size();
    if (count > kLargestExactTable) {
        fairness.loss = static_cast<double>(sure_grants_[rival]);
        return fairness;
    }
    for (std::size_t start = 0; start < count; ++start) {
        std::int64_t own = 0;
        std::int64_t rivals = 0;
        // The rival may have had the slot before the window's first.
        bool rival_before = true;
        for (std::size_t step = 0; own < slots_[row]; ++step) {
            const int owner = table_[(start + step) % count];
            if (owner == static_cast<int>(row)) {
                ++own;
                fairness.loss = std::max(
                    fairness.loss, fairness.rate * static_cast<double>(own) - static_cast<double>(rivals));
            }
            const bool is_rival = owner == static_cast<int>(rival);
            rivals += is_rival && !(passed_over_ && rival_before) ? 1 : 0;
            rival_before = is_rival;
        }
    }
    return fairness;
}

}  // namespace metabuffer::analysis
