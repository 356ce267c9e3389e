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
#include "tools/analysis/taken_clocks.h"

namespace metabuffer::analysis {

/// The figures of a scenario's machine that the arithmetic needs.
struct MachineFigures {
    explicit MachineFigures(const Scenario& scenario)
        : MachineFigures(scenario, arbitration_row(scenario.bus.arbitration)) {}
    /// The same with this policy instead of the scenario's.
    MachineFigures(const Scenario& scenario, const ArbitrationRow& policy);

    std::int64_t raster_width = 0;
    std::int64_t raster_pixels = 0;
    std::int64_t burst_pixels = 0;
    std::int64_t ready_space = 0;
    Smoothing smoothing = Smoothing::kReplicate;
    std::int64_t pixels_per_beat = 0;
    std::int64_t cycles_per_beat = 0;
    std::int64_t page_miss_cycles = 0;
    std::int64_t lost_slot_cycles = 0;
    std::int64_t in_flight_pixels = 0;
    /// Clocks that read latency and registers add to the way of a beat to its composer, and those from there until its
    /// answer is read.
    std::int64_t delay_cycles = 0;
    std::int64_t loop_cycles = 0;
    /// Clocks from a release until the arbiter knows of it.
    std::int64_t busready_cycles = 0;
    /// A burst may stand still between two beats longer than a page miss: for a refresh or for writes.
    bool interrupted = false;
    std::int64_t grant_cycles = 0;
    ArbitrationRow policy;

    /// No burst is ever cut short: BUSREADY promises room for a whole one.
    bool whole_bursts() const { return ready_space >= burst_pixels; }
    /// With so much space free, no burst is cut short.
    std::int64_t uncut_space() const {
        if (whole_bursts()) return ready_space;
        return burst_pixels + (loop_cycles > 0 || interrupted ? in_flight_pixels : 0);
    }
    /// A slot that its composer cannot use goes to the next one that is ready: the bus never waits for a slot.
    bool work_conserving() const { return policy.idle_slots == IdleSlots::kRecovered; }
    /// A composer that is ready gets each of its slots.
    bool has_sure_slots() const { return policy.proof == BufferProof::kSlots; }
    /// Something is proved of the policy. If it has no sure slots, that is that the earliest deadline goes first.
    bool has_bound() const { return policy.proof != BufferProof::kNone; }
    /// Bursts are single beats, after which the composer is passed over for a clock.
    bool single_beats() const { return burst_pixels <= pixels_per_beat; }
    /// After each burst the composer is passed over for so many clocks, until its BUSREADY reflects the last beat.
    std::int64_t passed_over_cycles() const {
        if (loop_cycles > 0) return 1 + loop_cycles;
        return single_beats() || !whole_bursts() ? 1 : 0;
    }
};

/// A segment cut into portions. With each grant, a composer that is ready is sure to get at least the rest of its
/// current portion, and as much of the next one as it already had of the current one.
struct Portions {
    /// Where each portion begins; the last entry is the segment's end.
    std::vector<std::int64_t> first_pixel;
    /// The clock of this raster position is the last one in which the portion may be granted.
    std::vector<double> latest_start;
    /// The composer's own clocks for all portions before each; the last entry is for all portions.
    std::vector<double> own_before;
    /// "Ready" means at least so much free space.
    std::int64_t ready_space = 0;
    /// Grants begin where portions do.
    bool aligned = true;

    std::int64_t count() const { return static_cast<std::int64_t>(latest_start.size()); }
};

/// The most pixels that the raster can release: rate * window + burst in any window of positions, and none outside of
/// first to last.
struct ReleaseCurve {
    double rate = 0.0;
    double burst = 0.0;
    std::int64_t first = 0;
    std::int64_t last = 0;  ///< one past the last release

    ReleaseCurve() = default;
    ReleaseCurve(const Segment& segment, std::int64_t raster_width);
};

/// The composer of one row of a table, as a user of the bus.
struct BusUser {
    Segment segment;
    BurstCosts
        costs;  ///< of whole bursts; each begins with a page miss if another composer's may come between
    BurstCosts stream;  ///< the same as if no other composer's burst came between
    ReleaseCurve releases;
    /// Any c of its slots, one after the other, take at most c * slot_average + slot_excess clocks.
    double slot_average = 0.0;
    double slot_excess = 0.0;
    /// How the segment is granted. If bursts may be cut short, there are two ways to divide it, else one.
    std::vector<Portions> portions;
    SlotShares::Wait wait;  ///< for the rivals' slots; only if slots are sure
    /// Where a composer is passed over for some clocks: what the slot that others take last in them can last beyond.
    double overrun_cycles = 0.0;

    int display() const { return segment.row().dcomp; }
};

/// How the slots of a composer and those of one rival alternate.
struct Rivalry {
    /// The least that the rival gets, if it is ready, during so many grants of the composer.
    SlotShares::Fairness fairness;
    /// Clocks of the rival's slots before so many grants of the composer: at most slot_rate * grants + slot_spread.
    double slot_rate = 0.0;
    double slot_spread = 0.0;
};

/// What a renderer's bus has to carry for the table of one frame.
class BusTable {
  public:
    /// In a longer table, rivals are not checked one by one.
    static constexpr std::size_t kMostRivals = 64;

    /// The rows must be valid for the scenario's raster and the renderer's image. slots: the row of each slot; empty
    /// for a policy without slots.
    BusTable(const Scenario& scenario, const MachineFigures& machine, int renderer, const ViewportTable& rows,
             std::vector<int> slots);

    const MachineFigures& machine() const { return machine_; }
    int renderer() const { return renderer_; }
    const std::vector<BusUser>& users() const { return users_; }
    /// Empty if the policy has no slots.
    const SlotShares& shares() const { return shares_; }
    bool knows_rivals() const { return users_.size() <= kMostRivals; }
    /// row, rival: two different rows of the table. Only if knows_rivals() and slots are sure.
    const Rivalry& rivalry(std::size_t row, std::size_t rival) const {
        return rivalries_[row * users_.size() + rival];
    }
    /// Whether a burst's first word finds its page open.
    FirstWord first_word() const { return first_word_; }
    /// Work of c clocks in a window takes stretch() * c and once interruption_cycles() in the worst case.
    double stretch() const { return taken_.stretch(); }
    double taken_share() const { return taken_.share; }
    double interruption_cycles() const { return taken_.latency(); }
    /// The most clocks until a burst or a lost slot under way is over, with those that the window's work is interrupted
    /// for once. If a frame has no page miss but the one that it begins with, that is included.
    double residual_cycles() const { return residual_cycles_; }
    /// From any clock on, a composer with room for whole bursts is sure to get rate * clocks - loss bursts, whatever
    /// the others do. Only if slots are sure.
    struct SureBursts {
        double rate = 0.0;
        double loss = 0.0;
        double in(double clocks) const { return std::max(0.0, rate * clocks - loss); }
    };
    SureBursts sure_bursts(std::size_t row) const;
    /// Clocks in which the arbiter makes the slot table, and the bus waits, when a frame begins.
    double build_cycles() const { return build_cycles_; }
    /// Clocks that a grant may cost a composer besides its burst, since it is passed over for some clocks after it.
    double passed_over_cycles() const;
    /// The clocks that a burst cut short may cost besides its pixels: the arbiter's, a page miss, a beat that is not
    /// full, one clock.
    double cut_cycles() const;
    /// At least so many pixels pass before a composer that was granted a burst cuts it short.
    std::int64_t least_cut_pixels() const;

  private:
    double stretched(std::int64_t cycles) const { return stretch() * static_cast<double>(cycles); }
    RepeatedSlot repeated_slot(const std::vector<int>& slots) const;
    void find_first_word(const Renderer& renderer, const MemoryConfig& memory, const ViewportTable& rows);
    void add_user(const Scenario& scenario, const Renderer& renderer, const ViewportRow& row);
    Portions whole_burst_portions(const BusUser& user) const;
    Portions cut_burst_portions(const BusUser& user) const;
    void find_overruns();
    void find_waits();
    void find_rivalries();

    MachineFigures machine_;
    int renderer_;
    FirstWord first_word_ = FirstWord::kMisses;
    std::vector<BusUser> users_;
    SlotShares shares_;
    std::vector<Rivalry> rivalries_;
    TakenClocks taken_;
    double residual_cycles_ = 0.0;
    double build_cycles_ = 0.0;
};

}  // namespace metabuffer::analysis
