#include "tlm/composer.h"

#include <algorithm>

#include "datapath/span.h"
#include "report/waits.h"

namespace metabuffer::tlm {
namespace {

/// A band of raster rows stays in a processor's cache while every composer of the column works on it.
constexpr std::int64_t kBandPixels = 16'384;

int rows_a_band(const DisplayConfig& displays) {
    const auto rows = static_cast<int>(kBandPixels / displays.raster_width_pixels());
    const int blocks = std::max(1, rows / displays.supersample);
    return std::min(blocks * displays.supersample, displays.raster_height_pixels());
}

/// The weights of the raster columns of a segment, and room for its rows.
void start_smoothing(const Segment& segment, SmoothingLines& lines) {
    const ViewportRow& row = segment.row();
    const int width = segment.right() - segment.left();
    BlendCounter counter(row.dmultiple, (segment.left() - row.dx) % row.dmultiple);
    lines.weights_x.resize(static_cast<std::size_t>(width));
    for (std::uint32_t& weight : lines.weights_x) {
        weight = static_cast<std::uint32_t>(counter.weight());
        counter.step();
    }
    for (SmoothingLines::Source& source : lines.sources) {
        source.row = -1;
    }
    if (lines.mixed.width_pixels != width) {
        lines.mixed = PixelPlanes(width, 1);
        for (SmoothingLines::Source& source : lines.sources) {
            source.own = source.beside = lines.mixed;
        }
    }
}

/// Each source column of a row as often as it shows, and as often as it is the neighbour.
void lay_out(const PixelPlanes& content, const Segment& segment, int source_row,
             SmoothingLines::Source& source) {
    const ViewportRow& row = segment.row();
    const std::size_t first = content.index(row.sx, row.sy + source_row);
    const PixelSpan pixels{&content.argb[first], &content.z[first]};
    const auto width = static_cast<std::size_t>(segment.right() - segment.left());
    replicate_span(pixels, row.dmultiple, segment.left() - row.dx, source.own.argb.data(),
                   source.own.z.data(), width);
    const int half = row.dmultiple / 2;
    const int middle = row.dmultiple % 2;  // a raster column of each block that has no neighbour
    const auto fill = [&](int x, int count, int column) {
        const int begin = std::clamp(x, segment.left(), segment.right()) - segment.left();
        const int end = std::clamp(x + count, segment.left(), segment.right()) - segment.left();
        const auto of = static_cast<std::size_t>(std::clamp<int>(column, 0, row.sdx - 1));
        std::fill(source.beside.argb.begin() + begin, source.beside.argb.begin() + end, pixels.argb[of]);
        std::fill(source.beside.z.begin() + begin, source.beside.z.begin() + end, pixels.z[of]);
    };
    for (int column = 0; column < row.sdx; ++column) {
        const int x = row.dx + column * row.dmultiple;
        fill(x, half, column - 1);
        fill(x + half, middle, column);
        fill(x + half + middle, half, column + 1);
    }
    source.row = source_row;
}

}  // namespace

Composer::Composer(const sc_core::sc_module_name& name, const Scenario& scenario, const Agenda& agenda,
                   ColumnTime& column, ColumnRelays& relays, const Settings& settings)
    : sc_core::sc_module(name),
      scenario_(scenario),
      settings_(settings),
      core_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      agenda_(agenda),
      column_(column),
      relays_(relays),
      buffer_({settings.renderer, scenario.composer.buffer_pixels, scenario.composer.ready_space_pixels,
               pixels_per_beat(scenario.bus, scenario.memory), cycles_per_beat(scenario.bus),
               in_flight_pixels(scenario.bus, scenario.memory), scenario.bus.register_stages,
               scenario.displays.raster_width_pixels(), scenario.displays.raster_height_pixels(),
               scenario.composer.smoothing},
              column) {
    notice_.payload().set_address(static_cast<sc_dt::uint64>(settings.display));
    bus_socket.register_b_transport(this, &Composer::take_transfer);
    pipe_in_socket.register_b_transport(this, &Composer::take_band);
    pipe_in_socket.register_nb_transport_fw(this, &Composer::take_startframe);
    pipe_out_socket.register_nb_transport_bw(this, &Composer::take_pipeready);
    if (settings.observer != nullptr) {
        const auto report_level = [this](std::int64_t cycle, int held_pixels) {
            settings_.observer->buffer_level(settings_.renderer + 1, settings_.display, cycle, held_pixels);
        };
        buffer_.on_level(report_level, settings_.observer->level_wanted_cycle());
    }
    if (pipemaster()) {
        SC_METHOD(send_frame_down);
        sensitive << composited_event_;
        dont_initialize();
        if (settings.images) {
            raster_ = PixelPlanes(scenario.displays.raster_width_pixels(), rows_a_band(scenario.displays));
            line_ = PixelPlanes(scenario.displays.raster_width_pixels(), 1);
            if (scenario.composer.smoothing == Smoothing::kBilinear) {
                smoothing_lines_ = std::make_unique<SmoothingLines>();
            }
        }
    }
}

// ---- the bus ----

void Composer::take_transfer(Payload& payload, sc_core::sc_time& /*delay*/) {
    auto& transfer = content_of<BusTransfer>(payload);
    switch (transfer.kind) {
        case BusTransfer::Kind::kTable:
            take_table(transfer);
            break;
        case BusTransfer::Kind::kBeats:
            take_beats(transfer);
            break;
        case BusTransfer::Kind::kVerdict:
            transfer.verdict = buffer_.busready_in_burst(transfer.beat, agenda_.now());
            if (transfer.verdict == BufferTime::Verdict::kDropped) {
                buffer_.count_drop(transfer.beat.sampled);
            }
            break;
        case BusTransfer::Kind::kEndOfBurst:
            give_slot(transfer);
            break;
    }
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
}

void Composer::take_table(const BusTransfer& transfer) {
    buffer_.begin_frame(transfer.frame, transfer.row, transfer.table_cycle, agenda_.now());
    content_[static_cast<std::size_t>(transfer.frame % kFramesKept)] = transfer.content;
    raise_pipeready();
}

void Composer::take_beats(BusTransfer& transfer) {
    const int pixels_per_beat = buffer_.config().pixels_per_beat;
    BeatRun beats = transfer.beats;
    transfer.verdict = BufferTime::Verdict::kTaken;
    if (transfer.heed_busready) {
        const std::int64_t planned = buffer_.planned_pixels();
        const int burst_left = beats.pixels + transfer.remaining;
        std::int64_t sampled = beats.first_cycle + 1;
        int sent = 0;
        while (sent < beats.pixels) {
            sent = std::min(sent + pixels_per_beat, beats.pixels);
            transfer.verdict =
                buffer_.busready_in_burst({planned + sent, sampled, burst_left - sent}, agenda_.now());
            if (transfer.verdict != BufferTime::Verdict::kTaken) {
                break;
            }
            sampled += buffer_.config().cycles_per_beat;
        }
        beats.pixels = sent;
        if (transfer.verdict == BufferTime::Verdict::kDropped) {
            buffer_.count_drop(sampled);
        }
    }
    transfer.pixels_taken = beats.pixels;
    buffer_.add(beats, agenda_.now());
    raise_pipeready();
    if (column_.may_stall() && column_.started(transfer.frame)) {
        column_.advance(agenda_.now());
        column_.call_waiters();
    }
}

void Composer::give_slot(BusTransfer& transfer) {
    transfer.slot = buffer_.slot_time(transfer.earliest, agenda_.now());
    if (transfer.slot.cycle != kUnknownCycle) {
        return;
    }
    earliest_slot_ = transfer.earliest;
    if (!slot_wanted_) {
        slot_wanted_ = true;
        column_.when_known(transfer.slot.frame, transfer.slot.step, [this] { report_slot(); });
    }
}

void Composer::report_slot() {
    slot_wanted_ = false;
    notice_->slot_cycle = buffer_.slot_time(earliest_slot_, agenda_.now()).cycle;
    transport_backward(bus_socket, notice_.payload(), busready_phase);
}

/// The end of a frame is known, and with it the clock of TABLEREADY for the table two frames later.
void Composer::report_table(int frame) {
    notice_->frame = frame + 2;
    notice_->table_cycle = buffer_.frame_end_cycle(frame);
    transport_backward(bus_socket, notice_.payload(), tableready_phase);
}

// ---- PIPEREADY and STARTFRAME ----

::tlm::tlm_sync_enum Composer::take_pipeready(Payload& payload, Phase& /*phase*/,
                                              sc_core::sc_time& /*delay*/) {
    below_pipeready_ = content_of<PipelineFrame>(payload).cycle;
    raise_pipeready();
    return ::tlm::TLM_ACCEPTED;
}

/// PIPEREADY rises in the clock that sees both PIPEREADY from below and this composer prefetched.
void Composer::raise_pipeready() {
    const std::int64_t prefetched = buffer_.prefetched_cycle(next_frame_);
    if (below_pipeready_ == kUnknownCycle || prefetched == kUnknownCycle) {
        return;
    }
    const int frame = next_frame_++;
    own_pipeready_ = std::max(prefetched, below_pipeready_ + 1);
    below_pipeready_ = kUnknownCycle;
    if (pipemaster()) {
        start_column(frame, own_pipeready_ + 1);
        return;
    }
    pipeline_->frame = frame;
    pipeline_->cycle = own_pipeready_;
    relays_.pipeready.pass(
        [this] { transport_backward(pipe_in_socket, pipeline_.payload(), pipeready_phase); });
}

/// The PIPEMASTER answers its own PIPEREADY with STARTFRAME.
void Composer::start_column(int frame, std::int64_t cycle) {
    column_.start(frame, cycle);
    pipeline_->frame = frame;
    pipeline_->cycle = cycle;
    start_frame(pipeline_.payload());
    if (column_.may_stall()) {
        column_.advance(agenda_.now());
    }
    column_.when_known(frame, column_.last_step(), [this, frame] {
        composited_event_.notify(core_.until(column_.frame(frame).cycle_of(column_.last_step())));
    });
    column_.call_waiters();
}

::tlm::tlm_sync_enum Composer::take_startframe(Payload& payload, Phase& /*phase*/,
                                               sc_core::sc_time& /*delay*/) {
    start_frame(payload);
    return ::tlm::TLM_ACCEPTED;
}

void Composer::start_frame(Payload& payload) {
    const int frame = content_of<PipelineFrame>(payload).frame;
    buffer_.start_frame(frame);
    if (frame + 2 < scenario_.frames) {
        column_.when_known(frame, buffer_.frame_end_step(), [this, frame] { report_table(frame); });
    }
    relays_.startframe.pass(
        [this, &payload] { transport_forward(pipe_out_socket, payload, startframe_phase); });
}

// ---- compositing ----

/// The frame's last pixel has left the column by its clock; now the values of all its pixels follow at once.
void Composer::send_frame_down() {
    column_.note_composited();
    const int height = scenario_.displays.raster_height_pixels();
    const int band_rows = settings_.images ? raster_.height_pixels : height;
    pipeline_->frame = column_.newest_frame();
    pipeline_->raster = settings_.images ? &raster_ : nullptr;
    pipeline_->line = settings_.images ? &line_ : nullptr;
    pipeline_->smoothing = smoothing_lines_.get();
    for (int first_row = 0; first_row < height; first_row += band_rows) {
        pipeline_->first_row = first_row;
        pipeline_->rows = std::min(band_rows, height - first_row);
        if (settings_.images) {
            fill_span(scenario_.background_pixel(), raster_.argb.data(), raster_.z.data(), raster_.z.size());
        }
        sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
        take_band(pipeline_.payload(), delay);
    }
}

/// The delay is zero all the way, since the column's time already has the pixels' clocks.
void Composer::take_band(Payload& payload, sc_core::sc_time& /*delay*/) {
    const auto& band = content_of<PipelineFrame>(payload);
    if (band.first_row == 0) {
        buffer_.close_frame(band.frame, column_.raster_pixels(), agenda_.now());
        next_starved_ = 0;
        if (settings_.observer != nullptr && buffer_.segment(band.frame) != nullptr) {
            for (const StarvedRun& run : buffer_.starved(band.frame)) {
                settings_.observer->starved(settings_.renderer + 1, settings_.display, run);
            }
        }
    }
    if (band.raster != nullptr) {
        composite(band);
    }
    if (band.first_row + band.rows == scenario_.displays.raster_height_pixels()) {
        content_[static_cast<std::size_t>(band.frame % kFramesKept)].reset();
    }
    relays_.pixels.pass([this, &payload] { transport(pipe_out_socket, payload); });
}

void Composer::composite(const PipelineFrame& band) {
    const Segment* const segment = buffer_.segment(band.frame);
    const FrameContent& content = content_[static_cast<std::size_t>(band.frame % kFramesKept)];
    if (segment == nullptr || content == nullptr) {
        return;
    }
    line_row_ = -1;
    if (segment->smooths()) {
        start_smoothing(*segment, *band.smoothing);
    }
    const int first = std::max(segment->top(), band.first_row);
    const int last = std::min(segment->bottom(), band.first_row + band.rows);
    for (int y = first; y < last; ++y) {
        composite_row(band, y, *content, *segment);
    }
}

/// The segment's local pixels of a raster row, from its left on.
PixelSpan Composer::smoothed_row(const PipelineFrame& band, int y, const PixelPlanes& content,
                                 const Segment& segment) const {
    SmoothingLines& lines = *band.smoothing;
    const ViewportRow& row = segment.row();
    const BlendCounter counter(row.dmultiple, (y - row.dy) % row.dmultiple);
    const int own_row = (y - row.dy) / row.dmultiple;
    const int other = own_row + counter.side();
    const bool has_other = other != own_row && other >= 0 && other < row.sdy;
    const auto source_of = [&](int source_row) -> const SmoothingLines::Source& {
        // Of two rows that are neighbours, one is even.
        SmoothingLines::Source& source = lines.sources[static_cast<std::size_t>(source_row % 2)];
        if (source.row != source_row) {
            lay_out(content, segment, source_row, source);
        }
        return source;
    };
    const auto span_of = [](const PixelPlanes& planes) {
        return PixelSpan{planes.argb.data(), planes.z.data()};
    };
    const SmoothingLines::Source& own = source_of(own_row);
    const SmoothingLines::Source& across = has_other ? source_of(other) : own;
    BlendSpans spans{span_of(own.own), span_of(own.beside), span_of(across.own), span_of(across.beside)};
    spans.weights_x = lines.weights_x.data();
    spans.weight_y = has_other ? counter.weight() : 0;
    blend_span(scenario_.composition, far_z(scenario_.depth_format), spans, lines.mixed.argb.data(),
               static_cast<std::size_t>(segment.right() - segment.left()));
    return {lines.mixed.argb.data(), spans.own.z};
}

void Composer::composite_row(const PipelineFrame& band, int y, const PixelPlanes& content,
                             const Segment& segment) {
    const ViewportRow& row = segment.row();
    const int source_row = (y - row.dy) / row.dmultiple;
    const auto width = static_cast<std::size_t>(segment.right() - segment.left());
    const std::size_t source = content.index(row.sx, row.sy + source_row);
    PixelSpan local{&content.argb[source], &content.z[source]};
    if (segment.smooths()) {
        local = smoothed_row(band, y, content, segment);
    } else if (row.dmultiple > 1) {  // only the first source column may begin left of the raster
        if (source_row != line_row_) {
            const int clipped = segment.left() - row.dx;  // raster pixels of the segment left of the raster
            replicate_span(local, row.dmultiple, clipped, band.line->argb.data(), band.line->z.data(), width);
            line_row_ = source_row;
        }
        local = {band.line->argb.data(), band.line->z.data()};
    }
    const std::size_t target = band.raster->index(segment.left(), y - band.first_row);
    const auto compose_run = [&](int x_begin, int x_end) {
        const auto offset = static_cast<std::size_t>(x_begin - segment.left());
        compose_span(scenario_.composition, {local.argb + offset, local.z + offset},
                     &band.raster->argb[target + offset], &band.raster->z[target + offset],
                     static_cast<std::size_t>(x_end - x_begin));
    };
    // Where a pixel starved, the upstream one passes.
    const std::vector<StarvedRun>& starved = buffer_.starved(band.frame);
    int x = segment.left();
    for (; next_starved_ < starved.size() && starved[next_starved_].y == y; ++next_starved_) {
        if (starved[next_starved_].x_first > x) {
            compose_run(x, starved[next_starved_].x_first);
        }
        x = starved[next_starved_].x_last + 1;
    }
    if (x < segment.right()) {
        compose_run(x, segment.right());
    }
}

// ---- what a run reports ----

const ComposerCounters& Composer::finish(std::int64_t through_cycle) {
    // A run that the watchdog has ended may be in the middle of a frame.
    if (const int frame = column_.newest_frame(); frame >= 0) {
        const std::int64_t composited = column_.frame(frame).step_at(through_cycle) - settings_.renderer;
        buffer_.close_frame(frame, std::clamp<std::int64_t>(composited, 0, column_.raster_pixels()),
                            through_cycle);
    }
    return buffer_.finish(through_cycle, column_.stalled_cycles_for(settings_.renderer, through_cycle));
}

std::string Composer::waiting_for(std::int64_t through_cycle) const {
    const int frame = column_.newest_frame();
    const std::int64_t step = frame < 0 ? -1 : column_.frame(frame).step_at(through_cycle);
    const std::int64_t position = step - settings_.renderer;
    if (position >= 0 && position < column_.raster_pixels()) {
        const int width = scenario_.displays.raster_width_pixels();
        const auto x = static_cast<int>(position % width);
        const auto y = static_cast<int>(position / width);
        const Segment* const segment = buffer_.segment(frame);
        if (column_.may_stall() && segment != nullptr && segment->covers(x, y) &&
            buffer_.arrived(frame, through_cycle) <= segment->newest_at(x, y)) {
            return waits::for_segment_pixel(segment->newest_at(x, y), frame, x, y);
        }
        return waits::for_column();
    }
    const int next = position < 0 && frame >= 0 ? frame : frame + 1;
    if (buffer_.table_cycle(next) > through_cycle) {
        return waits::for_table(next);
    }
    if (buffer_.prefetched_cycle(next) > through_cycle) {
        return waits::for_prefetch(next);
    }
    const bool raised = next_frame_ > next && own_pipeready_ <= through_cycle;
    return raised ? waits::for_startframe(next) : waits::for_pipeready(next);
}

}  // namespace metabuffer::tlm
