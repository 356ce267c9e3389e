#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "coverage.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

class ComposerCoverage;

/// Follows one renderer's bus: tables, beats, bursts and the pages of its memory that they touch.
class BusCoverage {
  public:
    /// renderer: from 0.
    BusCoverage(Coverage& coverage, const Scenario& scenario, std::size_t renderer);

    /// A clock of the bus. `destination` has sampled the same beat already; null unless it carries pixels for a
    /// composer that is in step. `tableready`: every composer can take a table.
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
    void start_burst(const rtl::BusBeat& beat, std::int64_t page);
    void end_burst(const ViewportRow& row, const rtl::BusBeat& beat);
    std::int64_t address_of(const ViewportRow& row, std::int64_t k) const;

    Coverage& coverage_;
    const Scenario& scenario_;
    const Renderer& source_;
    std::string policy_;
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
