#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "datapath/arbitration/arbitration_table.h"
#include "datapath/segment.h"
#include "scenario/scenario.h"
#include "tools/analysis/burst_costs.h"
#include "tools/analysis/slot_share.h"

namespace metabuffer::analysis {

/// What the arithmetic needs of a scenario's machine.
struct MachineFigures {
    explicit MachineFigures(const Scenario& scenario)
        : MachineFigures(scenario, arbitration_row(scenario.bus.arbitration)) {}
    /// As if the scenario's policy were this one.
    MachineFigures(const Scenario& scenario, const ArbitrationRow& policy);

    std::int64_t raster_width = 0;
    std::int64_t raster_pixels = 0;
    std::int64_t burst_pixels = 0;
    std::int64_t ready_space = 0;
    std::int64_t pixels_per_beat = 0;
    std::int64_t cycles_per_beat = 0;
    std::int64_t page_miss_cycles = 0;
    std::int64_t lost_slot_cycles = 0;
    ArbitrationRow policy;

    /// No burst is ever cut short: BUSREADY promises room for a whole one.
    bool whole_bursts() const { return ready_space >= burst_pixels; }
    /// Slots that nobody can use are never waited for.
    bool work_conserving() const { return policy.idle_slots == IdleSlots::kRecovered; }
    /// A composer that is ready gets each of its slots.
    bool has_sure_slots() const { return policy.proof == BufferProof::kSlots; }
    /// Something is proved of the policy; without sure slots that what is due first goes first.
    bool has_bound() const { return policy.proof != BufferProof::kNone; }
    /// Bursts are single beats, after which the composer is passed over for a clock.
    bool single_beats() const { return burst_pixels <= pixels_per_beat; }
};

/// A segment in portions such that a composer that is ready is sure to get, with each grant, at least the rest of the
/// portion it stands in and as much of the next one as it had of this one.
struct Portions {
    /// Where each portion begins, and the segment's end.
    std::vector<std::int64_t> first_pixel;
    /// The raster position at whose clock the portion must be granted at the latest.
    std::vector<double> latest_start;
    /// The composer's own clocks for all portions before each, and for all.
    std::vector<double> own_before;
    /// "Ready" means so much free space, or more.
    std::int64_t ready_space = 0;
    /// Grants begin where portions do.
    bool aligned = true;

    std::int64_t count() const { return static_cast<std::int64_t>(latest_start.size()); }
};

/// Pixels that the raster releases: in any window of positions at most rate * window + burst, and none outside of
/// first to last.
struct ReleaseCurve {
    double rate = 0.0;
    double burst = 0.0;
    std::int64_t first = 0;
    std::int64_t last = 0;  ///< one past

    ReleaseCurve() = default;
    ReleaseCurve(const Segment& segment, std::int64_t raster_width);
};

/// One row of a table: the composer it goes to, as a user of the bus.
struct BusUser {
    Segment segment;
    BurstCosts costs;   ///< of whole bursts, each beginning with a page miss if another's may come between
    BurstCosts stream;  ///< as if nothing came between
    ReleaseCurve releases;
    /// Any c slots of it in a row take at most c * slot_average + slot_excess clocks.
    double slot_average = 0.0;
    double slot_excess = 0.0;
    /// How the segment is granted; with bursts that may be cut short there are two ways to see it.
    std::vector<Portions> portions;
    SlotShares::Wait wait;  ///< behind the rivals' slots; only if these are sure

    int display() const { return segment.row().dcomp; }
};

/// What the slots of one composer mean for another.
struct Rivalry {
    /// What the other gets at least, if it is ready, beside so many grants of the one.
    SlotShares::Fairness fairness;
    /// Clocks of the other's slots before so many grants of the one: at most slot_rate * grants + slot_spread.
    double slot_rate = 0.0;
    double slot_spread = 0.0;
};

/// A renderer's table of one frame, as what its bus has to carry.
class BusTable {
  public:
    /// In a longer table, rivals are not looked at one by one.
    static constexpr std::size_t kMostRivals = 64;

    /// The rows must be valid for the scenario's raster and the renderer's image. slots: rows by slot; none under a
    /// policy without slots.
    BusTable(const Scenario& scenario, const MachineFigures& machine, int renderer, const ViewportTable& rows,
             std::vector<int> slots);

    const MachineFigures& machine() const { return machine_; }
    int renderer() const { return renderer_; }
    const std::vector<BusUser>& users() const { return users_; }
    /// Empty if the policy has no slots.
    const SlotShares& shares() const { return shares_; }
    bool knows_rivals() const { return users_.size() <= kMostRivals; }
    /// Both by row. Only if knows_rivals(), and slots are sure.
    const Rivalry& rivalry(std::size_t row, std::size_t rival) const {
        return rivalries_[row * users_.size() + rival];
    }
    /// How each burst's first word finds the memory.
    FirstWord first_word() const { return first_word_; }
    /// Clocks until a burst or a lost slot under way is over, with the page miss that a frame begins with if that is
    /// its only one.
    double residual_cycles() const { return residual_cycles_; }
    /// A composer with room for whole bursts is sure to get rate * clocks - loss of them, from any clock on, whatever the
    /// others do. Only if slots are sure.
    struct SureBursts {
        double rate = 0.0;
        double loss = 0.0;
        double in(double clocks) const { return std::max(0.0, rate * clocks - loss); }
    };
    SureBursts sure_bursts(std::size_t row) const;
    /// What a composer cut short may cost beside its pixels: another page miss, a beat that is not full, a clock.
    double cut_cycles() const;
    /// At least so many pixels pass before a composer that was granted a burst cuts it short.
    std::int64_t least_cut_pixels() const;

  private:
    void find_first_word(const Renderer& renderer, const MemoryConfig& memory, const ViewportTable& rows);
    void add_user(const Scenario& scenario, const Renderer& renderer, const ViewportRow& row);
    Portions whole_burst_portions(const BusUser& user) const;
    Portions cut_burst_portions(const BusUser& user) const;
    void find_waits();
    void find_rivalries();

    MachineFigures machine_;
    int renderer_;
    FirstWord first_word_ = FirstWord::kMisses;
    std::vector<BusUser> users_;
    SlotShares shares_;
    std::vector<Rivalry> rivalries_;
    double residual_cycles_ = 0.0;
};

}  // namespace metabuffer::analysis
