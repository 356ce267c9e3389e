#include "tools/analysis/starvation_rules.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "tools/analysis/arithmetic.h"
#include "tools/analysis/rival_rule.h"

namespace metabuffer::analysis {
namespace {

/// Checks the burst under way when the column starts: its pixels after those that made the composer prefetched.
bool first_burst_in_time(const BusTable& table, const BusUser& me, std::int64_t buffer_pixels) {
    const MachineFigures& machine = table.machine();
    const std::int64_t last_held = buffer_pixels - machine.ready_space;
    const std::int64_t pixels = me.segment.pixels();
    const auto asked_at = [&](std::int64_t k) { return as_double(me.segment.first_use(k) + 1); };
    if (machine.whole_bursts()) {
        const std::int64_t end =
            std::min((last_held / machine.burst_pixels + 1) * machine.burst_pixels, pixels);
        const double arrived = me.costs.until_pixel(last_held) - table.interruption_cycles();
        for (std::int64_t k = last_held + 1; k < end; ++k) {
            if (me.costs.until_pixel(k) - arrived > asked_at(k) + kRounding) return false;
        }
        return true;
    }
    std::int64_t cycles = 0;
    std::int64_t in_page = me.costs.pixels_in_page(last_held) - 1;
    const std::int64_t end = std::min(last_held + machine.burst_pixels, pixels);
    for (std::int64_t k = last_held + 1; k < end; ++k) {
        if (in_page == 0) {
            in_page = me.costs.pixels_in_page(k);
            cycles += machine.page_miss_cycles;
        }
        --in_page;
        cycles += machine.cycles_per_beat;
        if (table.stretch() * as_double(cycles) + table.interruption_cycles() > asked_at(k)) return false;
    }
    return true;
}

/// The rule of slots: from the last time that the composer was not ready, it gets its slots, whatever the others do.
void slot_rule(const BusTable& table, const BusUser& me, const Jobs& jobs, PortionFlags& known) {
    constexpr std::int64_t kNearGrants = 64;
    const SlotShares::Wait& wait = me.wait;
    const std::int64_t near = std::min(as_int(wait.most.size()) - 1, kNearGrants);
    const auto ready = [&](std::int64_t a) { return as_double(jobs.ready_at(a)) + table.residual_cycles(); };
    double far = kNever;  // over all portions before those that are checked one by one
    for (std::int64_t b = jobs.first(); b < jobs.count(); ++b) {
        if (b - near >= jobs.first()) {
            const std::int64_t a = b - near;
            far = std::max(far, ready(a) - jobs.own_before(a) - wait.rate * as_double(a));
        }
        double granted = far + jobs.own_before(b) + wait.rate * as_double(b + 1) + wait.spread;
        for (std::int64_t grants = 1; grants <= near && b - grants + 1 >= jobs.first(); ++grants) {
            const std::int64_t a = b - grants + 1;
            granted = std::max(granted, ready(a) + jobs.own_before(b) - jobs.own_before(a) +
                                            wait.most[static_cast<std::size_t>(grants)]);
        }
        if (granted <= jobs.latest_start(b) + kRounding) known[static_cast<std::size_t>(b)] = 1;
    }
}

/// The rule of polls. A poll is a clock in which no composer is ready. Since the last one, or since the column began if
/// there was none, the bus has been busy, and the others have taken no more than they had room for. The previous frame's
/// pixels have been composited by then.
///
/// On a bus with delays a composer that has room may be passed over. A poll is then a clock in which nobody has room. Since
/// the last one the bus is idle only after bursts, for the clocks in which their composers are passed over.
class PollRule {
  public:
    PollRule(const BusTable& table, std::size_t row, const Jobs& jobs, const BufferCase& buffer)
        : table_(table), machine_(table.machine()), row_(row), jobs_(jobs), buffer_(buffer) {
        const bool delayed = machine_.loop_cycles > 0;
        if (delayed) passed_over_ = table.passed_over_cycles();
        for (std::size_t j = 0; j < table.users().size(); ++j) {
            if (j != row) add_rival(j);
        }
        // On a bus with delays, a burst may be under way when nobody has room.
        constant_ += delayed ? table.residual_cycles() : table.interruption_cycles();
        if (table.first_word() == FirstWord::kHits)
            constant_ += table.stretch() * as_double(machine_.page_miss_cycles);
        add_polls();
        add_start();
    }

    void apply(PortionFlags& known) {
        std::size_t poll = 0;
        double busy = kNever;
        for (std::int64_t b = jobs_.first(); b < jobs_.count(); ++b) {
            const double latest = jobs_.latest_start(b);
            const double seen = latest - as_double(machine_.busready_cycles);
            while (poll < polls_.size() && polls_[poll].position <= seen) {
                busy = std::max(busy, polls_[poll].clocks);
                ++poll;
            }
            const bool freed = as_double(jobs_.freed_at(b)) <= seen;
            const bool since_poll =
                busy + jobs_.own_before(b) + rivals_before(seen) + constant_ <= latest + kRounding;
            if (freed && since_poll && in_time_without_poll(b)) known[static_cast<std::size_t>(b)] = 1;
        }
    }

  private:
    struct Rival {
        std::size_t row = 0;
        double clocks_per_pixel = 0.0;
        double rate = 0.0;
        double first = 0.0;  ///< it releases between these positions of the composer's own column
        double last = 0.0;
        double granted_at_start = 0.0;  ///< clocks of its grants until the composer is prefetched
    };
    struct Poll {
        double position = 0.0;
        double clocks = 0.0;
    };

    void add_rival(std::size_t j) {
        const BusUser& user = table_.users()[j];
        const std::int64_t held = buffer_.buffer_pixels - machine_.ready_space + 1;
        if (user.segment.pixels() <= held) {
            // Once it has been full it holds its whole segment.
            rivals_.push_back({j, 0.0, 0.0, 0.0, 0.0, 0.0});
            return;
        }
        const double per_pixel = (user.costs.average() + passed_over_) / as_double(machine_.burst_pixels);
        const ColumnShift& shift = buffer_.shifts[j];
        rivals_.push_back({j, per_pixel, user.releases.rate, as_double(user.releases.first - shift.earlier),
                           as_double(user.releases.last + shift.later), 0.0});
        constant_ +=
            per_pixel * (user.releases.burst + as_double(machine_.burst_pixels - 1)) + user.costs.excess();
    }

    double rivals_before(double position) const {
        double clocks = 0.0;
        for (const Rival& rival : rivals_) {
            clocks += rival.clocks_per_pixel * rival.rate *
                      (std::clamp(position, rival.first, rival.last) - rival.first);
        }
        return clocks;
    }

    /// Adds the positions at which a poll can be the worst: between them the sums are straight lines.
    void add_polls() {
        const double known_cycles = as_double(machine_.busready_cycles + 1);
        const auto add = [&](double position, std::int64_t next) {
            if (next >= jobs_.count()) return;
            polls_.push_back(
                {position, position + known_cycles - rivals_before(position) - jobs_.own_before(next)});
        };
        for (std::int64_t a = jobs_.first(); a < jobs_.count(); ++a) {
            add(as_double(jobs_.freed_at(a) - 1), a);
            if (a > jobs_.first()) add(as_double(jobs_.freed_at(a - 1)), a);
        }
        for (const Rival& rival : rivals_) {
            if (rival.rate == 0.0) continue;
            for (const double end : {rival.first, rival.last}) {
                for (const double position : {std::floor(end), std::floor(end) + 1.0}) {
                    add(position, jobs_.first_freed_after(static_cast<std::int64_t>(position)));
                }
            }
        }
        std::sort(polls_.begin(), polls_.end(),
                  [](const Poll& a, const Poll& b) { return a.position < b.position; });
    }

    /// Finds the clocks that the bus has worked when the composer is prefetched.
    void add_start() {
        const BusUser& me = table_.users()[row_];
        const std::int64_t last_held = buffer_.buffer_pixels - machine_.ready_space;
        const std::int64_t grants = last_held / machine_.burst_pixels + 1;
        start_clocks_ =
            jobs_.own_before(grants - 1) + me.costs.until_pixel(last_held) - table_.residual_cycles();
        for (Rival& rival : rivals_) {
            const std::int64_t bursts = bursts_beside(rival.row, grants);
            rival.granted_at_start =
                table_.users()[rival.row].costs.before(bursts) + passed_over_ * as_double(bursts);
        }
    }

    /// The least bursts that a rival has had when the composer gets its `grants`-th one.
    std::int64_t bursts_beside(std::size_t j, std::int64_t grants) const {
        const RivalGrants rival(table_, j, buffer_.buffer_pixels);
        const std::int64_t full = rival.when_full(0) / machine_.burst_pixels;
        double bursts = 0.0;
        if (machine_.has_sure_slots()) {
            const SlotShares::Fairness& fairness = table_.rivalry(row_, j).fairness;
            bursts = std::floor(fairness.rate * as_double(grants) - fairness.loss);
        } else if (machine_.loop_cycles == 0) {
            const std::int64_t pixel = (grants - 1) * machine_.burst_pixels;
            bursts = as_double(rival.bursts_due_before(table_.users()[row_].segment.first_use(pixel)));
        }
        bursts = std::min(bursts, as_double(full));
        if (buffer_.follows_a_frame) {
            const double held = as_double(buffer_.buffer_pixels - machine_.ready_space + 1);
            bursts = std::min(
                bursts, std::floor((held - buffer_.refill_pixels[j]) / as_double(machine_.burst_pixels)));
        }
        return static_cast<std::int64_t>(std::clamp(bursts, 0.0, as_double(full)));
    }

    bool in_time_without_poll(std::int64_t b) const {
        const double latest = jobs_.latest_start(b);
        double clocks = jobs_.own_before(b) - start_clocks_;
        for (const Rival& rival : rivals_) {
            const RivalGrants grants(table_, rival.row, buffer_.buffer_pixels);
            const double position =
                latest - as_double(machine_.busready_cycles) + as_double(buffer_.shifts[rival.row].earlier);
            const std::int64_t released =
                grants.released_before(static_cast<std::int64_t>(std::floor(position)) + 1);
            const std::int64_t pixels = grants.at_most(released);
            const double all =
                grants.clocks(pixels) + passed_over_ * as_double(pixels / machine_.burst_pixels);
            clocks += std::max(0.0, all - rival.granted_at_start);
        }
        return clocks < latest + 2.0 - kRounding;
    }

    const BusTable& table_;
    const MachineFigures& machine_;
    std::size_t row_;
    const Jobs& jobs_;
    const BufferCase& buffer_;
    std::vector<Rival> rivals_;
    std::vector<Poll> polls_;
    double constant_ = 0.0;
    double start_clocks_ = 0.0;
    double passed_over_ = 0.0;  ///< clocks after each burst, on a bus with delays
};

bool all_known(const PortionFlags& known, const Jobs& jobs) {
    return std::all_of(known.begin() + std::min(jobs.first(), jobs.count()), known.end(),
                       [](char flag) { return flag != 0; });
}

bool in_time(const BusTable& table, std::size_t row, const Portions& portions, const BufferCase& buffer) {
    const MachineFigures& machine = table.machine();
    const BusUser& me = table.users()[row];
    const Jobs jobs(me, portions, machine, buffer.buffer_pixels);
    PortionFlags known(static_cast<std::size_t>(jobs.count()), 0);
    if (machine.has_sure_slots()) slot_rule(table, me, jobs, known);
    if (all_known(known, jobs)) return true;
    if (!machine.work_conserving() || !table.knows_rivals()) return false;
    if (machine.whole_bursts()) PollRule(table, row, jobs, buffer).apply(known);
    return all_known(known, jobs) || rival_rule(table, row, jobs, buffer, known);
}

}  // namespace

bool is_starvation_free(const BusTable& table, std::size_t row, const BufferCase& buffer) {
    const MachineFigures& machine = table.machine();
    const BusUser& me = table.users()[row];
    const std::int64_t held = buffer.buffer_pixels - machine.ready_space + 1;
    if (me.segment.pixels() <= held) return true;
    if (!machine.has_bound()) return false;
    if (!first_burst_in_time(table, me, buffer.buffer_pixels)) return false;
    return std::any_of(me.portions.begin(), me.portions.end(),
                       [&](const Portions& portions) { return in_time(table, row, portions, buffer); });
}

}  // namespace metabuffer::analysis
