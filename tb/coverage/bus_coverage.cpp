#include "bus_coverage.h"

#include <algorithm>
#include <utility>

#include "composer_coverage.h"
#include "formats/control_scanline.h"

namespace metabuffer::coverage {

BusCoverage::BusCoverage(const BusGoals& goals, const Scenario& scenario, std::size_t renderer)
    : goals_(goals),
      scenario_(scenario),
      source_(scenario.renderers[renderer]),
      pixels_per_beat_(pixels_per_beat(scenario.bus, scenario.memory)),
      row_of_(static_cast<std::size_t>(scenario.displays.count())) {}

std::int64_t BusCoverage::address_of(const ViewportRow& row, std::int64_t k) const {
    return (row.sy + k / row.sdx) * source_.image_width_pixels + row.sx + k % row.sdx;
}

void BusCoverage::clock(const rtl::BusBeat& beat, const ComposerCoverage* destination, bool tableready) {
    ++clocks_since_table_beat_;
    ++clocks_since_pixels_;
    beat_now_ = beat.kind != rtl::BusBeat::Kind::kNone;
    destination_now_ = 0;
    idle_clocks_ = frames_ > 0 && pixels_left_ <= 0 ? idle_clocks_ + 1 : 0;
    switch (beat.kind) {
        case rtl::BusBeat::Kind::kNone:
            break;
        case rtl::BusBeat::Kind::kFrameStart:
        case rtl::BusBeat::Kind::kTableRow:
            take_table_beat(beat);
            break;
        case rtl::BusBeat::Kind::kPixels:
            destination_now_ = beat.destination;
            pixels_left_ -= beat.count;
            if (destination != nullptr) take_pixels(beat, *destination);
            break;
    }
    tableready_two_before_ = std::exchange(tableready_before_, tableready);
}

void BusCoverage::take_table_beat(const rtl::BusBeat& beat) {
    const BusTableGoals& goals = goals_.table;
    if (beat.kind == rtl::BusBeat::Kind::kFrameStart) {
        ++frames_;
        // The beat was driven one edge ago, at the first edge that read TABLEREADY high, if nothing on the way delays
        // either.
        const bool direct = bus_loop_cycles(scenario_.bus, scenario_.memory) == 0;
        if (frames_ > 2 && direct)
            (tableready_two_before_ ? goals.goes_at_once : goals.waits_for_tableready).hit();
        rows_before_ = std::exchange(rows_, {});
        pixels_left_ = 0;
        idle_clocks_ = 0;
        open_page_ = -1;
        burst_left_ = 0;
        burst_display_ = 0;
    } else {
        const ViewportRow row = beat.row();
        rows_.push_back(row);
        row_of_.at(row.dcomp - std::size_t{1}) = row;
        pixels_left_ += std::int64_t{row.sdx} * row.sdy;
        (clocks_since_table_beat_ > 1 ? goals.row_of_several_clocks : goals.row_of_one_clock).hit();
    }
    clocks_since_table_beat_ = 0;
    if (beat.last) end_table();
}

void BusCoverage::end_table() {
    const BusTableGoals& goals = goals_.table;
    goals.rows(static_cast<std::int64_t>(rows_.size())).hit();
    if (frames_ > 1) (rows_ == rows_before_ ? goals.same : goals.changes).hit();
    goals.unsorted.hit_if(
        !std::is_sorted(rows_.begin(), rows_.end(),
                        [](const ViewportRow& a, const ViewportRow& b) { return a.dcomp < b.dcomp; }));
}

void BusCoverage::take_pixels(const rtl::BusBeat& beat, const ComposerCoverage& destination) {
    const ViewportRow& row = row_of_.at(beat.destination - std::size_t{1});
    if (row.sdx == 0) return;
    const std::int64_t page = address_of(row, beat.first) / scenario_.memory.page_words;
    if (destination.beats_of_burst() == 1) start_burst(beat, page);
    ++burst_beats_;
    burst_pixels_ += beat.count;
    burst_left_ = beat.remaining;
    const MemoryConfig& memory = scenario_.memory;
    const int longest_alone = memory.page_miss_cycles + cycles_per_beat(scenario_.bus);
    const bool waited = burst_beats_ > 1 && clocks_since_pixels_ > longest_alone;
    goals_.burst.refresh_in_mid_burst.hit_if(waited && memory.refreshes() && !memory.shared());
    goals_.burst.write_in_mid_burst.hit_if(waited && memory.shared() && !memory.refreshes());
    if (page != open_page_) {
        ++burst_pages_;
        if (burst_beats_ > 1) {
            goals_.burst.over_page_end.hit();
            goals_.burst.miss_in_mid_burst.hit_if(pages_show() && memory.page_miss_cycles > 0);
        }
        goals_.page.burst_in_three_pages.hit_if(burst_pages_ > 2);
    }
    open_page_ = page;
    goals_.beat.pixels(beat.count).hit();
    if (beat.count < pixels_per_beat_) {
        (beat.remaining == 0 ? goals_.beat.short_at_burst_end : goals_.beat.short_at_page_end).hit();
    }
    goals_.burst.several_rows_in_a_beat.hit_if(beat.first % row.sdx + beat.count > row.sdx);
    clocks_since_pixels_ = 0;
    // After a cut more beats may come; on a narrow bus the last of them no longer announces the rest.
    if (destination.beats_of_burst() == 1) burst_cut_ = false;
    if (beat.remaining == 0) {
        if (!burst_cut_) end_burst(row, beat);
    } else if (destination.cut_begins()) {
        burst_cut_ = true;
        goals_.burst.cut.hit();
        goals_.cuts.two_composers_running.hit_if(cut_display_ != 0 && cut_display_ != beat.destination);
        cut_display_ = beat.destination;
    }
}

/// Whether the open page is that of the beat before, since the bus shows every access.
bool BusCoverage::pages_show() const { return scenario_.memory.banks == 1 && !scenario_.memory.shared(); }

void BusCoverage::start_burst(const rtl::BusBeat& beat, std::int64_t page) {
    const BurstGoals& goals = goals_.burst;
    goals_.grants.same_composer_again(scenario_.bus.arbitration).hit_if(burst_display_ == beat.destination);
    goals.right_behind_another.hit_if(burst_display_ != 0 &&
                                      clocks_since_pixels_ == cycles_per_beat(scenario_.bus));
    (page == open_page_ ? goals.page_open_before : goals.miss_before).hit_if(pages_show());
    burst_display_ = beat.destination;
    burst_first_ = beat.first;
    burst_pixels_ = 0;
    burst_beats_ = 0;
    burst_pages_ = 0;
}

void BusCoverage::end_burst(const ViewportRow& row, const rtl::BusBeat& beat) {
    const BurstGoals& goals = goals_.burst;
    cut_display_ = 0;
    const std::int64_t segment = std::int64_t{row.sdx} * row.sdy;
    const std::int64_t end = beat.first + std::int64_t{beat.count};
    goals.whole.hit_if(burst_pixels_ == scenario_.bus.burst_pixels);
    goals.shorter_at_segment_end.hit_if(burst_pixels_ < scenario_.bus.burst_pixels && end == segment);
    goals.of_one_pixel.hit_if(burst_pixels_ == 1);
    (burst_beats_ == 1 ? goals.of_one_beat : goals.of_several_beats).hit();
    goals.over_row_end.hit_if(burst_first_ / row.sdx != (end - 1) / row.sdx);
    goals.whole_segment.hit_if(burst_pixels_ == segment);
}

}  // namespace metabuffer::coverage
