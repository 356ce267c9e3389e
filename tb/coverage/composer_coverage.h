#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "coverage.h"
#include "datapath/composer_buffer.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

/// What stands on a composer's wires at a core clock edge, before the edge.
struct ComposerWires {
    const rtl::BusBeat& bus;
    const rtl::PipePixel& pipe_in;
    const rtl::PipePixel& pipe_out;
    bool startframe_out = false;
    bool column_stall = false;
    bool stall = false;
    bool busready = false;
};

/// Follows one composer by its wires: what its buffer holds, which local pixel meets which upstream one, where bursts
/// are cut and where it starves. What an edge has done is seen at the next one, by the outputs. The buffer is one of
/// its own, filled from the bus; a composer whose wires do not fit it (a mistake, or a fault of the scenario) is not
/// sampled any further.
class ComposerCoverage {
  public:
    /// renderer: from 0; display: from 1.
    ComposerCoverage(Coverage& coverage, const Scenario& scenario, std::size_t renderer, int display);

    /// Samples the edge before, whose outputs these wires are, and keeps this edge's inputs.
    void clock_edge(const ComposerWires& wires);

    // What stands behind the edge sampled last, and what it did.
    bool in_step() const { return in_step_; }
    bool running() const { return running_; }
    int frame() const { return frame_; }
    bool starved() const { return starved_; }
    bool cut() const { return cut_; }
    int beats_of_burst() const { return beats_of_burst_; }
    int announced() const { return announced_; }
    std::int64_t position() const { return position_; }  ///< raster position composited; -1: none
    /// Pixels of the bus's frame are missing, and BUSREADY has asked for them since the earliest clock in which a
    /// burst that begins now can have been granted.
    bool competes() const;
    bool table_complete() const { return buffer_.table_complete(); }
    bool segment_empty() const { return buffer_.table_complete() && !buffer_.has_segment(); }
    bool segment_complete() const { return buffer_.table_complete() && buffer_.segment_complete(); }
    bool prefetched() const {
        return !running_ && buffer_.table_complete() &&
               (buffer_.segment_complete() || buffer_.free_pixels() < scenario_.composer.ready_space_pixels);
    }

  private:
    void sample_edge(const ComposerWires& outputs);
    void composite();
    void cover_composition(Pixel local, Pixel upstream);
    void cover_front(Pixel local, Pixel upstream);
    void cover_local_address(std::int64_t k);
    void cover_starved(std::int64_t k);
    void cover_stall();
    void end_frame();
    void take_beat();
    bool table_is_lost();
    void begin_frame();
    void end_table();
    void take_pixels();
    void cover_late(bool frame_is_over);
    void cover_busready(bool busready);
    void cover_buffer();

    Coverage& coverage_;
    const Scenario& scenario_;
    std::size_t renderer_;
    std::uint16_t display_;
    int raster_width_;
    int raster_height_;
    int pixels_per_beat_;
    bool glitches_;
    Pixel background_;

    // Inputs of the edge that is sampled next.
    rtl::BusBeat bus_;
    rtl::PipePixel pipe_in_;
    bool column_stall_ = false;
    bool stall_ = false;

    ComposerBuffer buffer_;
    SegmentWalker walker_;
    bool in_step_ = true;
    bool running_ = false;
    int frame_ = -1;
    std::uint32_t rows_of_table_ = 0;  ///< that have come

    // What the edge sampled did.
    bool starved_ = false;
    bool pixels_in_ = false;
    bool pixel_out_ = false;
    std::int64_t position_ = -1;

    // Bursts.
    int announced_ = 0;
    int beats_of_burst_ = 0;
    std::int64_t clocks_since_beat_ = 0;
    bool cut_ = false;  ///< BUSREADY has been taken back: the beat sampled next is the burst's last
    bool burst_before_cut_ = false;
    bool burst_cut_ = false;
    std::int64_t ready_clocks_ = 0;  ///< since BUSREADY rose

    // Starving.
    int starved_in_row_ = 0;
    std::int64_t starved_pixel_ = -1;

    // Frames.
    int tables_ = 0;
    bool row_came_ = false;
    bool had_segment_ = false;
    ViewportRow row_;
    ViewportRow row_before_;
    std::int64_t pushed_ = 0;            ///< pixels kept since reset
    std::int64_t pushed_of_newest_ = 0;  ///< of the frame whose table came last

    std::array<Bin, 3> relation_;         ///< local nearer, farther, tie
    std::array<Bin, 3> format_relation_;  ///< the same by depth format
    std::array<Bin, 3> alpha_;            ///< of the local pixel: 0, 255, between
    Bin local_at_zero_;
    Bin local_far_;
    Bin upstream_background_;
    Bin upstream_renderer_;
    Bin source_row_again_;
    Bin full_;
    Bin one_free_;
    Bin pixel_in_and_out_;
};

}  // namespace metabuffer::coverage
