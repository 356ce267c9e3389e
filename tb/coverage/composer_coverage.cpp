#include "composer_coverage.h"

#include <string>

#include "bin_names.h"
#include "datapath/composition.h"
#include "scenario/names.h"

namespace metabuffer::coverage {
namespace {

constexpr std::uint8_t kOpaque = 255;

std::array<Bin, 3> crossed(Coverage& coverage, const char* group, const std::string& left,
                           const std::array<const char*, 3>& right) {
    return {Bin(coverage, group, both(left, right[0])), Bin(coverage, group, both(left, right[1])),
            Bin(coverage, group, both(left, right[2]))};
}

constexpr std::array<const char*, 3> kRelations{"local nearer", "local farther", "tie"};
constexpr std::array<const char*, 3> kAlphas{"A 0", "A 255", "A between"};

std::size_t relation_of(Pixel local, Pixel upstream) {
    if (local.z() < upstream.z()) return 0;
    return local.z() > upstream.z() ? 1 : 2;
}

std::size_t alpha_of(Pixel pixel) {
    if (pixel.a() == 0) return 0;
    return pixel.a() == kOpaque ? 1 : 2;
}

bool saturates(std::uint8_t front, std::uint8_t back, std::uint8_t front_alpha) {
    return front + div255(std::uint32_t{back} * (kOpaque - std::uint32_t{front_alpha})) > kOpaque;
}

}  // namespace

ComposerCoverage::ComposerCoverage(Coverage& coverage, const Scenario& scenario, std::size_t renderer,
                                   int display)
    : coverage_(coverage),
      scenario_(scenario),
      renderer_(renderer),
      display_(static_cast<std::uint16_t>(display)),
      raster_width_(scenario.displays.raster_width_pixels()),
      raster_height_(scenario.displays.raster_height_pixels()),
      pixels_per_beat_(pixels_per_beat(scenario.bus, scenario.memory)),
      glitches_(scenario.composer.on_starvation == StarvationMode::kGlitch),
      background_(scenario.background_pixel()),
      buffer_(scenario.composer.buffer_pixels, raster_width_, raster_height_),
      relation_(crossed(coverage, "compose/z", to_string(scenario.composition), kRelations)),
      format_relation_(
          crossed(coverage, "compose/depth-format", to_string(scenario.depth_format), kRelations)),
      alpha_(crossed(coverage, "compose/alpha", to_string(scenario.composition), kAlphas)),
      local_at_zero_(coverage, "compose/depth", "local at Z 0"),
      local_far_(coverage, "compose/depth", "local far"),
      upstream_background_(coverage, "compose/depth", "upstream is background"),
      upstream_renderer_(coverage, "compose/depth", "upstream is another renderer's"),
      source_row_again_(coverage, "composer/replication", "source row read again"),
      full_(coverage, "composer/buffer", "full"),
      one_free_(coverage, "composer/buffer", "exactly one free"),
      pixel_in_and_out_(coverage, "composer/buffer", "pixel in and pixel out in a clock") {}

void ComposerCoverage::clock_edge(const ComposerWires& wires) {
    if (!in_step_) return;
    sample_edge(wires);
    if (wires.bus.kind == rtl::BusBeat::Kind::kNone) {
        bus_.kind = rtl::BusBeat::Kind::kNone;  // most clocks: no words need be copied
    } else {
        bus_ = wires.bus;
    }
    pipe_in_ = wires.pipe_in;
    column_stall_ = wires.column_stall;
    stall_ = wires.stall;
}

void ComposerCoverage::sample_edge(const ComposerWires& outputs) {
    starved_ = pixels_in_ = pixel_out_ = false;
    position_ = -1;
    if (!column_stall_) {
        in_step_ = in_step_ && outputs.pipe_out.valid == running_;
        if (running_ && in_step_) {
            composite();
        } else if (outputs.startframe_out) {
            in_step_ = in_step_ && buffer_.has_frame();
            if (!in_step_) return;
            running_ = true;
            ++frame_;
            walker_ = SegmentWalker(buffer_.segment(), buffer_.has_segment(), raster_width_, raster_height_);
            starved_in_row_ = 0;
            starved_pixel_ = -1;
        }
    } else if (stall_ && running_) {
        cover_stall();
    }
    ++clocks_since_beat_;
    ready_clocks_ = outputs.busready ? ready_clocks_ + 1 : 0;
    take_beat();
    if (!in_step_) return;
    cover_busready(outputs.busready);
    cover_buffer();
}

bool ComposerCoverage::competes() const {
    // A burst seen now was driven at the edge before, and granted there or as long ago as a page takes to open.
    const std::int64_t since_grant = 1 + cycles_per_beat(scenario_.bus) + scenario_.memory.page_miss_cycles;
    return in_step_ && buffer_.missing_pixels() > 0 && ready_clocks_ > since_grant;
}

// ---- the pipeline side ----

void ComposerCoverage::composite() {
    position_ = std::int64_t{walker_.y()} * raster_width_ + walker_.x();
    if (walker_.covered()) {
        const std::int64_t k = walker_.pixel();
        if (!buffer_.abandoned()) {
            if (buffer_.has_arrived(k)) {
                cover_composition(buffer_.at_address(buffer_.address_of(k)), pipe_in_.pixel);
                cover_local_address(k);
            } else {
                cover_starved(k);
            }
        }
        if (walker_.last_use()) {
            pixel_out_ = buffer_.has_arrived(k);
            buffer_.release_through(k);
        }
    }
    walker_.advance();
    if (walker_.done()) end_frame();
}

void ComposerCoverage::cover_composition(Pixel local, Pixel upstream) {
    if (renderer_ == 0) upstream = background_;  // the top composer makes it itself
    const std::size_t relation = relation_of(local, upstream);
    const bool tie = local.z() == upstream.z();
    const bool upstream_is_background = upstream == background_;
    relation_[relation].hit();
    format_relation_[relation].hit();
    alpha_[alpha_of(local)].hit();
    local_at_zero_.hit_if(local.z() == 0);
    const bool far = local.z() == far_z(scenario_.depth_format);
    local_far_.hit_if(far);
    upstream_background_.hit_if(upstream_is_background);
    upstream_renderer_.hit_if(!upstream_is_background);
    const char* group = "compose/depth";
    coverage_.hit_if(tie && local.z() == 0, group, "tie at Z 0");
    coverage_.hit_if(tie && far && upstream_is_background, group, "tie far with the background");
    coverage_.hit_if(tie && !upstream_is_background, group, "tie between two renderers");
    coverage_.hit_if(local.z() + 1 == upstream.z() || upstream.z() + 1 == local.z(), group,
                     "differ in the lowest bit");
    if (scenario_.composition == Composition::kOver) cover_front(local, upstream);
}

void ComposerCoverage::cover_front(Pixel local, Pixel upstream) {
    const bool local_in_front = local.z() < upstream.z();
    const Pixel front = local_in_front ? local : upstream;
    const Pixel back = local_in_front ? upstream : local;
    const char* group = "compose/front";
    coverage_.hit(group,
                  both(local_in_front ? "local in front" : "upstream in front", kAlphas[alpha_of(front)]));
    coverage_.hit_if(saturates(front.r(), back.r(), front.a()) || saturates(front.g(), back.g(), front.a()) ||
                         saturates(front.b(), back.b(), front.a()),
                     group, "channel saturates");
}

/// A local pixel that is read.
void ComposerCoverage::cover_local_address(std::int64_t k) {
    const int address = buffer_.address_of(k);
    coverage_.hit_if(address == 0 && k > 0, "composer/buffer", "read address wraps");
    source_row_again_.hit_if(walker_.replayed());
    coverage_.hit_if(k == starved_pixel_, "composer/replication",
                     "repetitions of a pixel starve, later ones do not");
    const ViewportRow& row = buffer_.segment().row();
    const std::int64_t last = walker_.row_first_pixel() + row.sdx - 1;
    coverage_.hit_if(row.dmultiple > 1 && walker_.column() == 0 && buffer_.has_arrived(last) &&
                         buffer_.address_of(last) < address,
                     "composer/buffer", "row of a window lies across the wrap");
}

void ComposerCoverage::cover_starved(std::int64_t k) {
    starved_ = true;
    starved_pixel_ = k;
    const Segment& segment = buffer_.segment();
    const int x = walker_.x();
    if (x == segment.left()) starved_in_row_ = 0;
    ++starved_in_row_;
    const char* group = "starvation/place";
    const std::size_t renderers = scenario_.renderers.size();
    const bool last = k == segment.pixels() - 1;
    coverage_.hit_if(last, group, "last of a segment");
    coverage_.hit_if(!last, group, "in between");
    coverage_.hit_if(position_ == std::int64_t{raster_width_} * raster_height_ - 1, group,
                     "last raster pixel");
    coverage_.hit_if(starved_in_row_ == segment.right() - segment.left(), group,
                     "whole raster row of a segment");
    coverage_.hit_if(walker_.replayed(), group, "repetition of a replicated pixel");
    coverage_.hit_if(renderers > 1 && renderer_ == 0, group, "in the top composer");
    coverage_.hit_if(renderers > 1 && renderer_ == renderers - 1, group, "in the bottom composer");
    coverage_.hit(group, frame_ == 0 ? "in the first frame" : "in a later frame");
    coverage_.hit_if(buffer_.held_pixels() == 0, "composer/buffer", "empty when a pixel is needed");
}

void ComposerCoverage::cover_stall() {
    const char* group = "stall";
    const std::size_t renderers = scenario_.renderers.size();
    const std::int64_t position = std::int64_t{walker_.y()} * raster_width_ + walker_.x();
    coverage_.hit_if(position == std::int64_t{raster_width_} * raster_height_ - 1, group,
                     "for the last raster pixel");
    if (walker_.covered()) {
        coverage_.hit_if(walker_.pixel() == buffer_.segment().pixels() - 1, group,
                         "for the last of a segment");
    }
    if (renderers > 1) {
        coverage_.hit_if(renderer_ == 0, group, "top composer");
        coverage_.hit_if(renderer_ == renderers - 1, group, "bottom composer");
        coverage_.hit_if(renderer_ > 0 && renderer_ < renderers - 1, group, "composer in between");
    }
    coverage_.hit_if(buffer_.held_pixels() == 0, "composer/buffer", "empty when a pixel is needed");
}

void ComposerCoverage::end_frame() {
    running_ = false;
    if (!buffer_.can_begin_frame() && pushed_of_newest_ > 0) {
        coverage_.hit("frames/sequence", buffer_.missing_pixels() == 0
                                             ? "next frame wholly prefetched while compositing"
                                             : "next frame prefetched in part while compositing");
    }
    buffer_.end_frame();
}

// ---- the bus side ----

void ComposerCoverage::take_beat() {
    if (bus_.kind == rtl::BusBeat::Kind::kNone) return;
    in_step_ = !table_is_lost();
    if (!in_step_) return;
    switch (bus_.kind) {
        case rtl::BusBeat::Kind::kNone:
            break;
        case rtl::BusBeat::Kind::kPixels:
            if (bus_.destination == display_) take_pixels();
            break;
        case rtl::BusBeat::Kind::kFrameStart:
            begin_frame();
            break;
        case rtl::BusBeat::Kind::kTableRow:
            if (bus_.destination == display_) {
                row_ = bus_.row();
                row_came_ = true;
                buffer_.set_row(row_);
            }
            if (bus_.last) end_table();
            break;
    }
}

/// Whether the beat tells that a frame's start or a table row has not come, as it does by frame and place.
bool ComposerCoverage::table_is_lost() {
    const bool starts = bus_.kind == rtl::BusBeat::Kind::kFrameStart;
    const bool is_row = bus_.kind == rtl::BusBeat::Kind::kTableRow;
    const int begun = static_cast<std::uint8_t>(bus_.frame - (buffer_.frames_heard() - 1));
    const int unseen = begun - (starts ? 1 : 0);
    const bool row_missing = buffer_.table_open() && (!is_row || bus_.first > rows_of_table_);
    if (unseen <= 0 && !row_missing) {
        rows_of_table_ = is_row ? rows_of_table_ + 1 : 0;
        return false;
    }
    const char* group = "faults/lost-table";
    const std::string told_by = starts ? "the next frame's start" : (is_row ? "a row" : "pixels");
    coverage_.hit(group, std::string(unseen > 0 ? "start" : "rows") + ", told by " + told_by);
    coverage_.hit_if(unseen > 1, group, "several frames");
    return true;
}

void ComposerCoverage::begin_frame() {
    in_step_ = buffer_.can_begin_frame();
    if (!in_step_) return;
    coverage_.hit_if(running_, "frames/sequence", "table comes while compositing");
    coverage_.hit_if(column_stall_, "stall", "next frame's table comes");
    if (const std::int64_t missing = buffer_.missing_pixels(); missing > 0) buffer_.lose(missing);
    buffer_.begin_frame();
    pushed_of_newest_ = 0;
    row_came_ = false;
    if (bus_.last) end_table();
}

void ComposerCoverage::end_table() {
    buffer_.end_table();
    const char* group = "frames/sequence";
    if (tables_++ > 0) {
        coverage_.hit_if(row_came_ && !had_segment_, group, "segment where none was");
        coverage_.hit_if(!row_came_ && had_segment_, group, "no segment where one was");
        coverage_.hit_if(row_came_ && had_segment_ && row_ != row_before_, group, "segment moved");
    }
    had_segment_ = row_came_;
    row_before_ = row_;
}

void ComposerCoverage::take_pixels() {
    const std::optional<std::int64_t> next = buffer_.next_pixel();
    const bool frame_is_over = !buffer_.has_frame();
    in_step_ = next && bus_.first >= *next;
    if (!in_step_) return;
    if (bus_.first > *next) buffer_.lose(bus_.first - *next);
    // On a narrow bus the beat that was moving comes when its burst has been given up on.
    const bool behind_cut = burst_cut_ && clocks_since_beat_ == cycles_per_beat(scenario_.bus);
    clocks_since_beat_ = 0;
    if (announced_ == 0 && !behind_cut) {
        beats_of_burst_ = 0;
        burst_before_cut_ = burst_cut_;
        burst_cut_ = false;
    }
    ++beats_of_burst_;
    const bool next_frame = running_ && !buffer_.can_begin_frame();
    coverage_.hit_if(next_frame, "frames/sequence", "pixels of the next frame come while compositing");
    for (std::size_t i = 0; i < bus_.count; ++i) {
        in_step_ = in_step_ && (buffer_.free_pixels() > 0 || !buffer_.keeps_next());
        if (!in_step_) return;
        if (buffer_.push(Pixel(bus_.words[i]))) {
            pixels_in_ = true;
            ++pushed_;
            ++pushed_of_newest_;
            coverage_.hit_if(pushed_ % buffer_.capacity_pixels() == 0, "composer/buffer",
                             "write address wraps");
        } else if (!buffer_.abandoning()) {
            cover_late(frame_is_over);
        }
    }
    announced_ = static_cast<int>(bus_.remaining);
}

void ComposerCoverage::cover_late(bool frame_is_over) {
    const char* group = "composer/late";
    if (frame_is_over) {
        coverage_.hit(group, "of a frame that is over");
        return;
    }
    coverage_.hit(
        group, row_.dmultiple > 1 ? "behind a replicated pixel's last repetition" : "behind their last use");
}

/// What the composer answered at the edge.
void ComposerCoverage::cover_busready(bool busready) {
    if (cut_) {
        cut_ = false;
        announced_ = 0;
    }
    if (busready) return;
    const char* group = "bus/busready-drop";
    const bool beat = bus_.kind == rtl::BusBeat::Kind::kPixels && bus_.destination == display_;
    if (announced_ <= pixels_per_beat_) {
        if (!beat || burst_cut_) return;
        coverage_.hit_if(announced_ > 0, group, "rest fits a beat: burst goes on, no further slot");
        coverage_.hit_if(announced_ == 0 && beats_of_burst_ > 1, group,
                         "behind the last beat: no further slot");
        coverage_.hit_if(announced_ == 0 && beats_of_burst_ == 1, group,
                         "behind a burst of one beat: no further slot");
        return;
    }
    cut_ = true;
    burst_cut_ = true;
    const bool near_end = announced_ <= kBeatsInFlight * pixels_per_beat_;
    coverage_.hit_if(beats_of_burst_ == 1, group, "behind the first beat");
    coverage_.hit_if(beats_of_burst_ > 1 && !near_end, group, "in the middle");
    coverage_.hit_if(near_end, group, "when one beat more would end it");
    coverage_.hit_if(burst_before_cut_, group, "two bursts of a composer running");
    coverage_.hit_if(cycles_per_beat(scenario_.bus) > 1, group, "on a bus of several clocks a pixel");
    coverage_.hit_if(row_.dmultiple > 1, group, "segment is replicated");
    coverage_.hit(group,
                  running_ && buffer_.can_begin_frame() ? "frame is composited" : "frame is only prefetched");
    coverage_.hit(group, to_string(scenario_.bus.arbitration));
}

void ComposerCoverage::cover_buffer() {
    const int free = buffer_.free_pixels();
    full_.hit_if(free == 0);
    one_free_.hit_if(free == 1 && buffer_.capacity_pixels() > 1);
    pixel_in_and_out_.hit_if(pixels_in_ && pixel_out_);
    const char* group = "composer/buffer";
    coverage_.hit_if(running_ && pixel_out_ && buffer_.held_pixels() == 0 && buffer_.missing_pixels() > 0,
                     group, "empty while its segment is composited");
    coverage_.hit_if(
        !buffer_.can_begin_frame() && pushed_of_newest_ > 0 && buffer_.held_pixels() > pushed_of_newest_,
        group, "two frames' pixels at once");
}

}  // namespace metabuffer::coverage
