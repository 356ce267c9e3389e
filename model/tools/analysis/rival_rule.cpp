#include "tools/analysis/rival_rule.h"

#include <algorithm>
#include <cmath>

#include "tools/analysis/arithmetic.h"

namespace metabuffer::analysis {
namespace {

class RivalRule {
  public:
    RivalRule(const BusTable& table, std::size_t row, const Jobs& jobs, const BufferCase& buffer,
              const PortionFlags& known)
        : table_(table), machine_(table.machine()), row_(row), jobs_(jobs), buffer_(buffer) {
        count_ = jobs.count() - jobs.first();
        for (std::int64_t at = 0; at < count_; ++at) {
            const std::int64_t portion = jobs.first() + at;
            const double ready = as_double(jobs.ready_at(portion)) + table.residual_cycles();
            from_.push_back(ready - jobs.own_before(portion));
            const bool done = known[static_cast<std::size_t>(portion)] != 0;
            until_.push_back(done ? kNever : jobs.own_before(portion) - jobs.latest_start(portion));
        }
        for (std::size_t j = 0; j < table.users().size(); ++j) {
            if (j != row) add_rival(j);
        }
        work_left_ = kWorkPerPortion * count_ + kLeastWork;
    }

    bool holds() { return holds({0, count_}, {0, count_}); }

  private:
    /// Enough for some passes over all portions; for small segments, enough to check every pair.
    static constexpr std::int64_t kWorkPerPortion = 400;
    static constexpr std::int64_t kLeastWork = 200'000;

    struct Range {
        std::int64_t begin = 0;
        std::int64_t end = 0;
        std::int64_t size() const { return end - begin; }
        std::int64_t middle() const { return begin + (size() + 1) / 2; }
        std::int64_t inside() const { return begin + size() / 2; }
    };
    struct Rival {
        std::size_t row = 0;
        double slot_rate = 0.0;  ///< clocks for each grant of the composer's own
        double slot_spread = 0.0;
        std::vector<double> granted;  ///< by portion: clocks of its grants until the composer begins to wait
        std::vector<double> room;     ///< by portion: the most clocks of its grants until the portion is due
        double slack = 0.0;
    };

    void add_rival(std::size_t j) {
        Rival rival;
        rival.row = j;
        const RivalGrants grants(table_, j, buffer_.buffer_pixels);
        rival.slack = grants.slack();
        if (machine_.has_sure_slots()) {
            const Rivalry& rivalry = table_.rivalry(row_, j);
            rival.slot_rate = rivalry.slot_rate;
            rival.slot_spread = rivalry.slot_spread;
            add_granted_beside_slots(rival, grants);
        } else {
            add_granted_beside_deadlines(rival, grants);
        }
        add_room(rival, grants);
        rivals_.push_back(std::move(rival));
    }

    /// There are two cases. The rival was not ready at some time before the composer began to wait; at the last such
    /// time it was full. Or it has been ready since the frame began, or since it had composited the previous frame.
    /// From then on it got its slots between the composer's.
    void add_granted_beside_slots(Rival& rival, const RivalGrants& grants) const {
        const SlotShares::Fairness& fairness = table_.rivalry(row_, rival.row).fairness;
        const double burst = as_double(machine_.burst_pixels);
        const double rate = fairness.rate * burst;
        const double loss = fairness.loss * burst;
        const double full_at_first = as_double(grants.when_full(0));
        const double room_at_first = rate * jobs_.granted_by_room(jobs_.first());
        const BusTable::SureBursts sure = table_.sure_bursts(rival.row);
        // What the rival had when it was full, less what it is sure to have got by then.
        double lowest_by_grants = full_at_first - room_at_first;
        double lowest_by_time = full_at_first - burst * sure.rate * as_double(jobs_.freed_at(jobs_.first()));
        const double at_start = std::max(0.0, rate * jobs_.granted_before(jobs_.first()) - loss);
        for (std::int64_t at = 0; at < count_; ++at) {
            const std::int64_t portion = jobs_.first() + at;
            const double now = as_double(jobs_.freed_at(portion));
            if (at > 0) {
                const std::int64_t position = jobs_.freed_at(portion - 1) - machine_.busready_cycles;
                const double full = as_double(
                    grants.when_full(grants.released_before(position - buffer_.shifts[rival.row].later)));
                lowest_by_grants = std::min(lowest_by_grants, full - rate * jobs_.granted_by_room(portion));
                lowest_by_time = std::min(lowest_by_time, full - burst * sure.rate * now);
            }
            const double own = rate * jobs_.granted_before(portion) - loss;
            const double by_time = burst * sure.in(now);
            const double since_start = std::max(own, at_start + by_time);
            const double since_full = std::max({full_at_first, lowest_by_grants + own,
                                                lowest_by_time + burst * (sure.rate * now - sure.loss)});
            double granted = std::min(since_start, since_full);
            if (buffer_.follows_a_frame) {
                granted = std::min(granted, refilled(rival) + std::max({0.0, own - room_at_first, by_time}));
            }
            add_granted(rival, grants, portion, granted);
        }
    }

    /// The least pixels that a rival has when it has composited the previous frame.
    double refilled(const Rival& rival) const {
        const double full = as_double(std::min(table_.users()[rival.row].segment.pixels(),
                                               buffer_.buffer_pixels - machine_.uncut_space() + 1));
        const double part_of_burst = machine_.whole_bursts() ? as_double(machine_.burst_pixels) : 0.0;
        return std::max(0.0, full - buffer_.refill_pixels[rival.row] - part_of_burst);
    }

    /// When the composer's last grant came, no rival that was ready had an earlier deadline. A rival that was not ready
    /// was full, or on a bus with delays may have been passed over.
    void add_granted_beside_deadlines(Rival& rival, const RivalGrants& grants) const {
        for (std::int64_t at = 0; at < count_; ++at) {
            const std::int64_t portion = jobs_.first() + at;
            const std::int64_t due = jobs_.segment().first_use(jobs_.last_grant_pixel(portion));
            const std::int64_t bursts = grants.bursts_due_before(due);
            std::int64_t granted = machine_.whole_bursts()
                                       ? grants.of_bursts(bursts)
                                       : std::max<std::int64_t>(0, (bursts - 1) * machine_.burst_pixels + 1);
            if (bursts == 0 || machine_.loop_cycles > 0) granted = 0;
            const std::optional<std::int64_t> since = jobs_.last_grant_after(portion);
            const std::int64_t released = since ? grants.released_before(*since - machine_.busready_cycles -
                                                                         buffer_.shifts[rival.row].later)
                                                : 0;
            granted = std::min(granted, grants.when_full(released));
            if (buffer_.follows_a_frame && !since) granted = 0;
            add_granted(rival, grants, portion, as_double(granted));
        }
    }

    /// What the raster has asked for has come in any case, else a pixel would have starved before.
    void add_granted(Rival& rival, const RivalGrants& grants, std::int64_t portion, double granted) const {
        const std::int64_t now = jobs_.freed_at(portion) - 1 - buffer_.shifts[rival.row].later;
        const double pixels = std::max(granted, as_double(grants.asked_for(now)));
        rival.granted.push_back(
            grants.clocks(static_cast<std::int64_t>(std::clamp(pixels, 0.0, as_double(grants.all())))));
    }

    void add_room(Rival& rival, const RivalGrants& grants) const {
        for (std::int64_t at = 0; at < count_; ++at) {
            const std::int64_t portion = jobs_.first() + at;
            const auto latest = static_cast<std::int64_t>(std::floor(jobs_.latest_start(portion)));
            const std::int64_t now = latest - machine_.busready_cycles + buffer_.shifts[rival.row].earlier;
            std::int64_t room = grants.at_most(grants.released_before(now + 1));
            if (!machine_.has_sure_slots()) {
                const std::int64_t bursts =
                    grants.bursts_due_by(jobs_.segment().first_use(jobs_.next_pixel_at_most(portion)));
                room = std::min(room, grants.of_bursts(machine_.whole_bursts() ? bursts : bursts + 1));
            }
            rival.room.push_back(grants.clocks(room));
        }
    }

    /// True if no portion of `until` can be late because of a wait that began at a portion of `from`. One of a rival's
    /// two limits is chosen for the whole block. If the block then fails, it is divided.
    bool holds(Range from, Range until) {
        if (from.size() <= 0 || until.size() <= 0 || from.begin >= until.end) return true;
        from.end = std::min(from.end, until.end);
        if (late_by(from, until) <= kRounding) return true;
        if (from.size() == 1 && until.size() == 1) return from.begin > until.begin;
        if (work_left_ < 0) return false;
        const Range early{from.begin, from.middle()};
        const Range late{from.middle(), from.end};
        const Range soon{until.begin, until.middle()};
        const Range after{until.middle(), until.end};
        return holds(early, soon) && holds(late, after) && holds(early, after) && holds(late, soon);
    }

    double overrun() const { return table_.users()[row_].overrun_cycles; }

    double late_by(Range from, Range until) {
        const auto a = static_cast<std::size_t>(from.inside());
        const auto b = static_cast<std::size_t>(until.inside());
        const double grants = as_double(std::max<std::int64_t>(0, until.inside() - from.inside() + 1));
        double slot_rate = machine_.has_sure_slots() ? 0.0 : overrun();
        double constant = 0.0;
        by_room_.clear();
        for (const Rival& rival : rivals_) {
            const double by_slots = rival.slot_rate * grants + rival.slot_spread;
            const double by_room = rival.room[b] - rival.granted[a] + rival.slack;
            if (machine_.has_sure_slots() && by_slots <= by_room) {
                slot_rate += rival.slot_rate;
                constant += rival.slot_spread;
            } else {
                by_room_.push_back(&rival);
                constant += rival.slack;
            }
        }
        // Those that are counted by their slots may also have others' while the composer is passed over.
        if (machine_.has_sure_slots() && by_room_.size() < rivals_.size()) slot_rate += overrun();
        double latest_from = kNever;
        for (std::int64_t at = from.begin; at < from.end; ++at) {
            const auto i = static_cast<std::size_t>(at);
            double clocks = from_[i] - slot_rate * as_double(at);
            for (const Rival* rival : by_room_) clocks -= rival->granted[i];
            latest_from = std::max(latest_from, clocks);
        }
        double latest_until = kNever;
        for (std::int64_t at = until.begin; at < until.end; ++at) {
            const auto i = static_cast<std::size_t>(at);
            if (until_[i] == kNever) continue;
            double clocks = until_[i] + slot_rate * as_double(at + 1);
            for (const Rival* rival : by_room_) clocks += rival->room[i];
            latest_until = std::max(latest_until, clocks);
        }
        work_left_ -= from.size() + until.size();
        return latest_from + latest_until + constant;
    }

    const BusTable& table_;
    const MachineFigures& machine_;
    std::size_t row_;
    const Jobs& jobs_;
    const BufferCase& buffer_;
    std::int64_t count_ = 0;
    std::vector<double> from_;
    std::vector<double> until_;
    std::vector<Rival> rivals_;
    std::int64_t work_left_ = 0;
    std::vector<const Rival*> by_room_;
};

}  // namespace

bool rival_rule(const BusTable& table, std::size_t row, const Jobs& jobs, const BufferCase& buffer,
                const PortionFlags& known) {
    return RivalRule(table, row, jobs, buffer, known).holds();
}

}  // namespace metabuffer::analysis
