#include "tools/analysis/slot_share.h"

#include <algorithm>
#include <utility>

#include "tools/analysis/arithmetic.h"

namespace metabuffer::analysis {
namespace {

/// In a larger table it takes too long to check every window, and a whole rotation is assumed instead.
constexpr std::size_t kLargestExactTable = 512;

}  // namespace

SlotShares::SlotShares(std::vector<int> table, std::size_t rows, RepeatedSlot repeated)
    : table_(std::move(table)), slots_(rows, 0), sure_grants_(rows, 0), repeated_(repeated) {
    for (std::size_t slot = 0; slot < table_.size(); ++slot) {
        const auto row = static_cast<std::size_t>(table_[slot]);
        ++slots_[row];
        sure_grants_[row] += is_sure(slot) ? 1 : 0;
    }
    // After each grant another row is granted first. From there on the row gets its own next slot, which comes before
    // the table has gone round, but it may be the only one.
    if (repeated_ == RepeatedSlot::kSkipped || repeated_ == RepeatedSlot::kDelayed)
        std::fill(sure_grants_.begin(), sure_grants_.end(), 1);
}

/// Whether the slot's row gets it even if it had the slot before.
bool SlotShares::is_sure(std::size_t slot) const {
    const std::size_t before = slot == 0 ? table_.size() - 1 : slot - 1;
    return repeated_ == RepeatedSlot::kGranted || repeated_ == RepeatedSlot::kDelayed || rows() == 1 ||
           table_[before] != table_[slot];
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
        const bool own = table_[slot] == static_cast<int>(row);
        const bool free_of_cost = repeated_ == RepeatedSlot::kSkipped || is_sure(slot);
        rotation += own && free_of_cost ? 0.0 : cycles_of(slot);
    }
    wait.rate = rotation / static_cast<double>(grants);
    if (count > kLargestExactTable || repeated_ == RepeatedSlot::kSkipped) {
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
    if (repeated_ == RepeatedSlot::kDelayed) wait.rate = wait.most[1];
    for (std::size_t granted = 1; granted <= grants; ++granted) {
        wait.spread = std::max(wait.spread, wait.most[granted] - wait.rate * static_cast<double>(granted));
    }
    return wait;
}

/// The most slots of `row` between two of `rival`.
std::int64_t SlotShares::most_between(std::size_t row, std::size_t rival) const {
    std::int64_t most = 0;
    std::int64_t since = 0;
    for (std::size_t step = 0; step < 2 * table_.size(); ++step) {
        const auto owner = static_cast<std::size_t>(table_[step % table_.size()]);
        since = owner == rival ? 0 : since + (owner == row ? 1 : 0);
        most = std::max(most, since);
    }
    return most;
}

SlotShares::Fairness SlotShares::fairness(std::size_t row, std::size_t rival) const {
    Fairness fairness;
    fairness.rate = static_cast<double>(sure_grants_[rival]) / static_cast<double>(slots_[row]);
    const std::size_t count = table_.size();
    if (repeated_ == RepeatedSlot::kDelayed) {
        // While the rival is passed over, the row gets a slot at most, since it is passed over itself after that. Then
        // it gets those before the rival's next one.
        fairness.rate = 1.0 / as_double(1 + most_between(row, rival));
        fairness.loss = 1.0;
        return fairness;
    }
    if (count > kLargestExactTable || repeated_ == RepeatedSlot::kSkipped) {
        fairness.loss = static_cast<double>(sure_grants_[rival]);
        return fairness;
    }
    for (std::size_t start = 0; start < count; ++start) {
        std::int64_t own = 0;
        std::int64_t rivals = 0;
        for (std::size_t step = 0; own < slots_[row]; ++step) {
            const int owner = table_[(start + step) % count];
            if (owner == static_cast<int>(row)) {
                ++own;
                fairness.loss = std::max(
                    fairness.loss, fairness.rate * static_cast<double>(own) - static_cast<double>(rivals));
            }
            rivals += owner == static_cast<int>(rival) && is_sure((start + step) % count) ? 1 : 0;
        }
    }
    return fairness;
}

}  // namespace metabuffer::analysis
