#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cover_group.h"
#include "rtl/signals.h"
#include "scenario/limits.h"
#include "scenario/scenario.h"
#include "shared_groups.h"

namespace metabuffer::coverage {

class ComposerCoverage;

struct BusTableGoals : CoverGroup {
    explicit BusTableGoals(Coverage& coverage) : CoverGroup(coverage, {"bus/table", "tables on the bus"}) {}
    Ranges rows{*this, {{0, "empty"}, {1, "of one row"}, {2, "of several rows"}}};
    Bin row_of_several_clocks = bin("row of several clocks");
    Bin row_of_one_clock = bin("row of one clock");
    Bin waits_for_tableready = bin("waits for TABLEREADY");
    Bin goes_at_once = bin("goes at once");
    Bin changes = bin("changes from the frame before");
    Bin same = bin("the same as before");
    Bin unsorted = bin("rows in another order than displays");
};

struct BeatGoals : CoverGroup {
    explicit BeatGoals(Coverage& coverage) : CoverGroup(coverage, groups::kBeat) {}
    Cross<int> pixels{*this, numbers(limits::kWordsPerCycle.low, limits::kWordsPerCycle.high, " at a time")};
    Bin short_at_burst_end = bin("beat not full at the burst's end");
    Bin short_at_page_end = bin("beat not full at a page's end");
};

struct BurstGoals : CoverGroup {
    explicit BurstGoals(Coverage& coverage)
        : CoverGroup(coverage, {"bus/burst", "how a burst runs and ends"}) {}
    Bin whole = bin("whole");
    Bin cut = bin("cut by BUSREADY");
    Bin shorter_at_segment_end = bin("shorter at the segment's end");
    Bin of_one_pixel = bin("of one pixel");
    Bin of_one_beat = bin("of one beat");
    Bin of_several_beats = bin("of several beats");
    Bin over_row_end = bin("over a source row's end");
    Bin over_page_end = bin("over a page's end");
    Bin miss_before = bin("page miss before it");
    Bin miss_in_mid_burst = bin("page miss in mid burst");
    Bin refresh_in_mid_burst = bin("refresh in mid burst");
    Bin write_in_mid_burst = bin("link's words written in mid burst");
    Bin page_open_before = bin("page open before it");
    Bin right_behind_another = bin("right behind another");
    Bin whole_segment = bin("carries the whole segment");
    Bin several_rows_in_a_beat = bin("pixels of several source rows in a beat");
};

struct PageGoals : CoverGroup {
    explicit PageGoals(Coverage& coverage) : CoverGroup(coverage, groups::kPage) {}
    Bin burst_in_three_pages = bin("burst in three pages or more");
};

struct RunningCutGoals : CoverGroup {
    explicit RunningCutGoals(Coverage& coverage) : CoverGroup(coverage, groups::kBusreadyDrop) {}
    Bin two_composers_running = bin("two composers running");
};

struct GrantGoals : CoverGroup {
    explicit GrantGoals(Coverage& coverage) : CoverGroup(coverage, groups::kArbitration) {}
    Cross<Arbitration> same_composer_again{*this,
                                           every<Arbitration>("", ", the same composer twice running")};
};

/// Goals of one bus.
struct BusGoals : GoalSet {
    using GoalSet::GoalSet;
    BusTableGoals table{coverage};
    BeatGoals beat{coverage};
    BurstGoals burst{coverage};
    PageGoals page{coverage};
    RunningCutGoals cuts{coverage};
    GrantGoals grants{coverage};
};

/// Follows one renderer's bus: tables, beats, bursts and the pages of its memory that they touch.
class BusCoverage {
  public:
    /// renderer: from 0. Goals and scenario must outlive it.
    BusCoverage(const BusGoals& goals, const Scenario& scenario, std::size_t renderer);

    /// A clock of the bus. `destination` has sampled the same beat already; null unless the beat carries pixels for a
    /// composer that is in step. `tableready`: every composer can receive a table.
    void clock(const rtl::BusBeat& beat, const ComposerCoverage* destination, bool tableready);

    /// Frames whose tables have been sent.
    int frames() const { return frames_; }
    /// Clocks since the last pixel of a frame, 0 while one is sent.
    std::int64_t idle_clocks() const { return idle_clocks_; }
    /// Nothing on the bus, in the middle of a burst.
    bool burst_waits() const { return !beat_now_ && burst_left_ > 0; }
    bool beat_now() const { return beat_now_; }
    std::uint16_t destination_now() const { return destination_now_; }

  private:
    void take_table_beat(const rtl::BusBeat& beat);
    void end_table();
    void take_pixels(const rtl::BusBeat& beat, const ComposerCoverage& destination);
    bool pages_show() const;
    void start_burst(const rtl::BusBeat& beat, std::int64_t page);
    void end_burst(const ViewportRow& row, const rtl::BusBeat& beat);
    std::int64_t address_of(const ViewportRow& row, std::int64_t k) const;

    const BusGoals& goals_;
    const Scenario& scenario_;
    const Renderer& source_;
    int pixels_per_beat_;

    int frames_ = 0;
    std::vector<ViewportRow> rows_;
    std::vector<ViewportRow> rows_before_;
    std::vector<ViewportRow> row_of_;  ///< by display, from 0
    std::int64_t pixels_left_ = 0;
    std::int64_t idle_clocks_ = 0;
    bool tableready_before_ = true;
    bool tableready_two_before_ = true;
    int clocks_since_table_beat_ = 0;

    bool beat_now_ = false;
    std::uint16_t destination_now_ = 0;
    int clocks_since_pixels_ = 0;
    std::int64_t open_page_ = -1;
    std::uint16_t burst_display_ = 0;
    std::uint16_t cut_display_ = 0;  ///< of the burst before, if it was cut
    bool burst_cut_ = false;
    std::int64_t burst_left_ = 0;
    std::int64_t burst_pixels_ = 0;
    std::int64_t burst_first_ = 0;
    int burst_beats_ = 0;
    int burst_pages_ = 0;
};

}  // namespace metabuffer::coverage
