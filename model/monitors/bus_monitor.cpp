#include "monitors/bus_monitor.h"

#include <algorithm>

namespace metabuffer::monitors {
namespace {

constexpr int kTableRowBits = 128;

}  // namespace

BusMonitor::BusMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
                       ViolationLog& log)
    : sc_core::sc_module(name),
      busready_i("busready_i", static_cast<std::size_t>(scenario.displays.count())),
      tableready_i("tableready_i", static_cast<std::size_t>(scenario.displays.count())),
      bus_("bus " + std::to_string(renderer + 1) + ": "),
      displays_(scenario.displays.count()),
      frames_(scenario.frames),
      raster_width_(scenario.displays.raster_width_pixels()),
      raster_height_(scenario.displays.raster_height_pixels()),
      smoothing_(scenario.composer.smoothing),
      image_width_(scenario.renderers[static_cast<std::size_t>(renderer)].image_width_pixels),
      image_height_(scenario.renderers[static_cast<std::size_t>(renderer)].image_height_pixels),
      page_words_(scenario.memory.page_words),
      memory_(scenario.memory),
      timing_(scenario),
      latency_cycles_(scenario.memory.read_latency_cycles),
      waits_are_known_(!scenario.memory.shared()),
      grant_cycles_(scenario.bus.grant_cycles),
      burst_pixels_(scenario.bus.burst_pixels),
      buffer_pixels_(scenario.composer.buffer_pixels),
      ready_space_pixels_(scenario.composer.ready_space_pixels),
      cycles_per_row_(std::max(1, kTableRowBits / scenario.bus.width_bits)),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      reporter_(log),
      levels_(static_cast<std::size_t>(displays_)),
      tables_ready_(latency_cycles_, false),
      rows_(static_cast<std::size_t>(displays_)),
      announced_(static_cast<int>(timing_.loop_cycles), 0),
      counted_from_(static_cast<std::size_t>(displays_)) {}

void BusMonitor::end_of_elaboration() {
    bus_name_ = signal_name(bus_i);
    for (const auto& port : busready_i) {
        busready_names_.push_back(signal_name(port));
    }
}

void BusMonitor::violate(const char* rule, const std::string& signal, std::int64_t edge,
                         const std::string& detail) {
    reporter_.report(rule, rule, signal, edge + latency_cycles_, frames_started_ - 1, bus_ + detail);
}

void BusMonitor::restart() {
    for (auto& levels : levels_) {
        levels.clear();
    }
    std::fill(rows_.begin(), rows_.end(), Row{});
    tables_taken_ = active_ = stopped_ = false;
    table_complete_ = true;
    frames_started_ = 0;
    pixels_left_ = 0;
    first_edge_ = kNone;
    table_counted_from_ = 0;
    tables_ready_.fill(false);
    announced_.fill(0);
    std::fill(counted_from_.begin(), counted_from_.end(), 0);
}

void BusMonitor::clock_edge() {
    if (reset_i.read()) {
        clocked_.stay_awake();
        restart();
        return;
    }
    const std::int64_t now = rtl::clock_edge_number(core_period_picoseconds_);
    if (first_edge_ == kNone) {
        first_edge_ = now;
    }
    sample_busready(now);
    // Everything is checked at the edge that would sample the beat if words had no latency.
    const std::int64_t edge = now - latency_cycles_;
    // What BUSREADY answers at that edge: it was written at the edge before, for the pixels announced then.
    const std::int64_t announced = announced_.pass(active_ ? remaining_ : 0);
    const std::int64_t bursts_before = bursts_;
    const rtl::BusBeat& beat = bus_i.read();
    check_frame_number(beat, edge);
    switch (beat.kind) {
        case rtl::BusBeat::Kind::kNone:
            break;
        case rtl::BusBeat::Kind::kFrameStart:
            take_frame_start(beat, edge);
            break;
        case rtl::BusBeat::Kind::kTableRow:
            take_row(beat, edge);
            break;
        case rtl::BusBeat::Kind::kPixels:
            take_pixels(beat, edge);
            break;
    }
    check_overdue(edge);
    stop_on_busready(edge, bursts_ == bursts_before ? announced : 0);
    const bool between_frames = table_complete_ && pixels_left_ == 0;
    const bool ready = std::all_of(tableready_i.begin(), tableready_i.end(),
                                   [](const sc_core::sc_in<bool>& port) { return port.read(); });
    const bool was_ready = tables_ready_.pass(ready);
    tables_taken_ = was_ready || !between_frames;
    const bool settled = was_ready == ready && tables_ready_.settled(ready) && announced_.settled(0);
    if (beat.kind != rtl::BusBeat::Kind::kNone || active_ || !table_complete_ || !settled) {
        clocked_.stay_awake();
    }
}

// ---- BUSREADY as it was ----

void BusMonitor::sample_busready(std::int64_t edge) {
    for (std::size_t d = 0; d < levels_.size(); ++d) {
        std::deque<Level>& levels = levels_[d];
        const bool high = busready_i[d].read();
        if (!levels.empty() && levels.back().high == high) {
            continue;
        }
        levels.push_back({edge, high});
        // No grant that is still to be checked is earlier than this.
        const std::int64_t oldest_grant =
            edge - latency_cycles_ - grant_cycles_ - timing_.longest_wait_cycles - timing_.beat_cycles;
        while (levels.size() > 1 && levels[1].edge <= oldest_grant) {
            levels.pop_front();
        }
    }
}

bool BusMonitor::busready_at(std::size_t display, std::int64_t edge) const {
    const std::deque<Level>& levels = levels_[display];
    const auto level = std::find_if(levels.rbegin(), levels.rend(),
                                    [edge](const Level& candidate) { return candidate.edge <= edge; });
    return level != levels.rend() && level->high;
}

// ---- the table ----

void BusMonitor::check_frame_number(const rtl::BusBeat& beat, std::int64_t edge) {
    const bool starts = beat.kind == rtl::BusBeat::Kind::kFrameStart;
    const int frame = starts ? frames_started_ : frames_started_ - 1;
    if (beat.kind == rtl::BusBeat::Kind::kNone || frame < 0 ||
        beat.frame == static_cast<std::uint32_t>(frame)) {
        return;
    }
    violate("bus/frame-number", edge,
            "a beat of frame " + std::to_string(beat.frame) + ", not " + std::to_string(frame));
}

void BusMonitor::take_frame_start(const rtl::BusBeat& beat, std::int64_t edge) {
    const std::int64_t left = pixels_left_;
    if (!table_complete_) {
        violate("bus/incomplete", edge, "a frame starts while the table before is not complete");
    } else if (left > 0) {
        violate(
            "bus/incomplete", edge,
            "a frame starts while " + std::to_string(left) + " pixels of the one before have not been sent");
    }
    ++frames_started_;
    if (frames_started_ > frames_) {
        violate("bus/frames", edge,
                "frame " + std::to_string(frames_started_) + " of " + std::to_string(frames_) + " starts");
    }
    if (!tables_taken_) {
        violate("bus/tableready", edge,
                "a frame starts after an edge at which not every TABLEREADY was high");
    } else if (edge <= table_counted_from_) {
        violate("bus/tableready", edge, "a frame starts before TABLEREADY counts the one before");
    }
    table_counted_from_ = edge + 1 + timing_.loop_cycles;
    std::fill(rows_.begin(), rows_.end(), Row{});
    rows_taken_ = pixels_left_ = 0;
    active_ = stopped_ = false;
    banks_.assign(static_cast<std::size_t>(memory_.banks), Bank{});
    table_complete_ = beat.last;
    table_edge_ = free_from_ = edge;
}

void BusMonitor::take_row(const rtl::BusBeat& beat, std::int64_t edge) {
    if (table_complete_) {
        violate("bus/table", edge,
                frames_started_ == 0 ? "a table row before a frame's start"
                                     : "a table row after the table's last");
    } else if (edge != table_edge_ + cycles_per_row_) {
        violate("bus/table", edge,
                "a table row " + std::to_string(edge - table_edge_) + " clocks after the beat before, not " +
                    std::to_string(cycles_per_row_));
    }
    if (beat.first != rows_taken_) {
        violate("bus/row-number", edge,
                "row " + std::to_string(beat.first) + " where " + std::to_string(rows_taken_) + " was next");
    }
    ++rows_taken_;
    enter_row(beat.row(), edge);
    table_complete_ = table_complete_ || beat.last;
    table_edge_ = free_from_ = edge;
}

void BusMonitor::enter_row(const ViewportRow& row, std::int64_t edge) {
    const std::string subject = "a row for display " + std::to_string(row.dcomp);
    if (row.dcomp < 1 || row.dcomp > displays_) {
        violate("bus/row", edge, subject + ": there are " + std::to_string(displays_));
        return;
    }
    Row& entry = rows_[row.dcomp - std::size_t{1}];
    if (entry.present) {
        violate("bus/row", edge, subject + ", which has one");
        pixels_left_ -= entry.pixels - entry.sent;
    }
    const SegmentPositions positions(row, raster_width_, raster_height_, smoothing_);
    const std::int64_t window_rows = smoothing_ == Smoothing::kBilinear ? 2 : 1;
    // A pixel that the composer waits for is the only one of its window that it does not hold.
    const std::int64_t window = row.dmultiple > 1 ? window_rows * row.sdx - 1 : 0;
    if (!positions.legal() || row.sx + row.sdx > image_width_ || row.sy + row.sdy > image_height_) {
        violate("bus/row", edge, subject + " that its image or its raster does not hold");
    } else if (buffer_pixels_ < ready_space_pixels_ + window) {
        violate("bus/row", edge, subject + " that the composer's buffer can never serve");
    }
    entry.present = true;
    entry.first_word = row.sy * image_width_ + row.sx;
    entry.width = std::max<std::int64_t>(row.sdx, 1);
    entry.pixels = positions.pixels();
    entry.sent = 0;
    pixels_left_ += entry.pixels;
}

// ---- pixels ----

std::int64_t BusMonitor::address_of(const Row& row, std::int64_t pixel) const {
    return row.first_word + pixel / row.width * image_width_ + pixel % row.width;
}

std::int64_t BusMonitor::page_of(const Row& row, std::int64_t pixel) const {
    return address_of(row, pixel) / page_words_;
}

/// Pixels of one page, from `pixel` on, that one beat carries when `left` of the burst are to come.
std::int64_t BusMonitor::beat_size(const Row& row, std::int64_t pixel, std::int64_t left) const {
    const std::int64_t most = std::min(timing_.beat_pixels, left);
    const std::int64_t page = page_of(row, pixel);
    std::int64_t count = 1;
    while (count < most) {
        // To the end of the source row, or of the page in it.
        const std::int64_t in_row = row.width - (pixel + count - 1) % row.width - 1;
        const std::int64_t in_page = (page + 1) * page_words_ - address_of(row, pixel + count - 1) - 1;
        if (in_row > 0) {
            if (in_page == 0) {
                break;
            }
            count += std::min({in_row, in_page, most - count});
        } else if (page_of(row, pixel + count) == page) {
            ++count;
        } else {
            break;
        }
    }
    return count;
}

void BusMonitor::take_pixels(const rtl::BusBeat& beat, std::int64_t edge) {
    if (!table_complete_) {
        violate("bus/table", edge, "pixels before the table is complete");
        table_complete_ = true;
    }
    const std::size_t display = beat.destination - std::size_t{1};
    if (beat.destination < 1 || beat.destination > displays_ || !rows_[display].present) {
        violate("bus/destination", edge,
                "pixels for display " + std::to_string(beat.destination) + ", which has no row in the table");
        return;
    }
    Row& row = rows_[display];
    if (active_ && display != display_) {
        violate("bus/one-burst", edge,
                "a beat for display " + std::to_string(beat.destination) + " in a burst for display " +
                    std::to_string(static_cast<std::int64_t>(display_) + 1) + " of which " +
                    std::to_string(remaining_) + " pixels are to come");
        active_ = false;
        free_from_ = edge - timing_.beat_cycles;
    }
    pixels_sent_ += beat.count;
    check_order(beat, row, edge);
    if (row.pixels == row.sent) {
        violate("bus/beyond", edge,
                "a pixel for display " + std::to_string(beat.destination) +
                    " after the last of its segment of " + std::to_string(row.pixels));
        return;
    }
    const std::int64_t left = burst_left(beat, row, edge);
    const std::int64_t count = beat_size(row, row.sent, left);
    if (beat.count != count) {
        violate("bus/count", edge,
                std::to_string(beat.count) + " pixels in a beat, not " + std::to_string(count));
    }
    const std::int64_t taken = std::min<std::int64_t>(beat.count, row.pixels - row.sent);
    if (beat.count > taken) {
        violate("bus/beyond", edge,
                "pixels for display " + std::to_string(beat.destination) +
                    " after the last of its segment of " + std::to_string(row.pixels));
    }
    const std::int64_t remaining = stopped_ ? 0 : std::max<std::int64_t>(left - beat.count, 0);
    if (beat.remaining != remaining) {
        violate("bus/remaining", edge,
                std::to_string(beat.remaining) + " pixels of the burst announced after a beat, not " +
                    std::to_string(remaining));
    }
    const std::int64_t page = page_of(row, row.sent);
    set_open_page(page, page, edge - timing_.beat_cycles);
    row.sent += taken;
    pixels_left_ -= taken;
    remaining_ = remaining;
    if (remaining_ == 0) {
        end_burst(edge);
    } else {
        expect_next(row, edge);
    }
}

void BusMonitor::check_order(const rtl::BusBeat& beat, const Row& row, std::int64_t edge) {
    const std::int64_t difference = std::int64_t{beat.first} - row.sent;
    if (difference != 0) {
        violate("bus/order", edge,
                "pixel " + std::to_string(beat.first) + " for display " + std::to_string(beat.destination) +
                    " where " + std::to_string(row.sent) + " was next: " +
                    (difference > 0 ? std::to_string(difference) + " are lost"
                                    : std::to_string(-difference) + " come twice"));
    }
}

/// Pixels of its burst from this beat on, the beat's included; a new burst if none is under way.
std::int64_t BusMonitor::burst_left(const rtl::BusBeat& beat, const Row& row, std::int64_t edge) {
    if (active_) {
        const bool in_time =
            waits_are_known_ ? edge == due_ : edge >= beat_edge_ + timing_.beat_cycles && edge <= due_;
        if (!in_time) {
            violate("bus/pace", edge,
                    "the burst's next beat " + std::to_string(edge - beat_edge_) +
                        " clocks after the one before, not " +
                        (waits_are_known_ ? "" : std::to_string(timing_.beat_cycles) + " to ") +
                        std::to_string(due_ - beat_edge_));
        }
        ++beats_;
        return remaining_;
    }
    check_grant(beat.destination - std::size_t{1}, page_of(row, row.sent), edge);
    active_ = true;
    stopped_ = false;
    announced_.fill(0);  // what was left of the burst before does not count
    display_ = beat.destination - std::size_t{1};
    beats_ = 1;
    ++bursts_;
    return std::min(burst_pixels_, row.pixels - row.sent);
}

/// The first beat of a burst is sampled at `edge`: checks when the grant was and whether it was allowed. A burst may
/// have waited for a refresh; any clock in which that wait may have begun is accepted.
void BusMonitor::check_grant(std::size_t display, std::int64_t page, std::int64_t edge) {
    const std::int64_t read = edge - timing_.beat_cycles;
    std::int64_t grant = kNone;
    for (std::int64_t wanted = read; wanted >= read - timing_.longest_wait_cycles; --wanted) {
        if (waits_are_known_ && read_clock(page, wanted) != read) {
            continue;
        }
        const std::int64_t possible = wanted - grant_cycles_;
        if (possible >= free_from_ && busready_at(display, possible) && possible >= counted_from_[display]) {
            return;
        }
        grant = std::max(grant, possible);
    }
    if (grant == kNone) {
        violate("bus/pace", edge,
                "a burst begins with a word of clock " + std::to_string(read) +
                    ", in which the memory can give none");
    } else if (grant < free_from_) {
        violate("bus/pace", edge,
                "a burst begins " + std::to_string(free_from_ - grant) +
                    " clocks too early after what came before");
    } else if (!busready_at(display, grant)) {
        violate("bus/busready", busready_names_[display], edge,
                "pixels for display " + std::to_string(static_cast<std::int64_t>(display) + 1) +
                    " in a slot of clock " + std::to_string(grant) + ", at which its BUSREADY was low");
    } else {
        violate("bus/passed-over", busready_names_[display], edge,
                "a slot of clock " + std::to_string(grant) + " for display " +
                    std::to_string(static_cast<std::int64_t>(display) + 1) +
                    ", whose BUSREADY did not count the beat before");
    }
}

/// How many refreshes have begun at this clock or before.
std::int64_t BusMonitor::refreshes_by(std::int64_t clock) const {
    return memory_.refreshes() ? (clock - first_edge_) / memory_.refresh_interval_cycles : 0;
}

std::int64_t BusMonitor::open_page_beside(std::int64_t page, std::int64_t clock) const {
    const Bank& bank = banks_[static_cast<std::size_t>(page) % banks_.size()];
    return bank.refreshes == refreshes_by(clock) ? bank.page : kNone;
}

void BusMonitor::set_open_page(std::int64_t page, std::int64_t state, std::int64_t clock) {
    banks_[static_cast<std::size_t>(page) % banks_.size()] = {state, refreshes_by(clock)};
}

std::int64_t BusMonitor::read_clock(std::int64_t page, std::int64_t wanted) const {
    const std::int64_t activating = memory_.page_miss_cycles - memory_.precharge_cycles;
    const std::int64_t open = open_page_beside(page, wanted);
    std::int64_t opening = 0;
    if (open != page) {
        opening = activating + (open == kNone ? 0 : memory_.precharge_cycles);
    }
    if (!memory_.refreshes()) {
        return wanted + opening;
    }
    const std::int64_t interval = memory_.refresh_interval_cycles;
    const std::int64_t newest = first_edge_ + refreshes_by(wanted) * interval;
    if (newest > first_edge_ && wanted < newest + memory_.refresh_cycles) {
        return newest + memory_.refresh_cycles + activating;
    }
    const std::int64_t next = newest + interval;
    return wanted + opening < next ? wanted + opening : next + memory_.refresh_cycles + activating;
}

void BusMonitor::expect_next(const Row& row, std::int64_t edge) {
    beat_edge_ = edge;
    next_page_ = page_of(row, std::min(row.sent, row.pixels - 1));
    due_ = (waits_are_known_ ? read_clock(next_page_, edge) : edge + timing_.longest_wait_cycles) +
           timing_.beat_cycles;
}

void BusMonitor::end_burst(std::int64_t edge) {
    // BUSREADY of this edge was written before its composer could count the burst's only or unannounced last beat, or
    // was delayed on its way.
    if (beats_ == 1 || stopped_ || timing_.loop_cycles > 0) {
        counted_from_[display_] = edge + 1 + timing_.loop_cycles;
    }
    active_ = stopped_ = false;
    free_from_ = edge;
}

void BusMonitor::check_overdue(std::int64_t edge) {
    if (active_ && stopped_ && !waits_are_known_ && edge == due_) {
        active_ = stopped_ = false;  // no beat was moving
    }
    if (active_ && edge == due_) {
        violate("bus/pace", edge,
                "no beat of the burst, " + std::to_string(remaining_) + " pixels of which are to come, " +
                    std::to_string(edge - beat_edge_) + " clocks after the one before");
        active_ = stopped_ = false;
        free_from_ = edge;
    }
    if (!table_complete_ && edge == table_edge_ + cycles_per_row_) {
        violate("bus/table", edge,
                "no table row " + std::to_string(cycles_per_row_) + " clocks after the beat before");
    }
}

/// A burst is stopped before it reads the page of its next word: notes the state of that page's bank.
void BusMonitor::note_stopped_opening(std::int64_t edge) {
    std::int64_t from = beat_edge_;  // the opening's first clock
    if (const std::int64_t refreshes = refreshes_by(edge); refreshes > 0) {
        const std::int64_t begin = first_edge_ + refreshes * memory_.refresh_interval_cycles;
        from = std::max(from, begin + memory_.refresh_cycles);
    }
    if (edge <= from) {
        set_open_page(next_page_, kNone, edge);
        return;
    }
    // If a memory that times its banks is stopped in an opening, the bank is left half open: it must be closed again.
    const std::int64_t open = open_page_beside(next_page_, from);
    const bool broken_off =
        memory_.times_banks() && open != next_page_ && edge - from < memory_.opening_cycles(open != kNone);
    set_open_page(next_page_, broken_off ? kHalfOpen : next_page_, edge);
}

/// A low BUSREADY that answers for the burst ends it at the edge that reads it.
void BusMonitor::stop_on_busready(std::int64_t edge, std::int64_t announced) {
    if (!active_ || stopped_ || announced <= timing_.beat_pixels || busready_at(display_, edge)) {
        return;
    }
    if (edge > beat_edge_) {
        note_stopped_opening(edge);
    }
    // The next beat may have begun already in the memory.
    const std::int64_t begins = waits_are_known_ ? due_ - timing_.beat_cycles : beat_edge_;
    if (begins < edge && timing_.beat_cycles > 1) {
        stopped_ = true;
        if (waits_are_known_) return;
        due_ = edge + timing_.beat_cycles - 1;
    } else {
        active_ = false;
    }
    free_from_ = edge;
    counted_from_[display_] = edge + 1 + timing_.loop_cycles;
}

}  // namespace metabuffer::monitors
