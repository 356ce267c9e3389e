#pragma once

#include <cstdint>
#include <vector>

namespace metabuffer::analysis {

/// What becomes of a composer's slots after its own burst. After a burst of a single beat the composer is passed over for
/// one clock, and on a bus with delays for some clocks (docs/design.md).
enum class RepeatedSlot : std::uint8_t {
    kGranted,  ///< it gets the slot: bursts have several beats
    kLost,     ///< single beats, and unused slots pass: of two slots in a row it may get only one
    kSkipped,  ///< single beats, and others take the slot, even if slots that none can use come between
    kDelayed,  ///< delays: the table may go on anyhow for some clocks; from then on the composer gets its next slot
};

/// When the composers of a slot table get their slots, whichever others are ready. "Grants" of a row are the slots that
/// it takes while it is continuously ready.
class SlotShares {
  public:
    SlotShares() = default;
    /// table: row indices below `rows`, each at least once.
    SlotShares(std::vector<int> table, std::size_t rows, RepeatedSlot repeated);

    const std::vector<int>& table() const { return table_; }
    RepeatedSlot repeated() const { return repeated_; }
    std::size_t rows() const { return slots_.size(); }
    std::int64_t slots(std::size_t row) const { return slots_[row]; }
    /// Grants that the row is sure to get while the table goes round once.
    std::int64_t sure_grants(std::size_t row) const { return sure_grants_[row]; }

    /// The rivals' clocks before a row's `grants`-th grant, from any slot on: at most rate * grants + spread. A slot of
    /// row j takes slot_cycles[j] clocks. A slot in which the row itself is passed over takes own_lost_cycles. With delays
    /// what others take while the row is passed over is not included.
    struct Wait {
        double rate = 0.0;
        double spread = 0.0;
        std::vector<double> most;  ///< a closer limit for 1 to sure_grants(row) grants; [0] is 0
    };
    Wait wait(std::size_t row, const std::vector<double>& slot_cycles, double own_lost_cycles) const;

    /// While `row` gets `grants` slots, a rival that is ready all the time gets at least
    /// grants * rate - loss of its own.
    struct Fairness {
        double rate = 0.0;
        double loss = 0.0;
    };
    Fairness fairness(std::size_t row, std::size_t rival) const;

  private:
    bool is_sure(std::size_t slot) const;
    std::int64_t most_between(std::size_t row, std::size_t rival) const;

    std::vector<int> table_;
    std::vector<std::int64_t> slots_;
    std::vector<std::int64_t> sure_grants_;
    RepeatedSlot repeated_ = RepeatedSlot::kGranted;
};

}  // namespace metabuffer::analysis
