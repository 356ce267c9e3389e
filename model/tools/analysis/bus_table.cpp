#include "tools/analysis/bus_table.h"

#include <algorithm>
#include <utility>

#include "scenario/derived_timing.h"

namespace metabuffer::analysis {

MachineFigures::MachineFigures(const Scenario& scenario, const ArbitrationRow& policy)
    : raster_width(scenario.displays.raster_width_pixels()),
      raster_pixels(raster_width * scenario.displays.raster_height_pixels()),
      burst_pixels(scenario.bus.burst_pixels),
      ready_space(scenario.composer.ready_space_pixels),
      smoothing(scenario.composer.smoothing),
      pixels_per_beat(metabuffer::pixels_per_beat(scenario.bus, scenario.memory)),
      cycles_per_beat(metabuffer::cycles_per_beat(scenario.bus)),
      page_miss_cycles(scenario.memory.page_miss_cycles),
      lost_slot_cycles(scenario.bus.grant_cycles + metabuffer::lost_slot_cycles(scenario)),
      in_flight_pixels(metabuffer::in_flight_pixels(scenario.bus, scenario.memory)),
      delay_cycles(bus_delay_cycles(scenario.bus, scenario.memory)),
      loop_cycles(bus_loop_cycles(scenario.bus, scenario.memory)),
      busready_cycles(2 + scenario.bus.register_stages),
      interrupted(scenario.memory.refreshes() || scenario.memory.shared()),
      grant_cycles(scenario.bus.grant_cycles),
      policy(policy) {}

/// Each row of the source is released in one stretch, with a pause after it. The burst is the most by which that runs
/// ahead of its average, from the beginning of any stretch to the end of the same or a later one. A smoothed row is
/// released at an even pace too, except for its first and last pixels, of which several may go at once, or all of it goes at
/// once at the bottom of the raster.
ReleaseCurve::ReleaseCurve(const Segment& segment, std::int64_t raster_width) {
    const ViewportRow& row = segment.row();
    rate = static_cast<double>(row.sdx) /
           (static_cast<double>(row.dmultiple) * static_cast<double>(raster_width));
    first = segment.last_use(0);
    last = segment.last_use(segment.pixels() - 1) + 1;
    double least = 0.0;
    for (std::int64_t j = 0; j < row.sdy; ++j) {
        const auto ahead = [&](std::int64_t released, std::int64_t position) {
            return static_cast<double>(released) - rate * static_cast<double>(position - first);
        };
        const auto pass = [&](std::int64_t k) {
            const std::int64_t position = segment.last_use(k);
            // A pixel is released in the clock of its last use, so a window that has it may begin there.
            least = std::min(least, ahead(k, position));
            burst = std::max(burst, ahead(k + 1, position + 1) - least);
        };
        const std::int64_t begin = j * row.sdx;
        const std::int64_t edge = segment.smooths() ? std::min<std::int64_t>(kUnevenPixels, row.sdx) : 1;
        for (std::int64_t i = 0; i < edge; ++i) pass(begin + i);
        for (std::int64_t i = edge; i > 0; --i) pass(begin + row.sdx - i);
    }
    // Within a stretch, a pixel that the raster's left edge cuts short is released sooner than the rest.
    burst += 1.0;
}

BusTable::BusTable(const Scenario& scenario, const MachineFigures& machine, int renderer,
                   const ViewportTable& rows, std::vector<int> slots)
    : machine_(machine), renderer_(renderer) {
    const Renderer& source = scenario.renderers[static_cast<std::size_t>(renderer)];
    find_first_word(source, scenario.memory, rows);
    taken_ = taken_clocks(scenario, static_cast<std::size_t>(renderer), first_word_ == FirstWord::kMisses);
    if (!slots.empty()) {
        build_cycles_ = static_cast<double>(scenario.bus.build_cycles(slots.size()));
        const RepeatedSlot repeated = repeated_slot(slots);
        shares_ = SlotShares(std::move(slots), rows.size(), repeated);
    }
    users_.reserve(rows.size());
    for (const ViewportRow& row : rows) add_user(scenario, source, row);
    if (users_.empty()) return;
    for (const BusUser& user : users_)
        residual_cycles_ = std::max(residual_cycles_, user.costs.longest() - 1.0);
    if (!machine_.work_conserving())
        residual_cycles_ = std::max(residual_cycles_, stretched(machine_.lost_slot_cycles));
    residual_cycles_ += passed_over_cycles() + interruption_cycles();
    if (first_word_ == FirstWord::kHits) residual_cycles_ += stretched(machine_.page_miss_cycles);
    find_overruns();
    if (!machine_.has_sure_slots()) return;
    find_waits();
    if (knows_rivals()) find_rivalries();
}

void BusTable::find_first_word(const Renderer& renderer, const MemoryConfig& memory,
                               const ViewportTable& rows) {
    first_word_ = rows.size() == 1 ? FirstWord::kExact : FirstWord::kMisses;
    if (rows.empty()) return;
    const auto address = [&](std::int64_t x, std::int64_t y) { return y * renderer.image_width_pixels + x; };
    std::int64_t lowest = address(rows.front().sx, rows.front().sy);
    std::int64_t highest = lowest;
    for (const ViewportRow& row : rows) {
        lowest = std::min(lowest, address(row.sx, row.sy));
        highest = std::max(highest, address(row.sx + row.sdx - 1, row.sy + row.sdy - 1));
    }
    if (lowest / memory.page_words == highest / memory.page_words) first_word_ = FirstWord::kHits;
}

/// With a loop, composers are passed over for some clocks after each burst. Under a policy that loses slots, they miss no
/// slot if enough slots of others come between, each of a clock or more.
RepeatedSlot BusTable::repeated_slot(const std::vector<int>& slots) const {
    if (machine_.loop_cycles == 0) {
        if (!machine_.single_beats()) return RepeatedSlot::kGranted;
        return machine_.work_conserving() ? RepeatedSlot::kSkipped : RepeatedSlot::kLost;
    }
    if (machine_.work_conserving()) return RepeatedSlot::kDelayed;
    const auto apart = static_cast<std::size_t>(machine_.passed_over_cycles());
    for (std::size_t slot = 0; slot < slots.size(); ++slot) {
        for (std::size_t step = 1; step <= apart; ++step) {
            if (slots[(slot + step) % slots.size()] == slots[slot]) return RepeatedSlot::kDelayed;
        }
    }
    return RepeatedSlot::kGranted;
}

/// None if a composer gets its next slot all the same.
double BusTable::passed_over_cycles() const {
    const bool keeps_slots = machine_.has_sure_slots() && shares_.repeated() == RepeatedSlot::kGranted;
    return machine_.loop_cycles > 0 && keeps_slots ? 0.0 : stretched(machine_.passed_over_cycles());
}

/// What begins last while the composer is passed over is a burst of one of the slots before the composer's own next one,
/// which are counted. But without slots it may be any burst, and where slots are lost it may be a lost one of its own.
void BusTable::find_overruns() {
    if (machine_.loop_cycles == 0 || passed_over_cycles() == 0.0) return;
    for (std::size_t i = 0; i < users_.size(); ++i) {
        double longest = machine_.work_conserving() ? 1.0 : stretched(machine_.lost_slot_cycles);
        for (std::size_t j = 0; j < users_.size(); ++j) {
            if (j != i && !machine_.has_sure_slots()) longest = std::max(longest, users_[j].costs.longest());
        }
        users_[i].overrun_cycles = longest - 1.0;
    }
}

BusTable::SureBursts BusTable::sure_bursts(std::size_t row) const {
    const BusUser& user = users_[row];
    // Each burst takes more if the composer is passed over, and the last one must have ended.
    const double each = user.slot_average + std::max(1.0, passed_over_cycles()) + user.wait.rate;
    const double once = residual_cycles_ + user.wait.spread + user.slot_excess + user.costs.longest();
    return {1.0 / each, once / each + 1.0};
}

double BusTable::cut_cycles() const {
    const std::int64_t page_miss = first_word_ == FirstWord::kMisses ? machine_.page_miss_cycles : 0;
    return stretched(machine_.grant_cycles + page_miss + machine_.cycles_per_beat + 1);
}

/// A composer that took a slot has its ready space free. It cuts the burst when fewer pixels are free after a beat than
/// may be in flight, and a page miss may then delay the next beat.
std::int64_t BusTable::least_cut_pixels() const {
    return std::max<std::int64_t>(1, machine_.ready_space - machine_.in_flight_pixels + 1);
}

void BusTable::add_user(const Scenario& scenario, const Renderer& renderer, const ViewportRow& row) {
    const Segment segment(row, scenario.displays.raster_width_pixels(),
                          scenario.displays.raster_height_pixels(), scenario.composer.smoothing);
    const int width = renderer.image_width_pixels;
    const FirstWord alone = first_word_ == FirstWord::kHits ? FirstWord::kHits : FirstWord::kExact;
    BusUser user{segment,
                 BurstCosts(segment, width, scenario.bus, scenario.memory, first_word_, stretch()),
                 BurstCosts(segment, width, scenario.bus, scenario.memory, alone, stretch()),
                 ReleaseCurve(segment, machine_.raster_width),
                 0.0,
                 0.0,
                 {},
                 {},
                 0.0};
    if (machine_.whole_bursts()) {
        user.slot_average = user.costs.average();
        user.slot_excess = user.costs.excess();
    } else {
        // Bursts begin anywhere. Each costs its pixels, as if no other composer's burst came between, and a cut.
        user.slot_average = user.stream.average() + cut_cycles();
        user.slot_excess = user.stream.average() + user.stream.excess();
    }
    user.portions.push_back(whole_burst_portions(user));
    // A burst that stands still for other reasons may be cut after fewer pixels than fit into the ready space.
    if (!machine_.whole_bursts() && machine_.loop_cycles == 0 && !machine_.interrupted)
        user.portions.push_back(cut_burst_portions(user));
    users_.push_back(std::move(user));
}

/// Portions of one burst each. If bursts may be cut short, they begin anywhere in a portion, but once there is room for
/// a whole burst they are not cut.
Portions BusTable::whole_burst_portions(const BusUser& user) const {
    const std::int64_t bursts = user.costs.bursts();
    double passed_over = passed_over_cycles();
    if (machine_.loop_cycles == 0 && machine_.single_beats() && !machine_.work_conserving())
        passed_over = stretched(machine_.lost_slot_cycles);
    Portions portions;
    portions.aligned = machine_.whole_bursts();
    portions.ready_space = machine_.uncut_space();
    for (std::int64_t b = 0; b <= bursts; ++b) {
        const std::int64_t first = std::min(b * machine_.burst_pixels, user.segment.pixels());
        const double longest = user.costs.longest();
        const auto grants = static_cast<double>(b);
        portions.first_pixel.push_back(first);
        portions.own_before.push_back(passed_over * grants +
                                      (portions.aligned ? user.costs.before(b) : longest * grants));
        if (b == bursts) break;
        portions.latest_start.push_back(
            portions.aligned
                ? user.costs.latest_start(b)
                : static_cast<double>(user.segment.first_use(first) - machine_.delay_cycles) - longest);
    }
    return portions;
}

/// Portions of as many pixels as pass, in full beats, before a composer with no more than its ready space free cuts the
/// burst. No portion goes past a page's end, since a beat ends there, too.
Portions BusTable::cut_burst_portions(const BusUser& user) const {
    const Segment& segment = user.segment;
    const std::int64_t full = machine_.ready_space / machine_.pixels_per_beat * machine_.pixels_per_beat;
    Portions portions;
    portions.aligned = false;
    portions.ready_space = machine_.ready_space;
    double own = 0.0;
    for (std::int64_t k = 0; k < segment.pixels();) {
        const std::int64_t in_page = user.costs.pixels_in_page(k);
        for (std::int64_t done = 0; done < in_page; done += full) {
            const std::int64_t pixels = std::min(full, in_page - done);
            const std::int64_t beats = (pixels + machine_.pixels_per_beat - 1) / machine_.pixels_per_beat;
            // On a bus of a beat a clock, a portion's first pixel has the least time. On a slower bus the last one
            // may have it. Of a smoothed segment, all of them may be needed at once.
            const std::int64_t last_pixel = segment.smooths() ? (beats - 1) * machine_.cycles_per_beat
                                                              : (pixels - 1) * (machine_.cycles_per_beat - 1);
            const auto in_time = static_cast<double>(machine_.grant_cycles + machine_.page_miss_cycles +
                                                     machine_.cycles_per_beat + last_pixel);
            portions.first_pixel.push_back(k + done);
            portions.latest_start.push_back(static_cast<double>(segment.first_use(k + done)) - in_time);
            portions.own_before.push_back(own);
            own +=
                static_cast<double>(beats * machine_.cycles_per_beat) + cut_cycles() +
                (done == 0 && first_word_ != FirstWord::kHits ? static_cast<double>(machine_.page_miss_cycles)
                                                              : 0.0);
        }
        k += in_page;
    }
    portions.first_pixel.push_back(segment.pixels());
    portions.own_before.push_back(own);
    return portions;
}

/// The clocks of a rival's slots have two limits: its longest burst for each slot, or its average burst for each and
/// its excess once. The lesser of the two counts.
void BusTable::find_waits() {
    const bool lost = !machine_.work_conserving();
    const double lost_cycles = lost ? stretched(machine_.lost_slot_cycles) : 0.0;
    std::vector<double> longest;
    std::vector<double> average;
    double excess = 0.0;
    for (const BusUser& user : users_) {
        longest.push_back(std::max(user.costs.longest(), lost_cycles));
        average.push_back(user.slot_average);
        excess += user.slot_excess;
    }
    for (std::size_t i = 0; i < users_.size(); ++i) {
        BusUser& user = users_[i];
        user.wait = shares_.wait(i, longest, lost_cycles);
        user.wait.rate += user.overrun_cycles;
        if (lost) continue;  // a lost slot may take longer than the average burst
        SlotShares::Wait mean = shares_.wait(i, average, lost_cycles);
        const double others = excess - user.slot_excess;
        user.wait.rate = mean.rate + user.overrun_cycles;
        user.wait.spread = mean.spread + others;
        for (std::size_t m = 1; m < mean.most.size(); ++m) {
            user.wait.most[m] = std::min(user.wait.most[m], mean.most[m] + others);
        }
    }
}

void BusTable::find_rivalries() {
    rivalries_.resize(users_.size() * users_.size());
    std::vector<double> only_rival(users_.size(), 0.0);
    for (std::size_t row = 0; row < users_.size(); ++row) {
        for (std::size_t rival = 0; rival < users_.size(); ++rival) {
            if (rival == row) continue;
            Rivalry& rivalry = rivalries_[row * users_.size() + rival];
            rivalry.fairness = shares_.fairness(row, rival);
            only_rival[rival] = users_[rival].slot_average;
            const SlotShares::Wait wait = shares_.wait(row, only_rival, 0.0);
            only_rival[rival] = 0.0;
            rivalry.slot_rate = wait.rate;
            rivalry.slot_spread = wait.spread + users_[rival].slot_excess;
        }
    }
}

}  // namespace metabuffer::analysis
