#include "composer_coverage.h"

#include "datapath/composer_buffer.h"
#include "monitors/reference_composition.h"
#include "scenario/derived_timing.h"

namespace metabuffer::coverage {
namespace {

Relation relation_of(Pixel local, Pixel upstream) {
    if (local.z() == upstream.z()) return Relation::kTie;
    return local.z() < upstream.z() ? Relation::kNearer : Relation::kFarther;
}

constexpr int kOpaque = 255;

Alpha alpha_of(Pixel pixel) {
    if (pixel.a() == 0) return Alpha::kTransparent;
    return pixel.a() == kOpaque ? Alpha::kOpaque : Alpha::kBetween;
}

bool saturates(std::uint8_t front, std::uint8_t back, std::uint8_t front_alpha) {
    return monitors::unlimited_over(front, back, front_alpha) > kOpaque;
}

}  // namespace

ComposerCoverage::ComposerCoverage(const ComposerGoals& goals, const Scenario& scenario, std::size_t renderer,
                                   int display)
    : goals_(goals),
      scenario_(scenario),
      renderer_(renderer),
      display_(static_cast<std::uint16_t>(display)),
      raster_width_(scenario.displays.raster_width_pixels()),
      raster_height_(scenario.displays.raster_height_pixels()),
      pixels_per_beat_(pixels_per_beat(scenario.bus, scenario.memory)),
      background_(scenario.background_pixel()),
      observer_(scenario, static_cast<int>(renderer), display - 1) {
    observer_.reset(renderer == 0);
}

void ComposerCoverage::clock_edge(const ComposerWires& wires) {
    if (!in_step_) return;
    if (has_inputs_) sample_edge(wires);
    has_inputs_ = true;
    const monitors::ComposerInputs& inputs = wires.inputs;
    if (inputs.bus.kind == rtl::BusBeat::Kind::kNone) {
        bus_.kind = rtl::BusBeat::Kind::kNone;  // in most clocks: nothing need be copied
    } else {
        bus_ = inputs.bus;
    }
    startframe_in_ = inputs.startframe;
    pipe_in_ = inputs.pipe;
    pipeready_in_ = inputs.pipeready;
    column_stall_ = inputs.column_stall;
}

void ComposerCoverage::sample_edge(const ComposerWires& outputs) {
    starved_ = pixel_out_ = false;
    position_ = -1;
    in_step_ = column_stall_ || outputs.pipe_out.valid == running();
    if (!in_step_) return;
    if (running() && !column_stall_) cover_place();
    if (running() && column_stall_ && observer_.expected().stall) cover_stall();
    ++clocks_since_beat_;
    ready_clocks_ = outputs.busready ? ready_clocks_ + 1 : 0;
    in_step_ = step(outputs);
    if (!in_step_) return;
    cover_busready(outputs.busready);
    cover_buffer();
}

/// Follows the edge. False if the composer is no longer, or need no longer be, where it is expected.
bool ComposerCoverage::step(const ComposerWires& outputs) {
    const int frame_before = frame();
    const int received_before = observer_.newest_frame();
    const std::int64_t tables_lost_before = observer_.counters().lost_tables;
    const std::int64_t late_before = observer_.counters().late_pixels;
    const std::int64_t held_before = observer_.held_pixels();
    observer_.edge({bus_, startframe_in_, pipe_in_, pipeready_in_, column_stall_}, edge_++);
    if (frame() != frame_before) {
        if (!observer_.has_frame()) return false;
        starved_in_row_ = 0;
        starved_pixel_ = -1;
    }
    if (observer_.counters().lost_tables != tables_lost_before) {
        const bool starts = bus_.kind == rtl::BusBeat::Kind::kFrameStart;
        cover_lost_table(observer_.newest_frame() - received_before - (starts ? 1 : 0));
        return false;
    }
    if (outputs.startframe_out != observer_.expected().startframe || observer_.overflowed() ||
        observer_.table_refused()) {
        return false;
    }
    cover_beat(observer_.counters().late_pixels - late_before);
    goals_.smoothing.several_released.hit_if(scenario_.composer.smoothing == Smoothing::kBilinear &&
                                             held_before + observer_.kept_pixels() >
                                                 observer_.held_pixels() + 1);
    return true;
}

bool ComposerCoverage::competes() const {
    // A burst sampled now was driven at the edge before. It was granted there, or earlier by as long as its first word
    // may take.
    const std::int64_t since_grant = 1 + longest_beat_gap_cycles(scenario_);
    return in_step_ && observer_.missing_pixels() > 0 && ready_clocks_ > since_grant;
}

// ---- the pipeline side: what the edge finds ----

std::int64_t ComposerCoverage::next_position() const {
    return std::int64_t{observer_.y()} * raster_width_ + observer_.x();
}

bool ComposerCoverage::next_is_last() const {
    return next_position() == std::int64_t{raster_width_} * raster_height_ - 1;
}

/// The address of pixel k of the composited frame in the composer's memory, which is written in a circle.
std::int64_t ComposerCoverage::address_of(std::int64_t k) const {
    const std::int64_t before = written_before_[static_cast<std::size_t>(frame()) % written_before_.size()];
    return (before + k) % scenario_.composer.buffer_pixels;
}

void ComposerCoverage::cover_place() {
    position_ = next_position();
    if (const std::optional<LocalPixel> local = observer_.next_local_pixel()) {
        if (local->starves()) {
            cover_starved(*local);
        } else if (!local->abandoned) {
            cover_composition(local->pixel, renderer_ == 0 ? background_ : pipe_in_.pixel);
            cover_local_address(*local);
        }
        pixel_out_ = local->last_use && local->arrived;
    }
    if (next_is_last()) cover_frame_end();
}

void ComposerCoverage::cover_composition(Pixel local, Pixel upstream) {
    const Relation relation = relation_of(local, upstream);
    const bool tie = relation == Relation::kTie;
    const bool upstream_is_background = upstream == background_;
    goals_.relation.bins(scenario_.composition, relation).hit();
    goals_.depth_format.bins(scenario_.depth_format, relation).hit();
    goals_.alpha.bins(scenario_.composition, alpha_of(local)).hit();
    const ComposedDepthGoals& depth = goals_.depth;
    const bool far = local.z() == far_z(scenario_.depth_format);
    depth.local_at_zero.hit_if(local.z() == 0);
    depth.local_far.hit_if(far);
    depth.upstream_background.hit_if(upstream_is_background);
    depth.upstream_renderer.hit_if(!upstream_is_background);
    depth.tie_at_zero.hit_if(tie && local.z() == 0);
    depth.tie_far_with_background.hit_if(tie && far && upstream_is_background);
    depth.tie_between_renderers.hit_if(tie && !upstream_is_background);
    depth.differ_in_lowest_bit.hit_if(local.z() + 1 == upstream.z() || upstream.z() + 1 == local.z());
    if (scenario_.composition == Composition::kOver) cover_front(local, upstream);
}

void ComposerCoverage::cover_front(Pixel local, Pixel upstream) {
    const bool local_in_front = local.z() < upstream.z();
    const Pixel front = local_in_front ? local : upstream;
    const Pixel back = local_in_front ? upstream : local;
    goals_.front.local_in_front(local_in_front, alpha_of(front)).hit();
    goals_.front.channel_saturates.hit_if(saturates(front.r(), back.r(), front.a()) ||
                                          saturates(front.g(), back.g(), front.a()) ||
                                          saturates(front.b(), back.b(), front.a()));
}

/// A local pixel that is read.
void ComposerCoverage::cover_local_address(const LocalPixel& local) {
    const std::int64_t address = address_of(local.index);
    goals_.buffer.read_address_wraps.hit_if(address == 0 && local.index > 0);
    goals_.repeated.row_again.hit_if(local.repeated);
    goals_.repeated.starved_at_first.hit_if(local.index == starved_pixel_);
    const monitors::SegmentPositions& segment = observer_.segment();
    const std::int64_t last = local.index + segment.source_width() - 1;
    goals_.buffer.window_row_wraps.hit_if(segment.multiple() > 1 && local.column == 0 &&
                                          last < observer_.arrived_pixels() && address_of(last) < address);
}

void ComposerCoverage::cover_starved(const LocalPixel& local) {
    starved_ = true;
    starved_pixel_ = local.index;
    const monitors::SegmentPositions& segment = observer_.segment();
    if (observer_.x() == segment.left()) starved_in_row_ = 0;
    ++starved_in_row_;
    const StarvedPixelGoals& goals = goals_.starved;
    const std::size_t renderers = scenario_.renderers.size();
    const bool last = local.newest == segment.pixels() - 1;
    goals.last_of_segment.hit_if(last);
    goals.in_between.hit_if(!last);
    goals.last_raster_pixel.hit_if(next_is_last());
    goals.whole_raster_row.hit_if(starved_in_row_ == segment.right() - segment.left());
    goals.repetition.hit_if(local.repeated);
    goals.top_composer.hit_if(renderers > 1 && renderer_ == 0);
    goals.bottom_composer.hit_if(renderers > 1 && renderer_ == renderers - 1);
    goals.first_frame.hit_if(frame() == 0);
    goals.later_frame.hit_if(frame() > 0);
    goals_.buffer.empty_when_needed.hit_if(observer_.held_pixels() == 0);
    if (local.index < observer_.arrived_pixels()) {
        const bool row = local.newest - local.index >= segment.source_width();
        goals_.smoothing.starves_for_row.hit_if(row);
        goals_.smoothing.starves_for_column.hit_if(!row);
    }
}

void ComposerCoverage::cover_stall() {
    const StallingComposerGoals& goals = goals_.stall;
    const std::size_t renderers = scenario_.renderers.size();
    const std::optional<LocalPixel> local = observer_.next_local_pixel();
    goals.last_raster_pixel.hit_if(next_is_last());
    goals.last_of_segment.hit_if(local && local->newest == observer_.segment().pixels() - 1);
    goals_.smoothing.column_stands_still.hit_if(local && local->index < observer_.arrived_pixels());
    goals.top_composer.hit_if(renderers > 1 && renderer_ == 0);
    goals.bottom_composer.hit_if(renderers > 1 && renderer_ == renderers - 1);
    goals.composer_between.hit_if(renderer_ > 0 && renderer_ < renderers - 1);
    goals_.buffer.empty_when_needed.hit_if(observer_.held_pixels() == 0);
}

void ComposerCoverage::cover_frame_end() {
    if (!two_frames() || kept_of_newest_ == 0) return;
    const bool wholly = observer_.missing_pixels() == 0;
    goals_.prefetch.wholly_prefetched.hit_if(wholly);
    goals_.prefetch.partly_prefetched.hit_if(!wholly);
}

// ---- the bus side: what the edge has brought ----

/// late: pixels of the beat that came too late.
void ComposerCoverage::cover_beat(std::int64_t late) {
    switch (bus_.kind) {
        case rtl::BusBeat::Kind::kNone:
            break;
        case rtl::BusBeat::Kind::kPixels:
            if (bus_.destination == display_) cover_pixels(late);
            break;
        case rtl::BusBeat::Kind::kFrameStart:
            cover_frame_start();
            break;
        case rtl::BusBeat::Kind::kTableRow:
            if (bus_.destination == display_) {
                row_ = bus_.row();
                row_came_ = true;
            }
            if (bus_.last) cover_table_end();
            break;
    }
}

/// The beat shows, by its frame and index, that a frame's start or a table row has not come.
void ComposerCoverage::cover_lost_table(std::int64_t frames_missed) {
    using Lost = LostTableGoals::Lost;
    using ShownBy = LostTableGoals::ShownBy;
    const ShownBy shown_by = bus_.kind == rtl::BusBeat::Kind::kFrameStart ? ShownBy::kStart
                             : bus_.kind == rtl::BusBeat::Kind::kTableRow ? ShownBy::kRow
                                                                          : ShownBy::kPixels;
    goals_.lost_table.bins(frames_missed > 0 ? Lost::kStart : Lost::kRows, shown_by).hit();
    goals_.lost_table.several_frames.hit_if(frames_missed > 1);
}

void ComposerCoverage::cover_frame_start() {
    goals_.prefetch.table_while_compositing.hit_if(running());
    goals_.stall.next_table_comes.hit_if(column_stall_);
    const auto number = static_cast<std::size_t>(observer_.newest_frame());
    written_before_[number % written_before_.size()] = written_;
    kept_of_newest_ = 0;
    row_came_ = false;
    if (bus_.last) cover_table_end();
}

void ComposerCoverage::cover_table_end() {
    if (observer_.newest_frame() > 0) {
        goals_.prefetch.segment_where_none_was.hit_if(row_came_ && !had_segment_);
        goals_.prefetch.no_segment_where_one_was.hit_if(!row_came_ && had_segment_);
        goals_.prefetch.segment_moved.hit_if(row_came_ && had_segment_ && row_ != row_before_);
    }
    had_segment_ = row_came_;
    row_before_ = row_;
}

void ComposerCoverage::cover_pixels(std::int64_t late) {
    // On a narrow bus the beat that was moving comes after its burst has been given up.
    const bool behind_cut = burst_cut_ && clocks_since_beat_ == cycles_per_beat(scenario_.bus);
    clocks_since_beat_ = 0;
    if (announced_ == 0 && !behind_cut) {
        beats_of_burst_ = 0;
        burst_before_cut_ = burst_cut_;
        burst_cut_ = false;
    }
    ++beats_of_burst_;
    if (cut()) {
        ++beats_behind_cut_;
        goals_.busready_drop.several_beats_behind.hit_if(beats_behind_cut_ == 2);
    }
    announced_ = static_cast<int>(bus_.remaining);
    goals_.prefetch.pixels_while_compositing.hit_if(running() && two_frames());
    const std::int64_t kept = observer_.kept_pixels();
    const std::int64_t addresses = buffer_addresses(scenario_.composer.buffer_pixels);
    goals_.buffer.write_address_wraps.hit((kept_ + kept) / addresses - kept_ / addresses);
    kept_ += kept;
    kept_of_newest_ += kept;
    written_ += bus_.count;
    const LatePixelGoals& goals = goals_.late;
    const Bin& goal = !observer_.has_frame() ? goals.frame_is_over
                      : row_.dmultiple > 1   ? goals.behind_last_repetition
                                             : goals.behind_last_use;
    goal.hit(late);
}

/// What the composer answered at the edge.
void ComposerCoverage::cover_busready(bool busready) {
    if (cut()) {
        --cut_clocks_;
        if (!cut()) announced_ = 0;
    }
    if (busready || cut()) return;
    const BusreadyDropGoals& goals = goals_.busready_drop;
    const bool beat = bus_.kind == rtl::BusBeat::Kind::kPixels && bus_.destination == display_;
    if (announced_ <= pixels_per_beat_) {
        if (!beat || burst_cut_) return;
        goals.rest_fits_a_beat.hit_if(announced_ > 0);
        goals.behind_last_beat.hit_if(announced_ == 0 && beats_of_burst_ > 1);
        goals.behind_only_beat.hit_if(announced_ == 0 && beats_of_burst_ == 1);
        return;
    }
    cut_clocks_ = cut_cycles();
    beats_behind_cut_ = 0;
    burst_cut_ = true;
    const bool near_end = announced_ <= in_flight_pixels(scenario_.bus, scenario_.memory);
    const bool composited = running() && !two_frames();
    goals.behind_first_beat.hit_if(beats_of_burst_ == 1);
    goals.in_the_middle.hit_if(beats_of_burst_ > 1 && !near_end);
    goals.near_the_end.hit_if(near_end);
    goals.two_bursts_running.hit_if(burst_before_cut_);
    goals.narrow_bus.hit_if(cycles_per_beat(scenario_.bus) > 1);
    goals.segment_is_replicated.hit_if(row_.dmultiple > 1);
    goals.frame_is_composited.hit_if(composited);
    goals.frame_is_prefetched.hit_if(!composited);
    goals.policy(scenario_.bus.arbitration).hit();
}

void ComposerCoverage::cover_buffer() {
    const BufferGoals& goals = goals_.buffer;
    const std::int64_t held = observer_.held_pixels();
    const std::int64_t free = observer_.free_pixels();
    goals.full.hit_if(free == 0);
    goals.one_free.hit_if(free == 1 && held > 0);
    goals.pixel_in_and_out.hit_if(observer_.kept_pixels() > 0 && pixel_out_);
    goals.empty_in_segment.hit_if(running() && pixel_out_ && held == 0 && observer_.missing_pixels() > 0);
    goals.two_frames.hit_if(two_frames() && kept_of_newest_ > 0 && held > kept_of_newest_);
}

}  // namespace metabuffer::coverage
