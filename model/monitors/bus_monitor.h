#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <string>
#include <systemc>
#include <vector>

#include "monitors/bus_timing.h"
#include "monitors/delay_line.h"
#include "monitors/rule_reporter.h"
#include "monitors/segment_positions.h"
#include "monitors/violation.h"
#include "rtl/block.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// Watches one renderer's bus (sections 5.2 and 5.3 of the paper) as its input framebuffer drives it, together with the
/// BUSREADY and TABLEREADY that the input framebuffer reads. Changes nothing.
///
/// Rules: bus/tableready, bus/incomplete, bus/frames, bus/frame-number, bus/table, bus/row, bus/row-number,
/// bus/destination, bus/one-burst, bus/count, bus/remaining, bus/order, bus/beyond, bus/pace, bus/busready,
/// bus/passed-over; docs/monitors.md says what each means. The scoreboard checks the values of pixels. A violation's
/// cycle is the edge that samples the beat; the input framebuffer drove it at the edge before, and decided on it
/// earlier by the memory's read latency. BUSREADY and TABLEREADY are checked at that decision.
class BusMonitor final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<rtl::BusBeat> bus_i{"bus_i"};
    sc_core::sc_vector<sc_core::sc_in<bool>> busready_i;    ///< [display]
    sc_core::sc_vector<sc_core::sc_in<bool>> tableready_i;  ///< [display]

    /// renderer: index, from 0.
    BusMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
               ViolationLog& log);

    /// Frames whose table has been broadcast, at least in part.
    int frames_started() const { return frames_started_; }
    std::int64_t bursts() const { return bursts_; }
    std::int64_t pixels_sent() const { return pixels_sent_; }
    /// Violations that were seen and not reported, since one of the same rule and frame was.
    std::int64_t unreported() const { return reporter_.unreported(); }

  private:
    static constexpr std::int64_t kNone = -1;
    static constexpr std::int64_t kHalfOpen = -2;  ///< of a bank: neither closed nor a page that can be read

    /// A row of the frame under way, by display.
    struct Row {
        bool present = false;
        std::int64_t first_word = 0;  ///< address of its pixel 0 in the memory
        std::int64_t width = 1;       ///< of the source rectangle
        std::int64_t pixels = 0;
        std::int64_t sent = 0;
    };
    struct Bank {
        std::int64_t page = kNone;
        std::int64_t refreshes = 0;  ///< that had begun when it was opened; a later one has closed it
    };
    /// A wire's level from an edge on.
    struct Level {
        std::int64_t edge = 0;
        bool high = false;
    };

    void end_of_elaboration() override;
    void clock_edge();
    void restart();
    void sample_busready(std::int64_t edge);
    bool busready_at(std::size_t display, std::int64_t edge) const;
    bool every_tableready() const;

    void check_frame_number(const rtl::BusBeat& beat, std::int64_t edge);
    void take_frame_start(const rtl::BusBeat& beat, std::int64_t edge);
    void take_row(const rtl::BusBeat& beat, std::int64_t edge);
    void enter_row(const ViewportRow& row, std::int64_t edge);
    void take_pixels(const rtl::BusBeat& beat, std::int64_t edge);
    void check_grant(std::size_t display, std::int64_t page, std::int64_t edge);
    std::int64_t burst_left(const rtl::BusBeat& beat, const Row& row, std::int64_t edge);
    void check_order(const rtl::BusBeat& beat, const Row& row, std::int64_t edge);
    void expect_next(const Row& row, std::int64_t edge);
    void end_burst(std::int64_t edge);
    void note_stopped_opening(std::int64_t edge);
    void stop_on_busready(std::int64_t edge, std::int64_t announced);
    void check_overdue(std::int64_t edge);
    std::int64_t address_of(const Row& row, std::int64_t pixel) const;
    std::int64_t page_of(const Row& row, std::int64_t pixel) const;
    std::int64_t refreshes_by(std::int64_t clock) const;
    /// The page that is open, or half open, in a page's bank.
    std::int64_t open_page_beside(std::int64_t page, std::int64_t clock) const;
    void set_open_page(std::int64_t page, std::int64_t state, std::int64_t clock);
    /// The clock in which a page can be read, if that is wanted from a clock on.
    std::int64_t read_clock(std::int64_t page, std::int64_t wanted) const;
    std::int64_t beat_size(const Row& row, std::int64_t pixel, std::int64_t left) const;
    void violate(const char* rule, const std::string& signal, std::int64_t edge, const std::string& detail);
    void violate(const char* rule, std::int64_t edge, const std::string& detail) {
        violate(rule, bus_name_, edge, detail);
    }

    std::string bus_;  ///< "bus 1: "
    int displays_;
    int frames_;
    int raster_width_;
    int raster_height_;
    Smoothing smoothing_;
    std::int64_t image_width_;
    std::int64_t image_height_;
    std::int64_t page_words_;
    MemoryConfig memory_;
    BusTiming timing_;
    std::int64_t latency_cycles_;  ///< from the clock that reads a word to the one that puts it on the bus
    /// The bus shows how long each word takes. With shared ports it does not: the link's words take clocks, too.
    bool waits_are_known_;
    std::int64_t grant_cycles_;
    std::int64_t burst_pixels_;
    std::int64_t buffer_pixels_;
    std::int64_t ready_space_pixels_;
    std::int64_t cycles_per_row_;
    std::int64_t core_period_picoseconds_;

    RuleReporter reporter_;
    std::string bus_name_;
    std::vector<std::string> busready_names_;

    std::vector<std::deque<Level>> levels_;  ///< of BUSREADY, by display: back to the oldest possible grant
    DelayLine<bool> tables_ready_;           ///< every TABLEREADY was high
    bool tables_taken_ = false;              ///< every TABLEREADY was high at the edge before
    std::int64_t table_counted_from_ = 0;    ///< TABLEREADY before this edge does not count the newest frame

    int frames_started_ = 0;
    bool table_complete_ = true;
    std::int64_t table_edge_ = kNone;  ///< of the table's last beat so far
    std::vector<Row> rows_;            ///< [display]
    std::int64_t rows_taken_ = 0;      ///< of the table
    std::int64_t pixels_left_ = 0;     ///< of the frame
    std::vector<Bank> banks_;
    std::int64_t first_edge_ = kNone;  ///< without reset, from which the refreshes are counted

    // The burst under way.
    DelayLine<std::int64_t> announced_;  ///< pixels of it that were still to come
    bool active_ = false;
    bool stopped_ = false;        ///< by BUSREADY; the beat that was moving is still to come
    std::size_t display_ = 0;     ///< that it is for
    std::int64_t remaining_ = 0;  ///< pixels after its last beat
    int beats_ = 0;
    std::int64_t beat_edge_ = kNone;  ///< of its last beat
    std::int64_t next_page_ = kNone;  ///< of the pixel after it
    std::int64_t due_ = kNone;        ///< edge that samples its next beat, or the last edge that may

    // The next grant.
    std::int64_t free_from_ = 0;              ///< it cannot be before this edge
    std::vector<std::int64_t> counted_from_;  ///< [display]: it cannot be for this display before this edge

    std::int64_t bursts_ = 0;
    std::int64_t pixels_sent_ = 0;
    rtl::Clocked clocked_{*this, clk_i, &BusMonitor::clock_edge};
};

}  // namespace metabuffer::monitors
