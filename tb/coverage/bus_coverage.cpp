#include "bus_coverage.h"

#include <algorithm>
#include <utility>

#include "bin_names.h"
#include "composer_coverage.h"
#include "formats/control_scanline.h"
#include "scenario/names.h"

namespace metabuffer::coverage {

BusCoverage::BusCoverage(Coverage& coverage, const Scenario& scenario, std::size_t renderer)
    : coverage_(coverage),
      scenario_(scenario),
      source_(scenario.renderers[renderer]),
      policy_(to_string(scenario.bus.arbitration)),
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
    const char* group = "bus/table";
    if (beat.kind == rtl::BusBeat::Kind::kFrameStart) {
        ++frames_;
        // The beat was driven one edge ago, at the first one that read TABLEREADY high.
        if (frames_ > 2)
            coverage_.hit(group, !tableready_two_before_ ? "waits for TABLEREADY" : "goes at once");
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
        coverage_.hit(group, clocks_since_table_beat_ > 1 ? "row of several clocks" : "row of one clock");
    }
    clocks_since_table_beat_ = 0;
    if (beat.last) end_table();
}

void BusCoverage::end_table() {
    const char* group = "bus/table";
    coverage_.hit(group, rows_.empty() ? "empty" : rows_.size() == 1 ? "of one row" : "of several rows");
    if (frames_ > 1)
        coverage_.hit(group, rows_ == rows_before_ ? "the same as before" : "changes from the frame before");
    coverage_.hit_if(
        !std::is_sorted(rows_.begin(), rows_.end(),
                        [](const ViewportRow& a, const ViewportRow& b) { return a.dcomp < b.dcomp; }),
        group, "rows in another order than displays");
}

void BusCoverage::take_pixels(const rtl::BusBeat& beat, const ComposerCoverage& destination) {
    const ViewportRow& row = row_of_.at(beat.destination - std::size_t{1});
    if (row.sdx == 0) return;
    const std::int64_t page = address_of(row, beat.first) / scenario_.memory.page_words;
    if (destination.beats_of_burst() == 1) start_burst(beat, page);
    ++burst_beats_;
    burst_pixels_ += beat.count;
    burst_left_ = beat.remaining;
    if (page != open_page_) {
        ++burst_pages_;
        if (burst_beats_ > 1) {
            coverage_.hit("bus/burst", "over a page's end");
            coverage_.hit_if(scenario_.memory.page_miss_cycles > 0, "bus/burst", "page miss in mid burst");
        }
        coverage_.hit_if(burst_pages_ > 2, "memory/page", "burst in three pages or more");
    }
    open_page_ = page;
    coverage_.hit("bus/beat", std::to_string(beat.count) + " at a time");
    if (beat.count < pixels_per_beat_) {
        coverage_.hit("bus/beat", beat.remaining == 0 ? "beat not full at the burst's end"
                                                      : "beat not full at a page's end");
    }
    coverage_.hit_if(beat.first % row.sdx + beat.count > row.sdx, "bus/burst",
                     "pixels of several source rows in a beat");
    clocks_since_pixels_ = 0;
    // Behind a cut one more beat may come; on a narrow bus it no longer announces the rest.
    const bool behind_cut = std::exchange(burst_cut_, false) && destination.beats_of_burst() > 1;
    if (beat.remaining == 0) {
        if (!behind_cut) end_burst(row, beat);
    } else if (destination.cut()) {
        burst_cut_ = true;
        coverage_.hit("bus/burst", "cut by BUSREADY");
        coverage_.hit_if(cut_display_ != 0 && cut_display_ != beat.destination, "bus/busready-drop",
                         "two composers running");
        cut_display_ = beat.destination;
    }
}

void BusCoverage::start_burst(const rtl::BusBeat& beat, std::int64_t page) {
    const char* group = "bus/burst";
    coverage_.hit_if(burst_display_ == beat.destination, "bus/arbitration",
                     both(policy_, "the same composer twice running"));
    coverage_.hit_if(burst_display_ != 0 && clocks_since_pixels_ == cycles_per_beat(scenario_.bus), group,
                     "right behind another");
    coverage_.hit(group, page == open_page_ ? "page open before it" : "page miss before it");
    burst_display_ = beat.destination;
    burst_first_ = beat.first;
    burst_pixels_ = 0;
    burst_beats_ = 0;
    burst_pages_ = 0;
}

void BusCoverage::end_burst(const ViewportRow& row, const rtl::BusBeat& beat) {
    const char* group = "bus/burst";
    cut_display_ = 0;
    const std::int64_t segment = std::int64_t{row.sdx} * row.sdy;
    const std::int64_t end = beat.first + std::int64_t{beat.count};
    coverage_.hit_if(burst_pixels_ == scenario_.bus.burst_pixels, group, "whole");
    coverage_.hit_if(burst_pixels_ < scenario_.bus.burst_pixels && end == segment, group,
                     "shorter at the segment's end");
    coverage_.hit_if(burst_pixels_ == 1, group, "of one pixel");
    coverage_.hit(group, burst_beats_ == 1 ? "of one beat" : "of several beats");
    coverage_.hit_if(burst_first_ / row.sdx != (end - 1) / row.sdx, group, "over a source row's end");
    coverage_.hit_if(burst_pixels_ == segment, group, "carries the whole segment");
}

}  // namespace metabuffer::coverage
