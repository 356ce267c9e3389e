#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "cover_group.h"
#include "monitors/composer_observer.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"
#include "shared_groups.h"

namespace metabuffer::coverage {

/// How a local pixel's Z compares with that of the one from upstream.
enum class Relation : std::uint8_t { kNearer, kFarther, kTie };
/// Of a pixel.
enum class Alpha : std::uint8_t { kTransparent, kOpaque, kBetween };

inline Axis<Relation> relations() {
    return {
        {Relation::kNearer, "local nearer"}, {Relation::kFarther, "local farther"}, {Relation::kTie, "tie"}};
}
inline Axis<Alpha> alphas() {
    return {{Alpha::kTransparent, "A 0"}, {Alpha::kOpaque, "A 255"}, {Alpha::kBetween, "A between"}};
}

struct RelationGoals : CoverGroup {
    explicit RelationGoals(Coverage& coverage)
        : CoverGroup(coverage, {"compose/z", "local and upstream pixel, in each composition"}) {}
    Cross<Composition, Relation> bins{*this, every<Composition>(), relations()};
};

struct DepthFormatGoals : CoverGroup {
    explicit DepthFormatGoals(Coverage& coverage)
        : CoverGroup(coverage, {"compose/depth-format", "local and upstream pixel, in each depth format"}) {}
    Cross<DepthFormat, Relation> bins{*this, every<DepthFormat>(), relations()};
};

struct AlphaGoals : CoverGroup {
    explicit AlphaGoals(Coverage& coverage)
        : CoverGroup(coverage, {"compose/alpha", "A of the local pixel, in each composition"}) {}
    Cross<Composition, Alpha> bins{*this, every<Composition>(), alphas()};
};

struct FrontGoals : CoverGroup {
    explicit FrontGoals(Coverage& coverage)
        : CoverGroup(coverage, {"compose/front", "over: which pixel is in front, with which A"}) {}
    Cross<bool, Alpha> local_in_front{
        *this, {{true, "local in front"}, {false, "upstream in front"}}, alphas()};
    Bin channel_saturates = bin("channel saturates");
};

struct ComposedDepthGoals : CoverGroup {
    explicit ComposedDepthGoals(Coverage& coverage) : CoverGroup(coverage, groups::kDepth) {}
    Bin local_at_zero = bin("local at Z 0");
    Bin local_far = bin("local far");
    Bin tie_at_zero = bin("tie at Z 0");
    Bin tie_far_with_background = bin("tie far with the background");
    Bin tie_between_renderers = bin("tie between two renderers");
    Bin differ_in_lowest_bit = bin("differ in the lowest bit");
    Bin upstream_background = bin("upstream is background");
    Bin upstream_renderer = bin("upstream is another renderer's");
};

struct BufferGoals : CoverGroup {
    explicit BufferGoals(Coverage& coverage) : CoverGroup(coverage, groups::kBuffer) {}
    Bin empty_when_needed = bin("empty when a pixel is needed");
    Bin empty_in_segment = bin("empty while its segment is composited");
    Bin full = bin("full");
    Bin one_free = bin("exactly one free");
    Bin pixel_in_and_out = bin("pixel in and pixel out in a clock");
    Bin write_address_wraps = bin("write address wraps");
    Bin read_address_wraps = bin("read address wraps");
    Bin window_row_wraps = bin("row of a window lies across the wrap");
    Bin two_frames = bin("two frames' pixels at once");
};

struct LatePixelGoals : CoverGroup {
    explicit LatePixelGoals(Coverage& coverage)
        : CoverGroup(coverage, {"composer/late", "pixels that come too late"}) {}
    Bin behind_last_use = bin("behind their last use");
    Bin frame_is_over = bin("of a frame that is over");
    Bin behind_last_repetition = bin("behind a replicated pixel's last repetition");
};

struct RepeatedPixelGoals : CoverGroup {
    explicit RepeatedPixelGoals(Coverage& coverage) : CoverGroup(coverage, groups::kReplication) {}
    Bin row_again = bin("source row read again");
    Bin starved_at_first = bin("repetitions of a pixel starve, later ones do not");
};

struct StarvedPixelGoals : CoverGroup {
    explicit StarvedPixelGoals(Coverage& coverage) : CoverGroup(coverage, groups::kStarvationPlace) {}
    Bin last_of_segment = bin("last of a segment");
    Bin in_between = bin("in between");
    Bin last_raster_pixel = bin("last raster pixel");
    Bin whole_raster_row = bin("whole raster row of a segment");
    Bin repetition = bin("repetition of a replicated pixel");
    Bin top_composer = bin("in the top composer");
    Bin bottom_composer = bin("in the bottom composer");
    Bin first_frame = bin("in the first frame");
    Bin later_frame = bin("in a later frame");
};

struct SmoothedPixelGoals : CoverGroup {
    explicit SmoothedPixelGoals(Coverage& coverage) : CoverGroup(coverage, groups::kSmoothing) {}
    Bin starves_for_column = bin("starves for the source column beside its own alone");
    Bin starves_for_row = bin("starves for the source row below its own alone");
    Bin column_stands_still = bin("column stands still for a neighbour alone");
    Bin several_released = bin("several pixels released at once");
};

struct StallingComposerGoals : CoverGroup {
    explicit StallingComposerGoals(Coverage& coverage) : CoverGroup(coverage, groups::kStall) {}
    Bin last_raster_pixel = bin("for the last raster pixel");
    Bin last_of_segment = bin("for the last of a segment");
    Bin top_composer = bin("top composer");
    Bin bottom_composer = bin("bottom composer");
    Bin composer_between = bin("composer in between");
    Bin next_table_comes = bin("next frame's table comes");
};

struct BusreadyDropGoals : CoverGroup {
    explicit BusreadyDropGoals(Coverage& coverage) : CoverGroup(coverage, groups::kBusreadyDrop) {}
    Bin behind_first_beat = bin("behind the first beat");
    Bin in_the_middle = bin("in the middle");
    Bin near_the_end = bin("when one beat more would end it");
    Bin behind_last_beat = bin("behind the last beat: no further slot");
    Bin behind_only_beat = bin("behind a burst of one beat: no further slot");
    Bin rest_fits_a_beat = bin("rest fits a beat: burst goes on, no further slot");
    Bin two_bursts_running = bin("two bursts of a composer running");
    Bin several_beats_behind = bin("several beats come behind it");
    Bin narrow_bus = bin("on a bus of several clocks a pixel");
    Bin segment_is_replicated = bin("segment is replicated");
    Bin frame_is_composited = bin("frame is composited");
    Bin frame_is_prefetched = bin("frame is only prefetched");
    Cross<Arbitration> policy{*this, every<Arbitration>()};
};

struct PrefetchGoals : CoverGroup {
    explicit PrefetchGoals(Coverage& coverage) : CoverGroup(coverage, groups::kSequence) {}
    Bin table_while_compositing = bin("table comes while compositing");
    Bin pixels_while_compositing = bin("pixels of the next frame come while compositing");
    Bin wholly_prefetched = bin("next frame wholly prefetched while compositing");
    Bin partly_prefetched = bin("next frame prefetched in part while compositing");
    Bin segment_where_none_was = bin("segment where none was");
    Bin no_segment_where_one_was = bin("no segment where one was");
    Bin segment_moved = bin("segment moved");
};

struct LostTableGoals : CoverGroup {
    explicit LostTableGoals(Coverage& coverage)
        : CoverGroup(coverage, {"faults/lost-table", "what of a table is lost first, and what shows it"}) {}
    enum class Lost : std::uint8_t { kStart, kRows };
    enum class ShownBy : std::uint8_t { kRow, kPixels, kStart };
    Cross<Lost, ShownBy> bins{*this,
                              {{Lost::kStart, "start"}, {Lost::kRows, "rows"}},
                              {{ShownBy::kRow, "shown by a row"},
                               {ShownBy::kPixels, "shown by pixels"},
                               {ShownBy::kStart, "shown by the next frame's start"}}};
    Bin several_frames = bin("several frames");
};

/// Goals of one composer.
struct ComposerGoals : GoalSet {
    using GoalSet::GoalSet;
    RelationGoals relation{coverage};
    DepthFormatGoals depth_format{coverage};
    AlphaGoals alpha{coverage};
    FrontGoals front{coverage};
    ComposedDepthGoals depth{coverage};
    BufferGoals buffer{coverage};
    LatePixelGoals late{coverage};
    RepeatedPixelGoals repeated{coverage};
    StarvedPixelGoals starved{coverage};
    SmoothedPixelGoals smoothing{coverage};
    StallingComposerGoals stall{coverage};
    BusreadyDropGoals busready_drop{coverage};
    PrefetchGoals prefetch{coverage};
    LostTableGoals lost_table{coverage};
};

/// The values of a composer's wires at a core clock edge, before the edge.
struct ComposerWires {
    monitors::ComposerInputs inputs;
    const rtl::PipePixel& pipe_out;
    bool startframe_out = false;
    bool busready = false;
};

/// Follows one composer by its wires: what its buffer holds, which local pixel meets which upstream one, where bursts
/// are cut and where it starves. A monitors::ComposerObserver knows what the composer must hold. The outputs show at
/// the next edge what an edge has done. A composer whose wires are not as expected, or that has lost a table, is not
/// sampled any further.
class ComposerCoverage {
  public:
    /// renderer: from 0; display: from 1. Goals and scenario must outlive it.
    ComposerCoverage(const ComposerGoals& goals, const Scenario& scenario, std::size_t renderer, int display);

    /// Samples the edge before, after which the outputs have these values, and keeps this edge's inputs.
    void clock_edge(const ComposerWires& wires);

    // The state after the edge sampled last, and what that edge did.
    bool in_step() const { return in_step_; }
    bool running() const { return observer_.running(); }
    int frame() const { return observer_.frame(); }
    bool starved() const { return starved_; }
    bool cut() const { return cut_clocks_ > 0; }
    /// BUSREADY has been taken back at this very edge.
    bool cut_begins() const { return cut() && cut_clocks_ == cut_cycles(); }
    int beats_of_burst() const { return beats_of_burst_; }
    std::int64_t position() const { return position_; }  ///< raster position composited; -1: none
    /// Pixels of the bus's frame are missing, and BUSREADY has asked for them since the earliest clock in which a
    /// burst that begins now can have been granted.
    bool competes() const;
    bool table_complete() const { return observer_.table_complete(); }
    bool segment_empty() const { return observer_.table_complete() && !observer_.has_segment(); }
    bool segment_complete() const { return observer_.table_complete() && observer_.segment_complete(); }
    bool prefetched() const { return observer_.prefetched(); }

  private:
    using LocalPixel = monitors::ComposerObserver::LocalPixel;

    void sample_edge(const ComposerWires& outputs);
    bool step(const ComposerWires& outputs);
    void cover_place();
    void cover_composition(Pixel local, Pixel upstream);
    void cover_front(Pixel local, Pixel upstream);
    void cover_local_address(const LocalPixel& local);
    void cover_starved(const LocalPixel& local);
    void cover_stall();
    void cover_frame_end();
    void cover_beat(std::int64_t late);
    void cover_lost_table(std::int64_t frames_missed);
    void cover_frame_start();
    void cover_table_end();
    void cover_pixels(std::int64_t late);
    void cover_busready(bool busready);
    void cover_buffer();

    std::int64_t next_position() const;
    bool next_is_last() const;
    /// The bus has begun to send a frame while the one before is not over.
    bool two_frames() const { return !observer_.has_room_for_table(); }
    std::int64_t address_of(std::int64_t k) const;
    int cut_cycles() const { return busready_cut_cycles(scenario_.bus, scenario_.memory); }

    const ComposerGoals& goals_;
    const Scenario& scenario_;
    std::size_t renderer_;
    std::uint16_t display_;
    int raster_width_;
    int raster_height_;
    int pixels_per_beat_;
    Pixel background_;

    // Inputs of the edge that is sampled next.
    bool has_inputs_ = false;
    rtl::BusBeat bus_;
    bool startframe_in_ = false;
    rtl::PipePixel pipe_in_;
    bool pipeready_in_ = false;
    bool column_stall_ = false;

    monitors::ComposerObserver observer_;
    std::int64_t edge_ = 0;
    bool in_step_ = true;

    // What the edge sampled did.
    bool starved_ = false;
    bool pixel_out_ = false;
    std::int64_t position_ = -1;

    // Bursts.
    int announced_ = 0;
    int beats_of_burst_ = 0;
    std::int64_t clocks_since_beat_ = 0;
    int cut_clocks_ = 0;  ///< BUSREADY has been taken back: beats in these clocks are the burst's last
    int beats_behind_cut_ = 0;
    bool burst_before_cut_ = false;
    bool burst_cut_ = false;
    std::int64_t ready_clocks_ = 0;  ///< since BUSREADY rose

    // Starving.
    int starved_in_row_ = 0;
    std::int64_t starved_pixel_ = -1;

    // Frames.
    bool row_came_ = false;
    bool had_segment_ = false;
    ViewportRow row_;
    ViewportRow row_before_;
    std::int64_t kept_ = 0;            ///< pixels since reset
    std::int64_t kept_of_newest_ = 0;  ///< of the frame whose table came last
    std::int64_t written_ = 0;  ///< pixels since reset, those too late included: the write address moves on
    std::array<std::int64_t, 2> written_before_{};  ///< a frame, by the parity of its number
};

}  // namespace metabuffer::coverage
