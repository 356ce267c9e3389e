#include "rtl/composer.h"

#include <algorithm>

#include "report/waits.h"
#include "scenario/derived_timing.h"

namespace metabuffer::rtl {
namespace {

/// A bus cannot have reached a frame number that is farther ahead of the newest frame's than this.
constexpr int kMostFramesAhead = 65535;
constexpr std::int64_t kNoPixel = -1;

/// Bits of the index of a segment's pixel, or of none.
int pixel_bits(const Scenario& scenario) {
    const DisplayConfig& displays = scenario.displays;
    return 1 + bits_for(std::int64_t{displays.raster_width_pixels()} * displays.raster_height_pixels());
}

}  // namespace

Composer::Composer(const sc_core::sc_module_name& name, const Scenario& scenario, int display,
                   ClockGating gating)
    : Block(name),
      display_(static_cast<std::uint16_t>(display)),
      composition_(scenario.composition),
      on_starvation_(scenario.composer.on_starvation),
      smoothing_(scenario.composer.smoothing),
      far_z_(far_z(scenario.depth_format)),
      background_{scenario.background_pixel(), true, false},
      raster_width_(scenario.displays.raster_width_pixels()),
      raster_height_(scenario.displays.raster_height_pixels()),
      ready_space_pixels_(scenario.composer.ready_space_pixels),
      pixels_per_beat_(pixels_per_beat(scenario.bus, scenario.memory)),
      in_flight_pixels_(in_flight_pixels(scenario.bus, scenario.memory)),
      cut_cycles_(busready_cut_cycles(scenario.bus, scenario.memory)),
      longest_gap_cycles_(longest_beat_gap_cycles(scenario)),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      gate_(gating),
      fifo_wires_(row_of(kSmoothingTable, smoothing_).window_rows),
      fifo_("fifo", scenario.composer.buffer_pixels, gating, row_of(kSmoothingTable, smoothing_).window_rows),
      buffer_(registers_, "buffer", 1,
              ComposerBuffer(scenario.composer.buffer_pixels, raster_width_, raster_height_, smoothing_)),
      walker_(registers_, "", 1, SegmentWalker(Segment{}, false, raster_width_, raster_height_)),
      ahead_(registers_, "ahead", 1, walker_.value()),
      read_pixel_(registers_, "read_pixel", pixel_bits(scenario), kNoPixel),
      word_pixel_(registers_, "word_pixel", pixel_bits(scenario), kNoPixel),
      bypass_pixel_(registers_, "bypass_pixel", pixel_bits(scenario), kNoPixel),
      window_(fifo_wires_.second_row == nullptr
                  ? nullptr
                  : std::make_unique<SmoothingWindow>(registers_, fifo_wires_, pixel_bits(scenario))),
      announced_(registers_, "announced", bits_for(scenario.bus.burst_pixels)),
      silent_cycles_(registers_, "silent_cycles", bits_for(longest_gap_cycles_)),
      burst_cut_(registers_, "burst_cut", bits_for(cut_cycles_)),
      next_row_(registers_, "next_row", bits_for(scenario.displays.count())),
      frame_(registers_, "frame", 1 + bits_for(scenario.frames), -1) {
    fifo_.clk_i(clk_i);
    fifo_.reset_i(reset_i);
    fifo_.write_i(fifo_wires_.write);
    fifo_.read_i(fifo_wires_.read);
    fifo_.release_i(fifo_wires_.release);
    fifo_.word_o(fifo_wires_.word);
    fifo_.free_o(fifo_wires_.free);
    if (fifo_wires_.second_row != nullptr) {
        fifo_.second_row->next_word_o(fifo_wires_.second_row->next_word);
        fifo_.second_row->row_read_i(fifo_wires_.second_row->read);
        fifo_.second_row->row_word_o(fifo_wires_.second_row->word);
        fifo_.second_row->row_next_word_o(fifo_wires_.second_row->row_next_word);
    }
    SC_METHOD(clock_edge);
    sensitive << clk_i.pos();
    dont_initialize();
}

void Composer::reset() {
    registers_.reset();
    pipemaster_ = pipemaster_i.read();
    busready_o.write(false);
    tableready_o.write(false);
    startframe_o.write(false);
    pipeready_o.write(false);
    stall_o.write(false);
    pipe_o.write(PipePixel{});
    fifo_wires_.write.write(FifoWrite{});
    fifo_wires_.read.write(FifoRead{});
    fifo_wires_.release.write(FifoRelease{});
    if (window_ != nullptr) {
        window_->reset();
    }
    kept_.count = 0;
    abandoned_pixels_ = 0;
}

void Composer::end_of_elaboration() {
    wake_events_ |= reset_i.value_changed_event();
    wake_events_ |= bus_i.value_changed_event();
    wake_events_ |= startframe_i.value_changed_event();
    wake_events_ |= pipeready_i.value_changed_event();
}

void Composer::clock_edge() {
    if (gate_.opened()) {
        return;
    }
    if (reset_i.read()) {
        reset();
        return;
    }
    const bool was_running = running_;
    const int held_before = buffer_->held_pixels();
    // Nothing ever raises COLUMNSTALL in glitch mode.
    if (on_starvation_ == StarvationMode::kGlitch || !column_stall_i.read()) {
        pipeline_edge();
    } else if (stall_) {
        ++counters_.stalled_cycles;
    }
    bus_edge();
    drive_fifo(held_before);
    drive_handshakes(was_running);
    if (gate_.idle_edge(idle(was_running))) {
        next_trigger(wake_events_);
    }
}

/// No frame runs or starts (a STARTFRAME may stay high while the column is stalled), nothing comes over the bus,
/// and nothing is on its way to a register.
bool Composer::idle(bool was_running) const {
    return !running_ && !was_running && !startframe_ && !startframe_i.read() && !pipe_valid_ &&
           burst_cut_ == 0 && announced_ == 0 && !(pipemaster_ && pipeready_) && !fifo_is_told() &&
           bus_i.read().kind == BusBeat::Kind::kNone;
}

// ---- the pipeline side ----

void Composer::pipeline_edge() {
    bool start = false;
    if (running_) {
        composite(pipemaster_ ? background_ : pipe_i.read());
    } else {
        if (pipe_valid_) {
            pipe_valid_ = false;
            starved_ = false;
            pipe_o.write(PipePixel{});
        }
        start = pipemaster_ ? pipeready_ : startframe_i.read();
        if (start) {
            start_frame();
        }
    }
    if (start != startframe_) {
        startframe_ = start;
        startframe_o.write(start);
    }
}

void Composer::start_frame() {
    running_ = true;
    buffer_->start_frame();
    walker_ = SegmentWalker(buffer_->segment(), buffer_->has_segment(), raster_width_, raster_height_);
    ahead_ = walker_;
    ahead_->advance();
    ++frame_;
    frame_spans_.emplace_back();
    frame_spans_.back().startframe_cycle = clock_edge_number(core_period_picoseconds_);
}

void Composer::composite(const PipePixel& upstream) {
    if (walker_->x() == 0 && walker_->y() == 0) {
        frame_spans_.back().start_cycle = clock_edge_number(core_period_picoseconds_);
    }
    const bool abandoned = buffer_->abandoned();
    PipePixel out{upstream.pixel, true, upstream.lost || abandoned};
    starved_ = walker_->covered() && !abandoned && !buffer_->has_arrived(walker_->newest_pixel());
    if (walker_->covered()) {
        if (starved_) {
            count_glitch({frame_, walker_->x(), walker_->y()}, clock_edge_number(core_period_picoseconds_));
        } else if (!abandoned) {
            out.pixel =
                compose(composition_, window_ != nullptr ? smoothed_pixel() : local_pixel(walker_->pixel()),
                        upstream.pixel);
            counters_.replayed_pixels += walker_->replayed() ? 1 : 0;
        }
        if (const std::int64_t released = walker_->released(); released != kNoPixel) {
            buffer_->release_through(released);
        }
    }
    pipe_o.write(out);
    pipe_valid_ = true;
    walker_->advance();
    if (walker_->done()) {
        end_frame();
    } else {
        ahead_->advance();
    }
}

void Composer::end_frame() {
    running_ = false;
    frame_spans_.back().end_cycle = clock_edge_number(core_period_picoseconds_);
    buffer_->end_frame();
    word_pixel_ = kNoPixel;  // the pixel there belongs to this frame
    bypass_pixel_ = kNoPixel;
    if (window_ != nullptr) {
        window_->forget();
    }
}

bool Composer::next_pixel_missing() const {
    return running_ && walker_->covered() && !buffer_->abandoned() &&
           !buffer_->has_arrived(walker_->newest_pixel());
}

// ---- the bus side ----

void Composer::bus_edge() {
    const BusBeat& beat = bus_i.read();
    if (beat.kind != BusBeat::Kind::kNone && !follow_frames(beat)) {
        return;
    }
    switch (beat.kind) {
        case BusBeat::Kind::kNone:
            break;
        case BusBeat::Kind::kFrameStart:
            begin_frame(beat);
            break;
        case BusBeat::Kind::kTableRow:
            take_row(beat);
            break;
        case BusBeat::Kind::kPixels:
            lose_open_table();  // pixels come after the table's last row
            if (beat.destination == display_) {
                take_pixels(beat);
                return;
            }
            break;
    }
    if (announced_ > 0) {
        ++silent_cycles_;
        if (silent_cycles_ == longest_gap_cycles_) {
            // What was announced does not come: it is lost, or something other than this composer stopped its burst.
            announced_ = 0;
        }
    }
}

/// Every beat names its frame, and the bus finishes a frame before it begins the next. So a beat shows what was lost of
/// the frames before it, and of its own frame if the start of that was lost. False, and reported, for a frame that is
/// over or cannot have begun.
bool Composer::follow_frames(const BusBeat& beat) {
    const bool begins = beat.kind == BusBeat::Kind::kFrameStart;
    const auto newest = static_cast<std::uint32_t>(buffer_->frames_heard() - 1);
    const auto behind_newest = static_cast<std::int32_t>(beat.frame - newest);
    if (behind_newest < (begins ? 1 : 0) || behind_newest > kMostFramesAhead) {
        protocol_error("a beat of a frame that is over, or that cannot have begun");
        return false;
    }
    if (begins && !buffer_->can_begin_frame()) {
        protocol_error("a third frame's table");
        return false;
    }
    if (behind_newest > 0) {
        lose_open_table();
        if (const std::int64_t missing = buffer_->missing_pixels(); missing > 0) {
            lose_pixels(missing);
        }
        for (int begun = begins ? 1 : 0; begun < behind_newest; ++begun) {
            ++counters_.lost_tables;
            buffer_->miss_frame();
        }
    }
    return true;
}

void Composer::begin_frame(const BusBeat& beat) {
    buffer_->begin_frame();
    next_row_ = 0;
    if (beat.last) {
        buffer_->end_table();
    }
}

void Composer::take_row(const BusBeat& beat) {
    if (buffer_->table_lost()) {
        return;
    }
    if (!buffer_->table_open() || beat.first < next_row_) {
        protocol_error("row " + std::to_string(beat.first) + " of a table again");
        return;
    }
    if (beat.first > next_row_) {
        lose_open_table();
        return;
    }
    ++next_row_;
    if (beat.destination == display_) {
        buffer_->set_row(beat.row());
    }
    if (beat.last) {
        buffer_->end_table();
    }
}

/// The rows that the newest frame's table lacks will not come. One of them may have been this composer's.
void Composer::lose_open_table() {
    if (buffer_->table_open()) {
        ++counters_.lost_tables;
        buffer_->lose_table();
    }
}

void Composer::take_pixels(const BusBeat& beat) {
    if (!buffer_->table_lost() && !keep_pixels(beat)) {
        return;
    }
    announced_ = static_cast<int>(beat.remaining);
    silent_cycles_ = 0;
}

/// False, and reported, if the bus has broken its protocol.
bool Composer::keep_pixels(const BusBeat& beat) {
    const std::optional<std::int64_t> next = buffer_->next_pixel();
    if (!next || beat.first < *next) {
        protocol_error("pixel " + std::to_string(beat.first) + " of its segment when " +
                       (next ? std::to_string(*next) + " was next" : "it was sent no table"));
        return false;
    }
    if (beat.first > *next) {
        lose_pixels(beat.first - *next);
    }
    for (int i = 0; i < beat.count; ++i) {
        if (buffer_->free_pixels() == 0 && buffer_->keeps_next()) {
            protocol_error("a pixel for a full buffer");
            return false;
        }
        const auto address = static_cast<std::uint32_t>(buffer_->write_address());
        if (!buffer_->push()) {
            counters_.late_pixels += buffer_->abandoning() ? 0 : 1;
            continue;
        }
        if (kept_.count == 0) {
            kept_.address = address;
        }
        kept_.words[kept_.count++] = beat.words[static_cast<std::size_t>(i)];
    }
    counters_.buffer_high_water = std::max<std::int64_t>(counters_.buffer_high_water, buffer_->held_pixels());
    return true;
}

void Composer::protocol_error(const std::string& what) const {
    SC_REPORT_ERROR("/metabuffer/composer/protocol", (std::string(name()) + " was sent " + what).c_str());
}

void Composer::lose_pixels(std::int64_t count) {
    counters_.lost_pixels += count;
    const int held = buffer_->held_pixels();
    buffer_->lose(count);
    abandoned_pixels_ += static_cast<std::uint32_t>(held - buffer_->held_pixels());
}

// ---- the FIFO ----

/// The FIFO reads, writes or releases pixels at this edge.
bool Composer::fifo_is_told() const {
    return fifo_wires_.read.read().enable || fifo_wires_.write.read().count > 0 ||
           fifo_wires_.release.read().any() || (window_ != nullptr && window_->reads());
}

/// Called after the pipeline and the bus side: which of this clock's pixels the FIFO stores and releases, and what it
/// reads.
void Composer::drive_fifo(int held_before) {
    if (window_ == nullptr) {
        follow_read();
        read_ahead();
    } else {
        window_->follow_read();
        if (running_ && walker_->covered()) {
            window_->next(walker_->window(), buffer_, bus_i.read(), kept_.count > 0);
        }
        const std::optional<BlendWindow<std::int64_t>> ahead = window_ahead();
        window_->read_ahead(ahead ? &*ahead : nullptr, buffer_);
    }
    if (kept_.count > 0 || fifo_wires_.write.read().count > 0) {
        fifo_wires_.write.write(kept_);
    }
    FifoRelease release;
    release.newest = abandoned_pixels_;
    release.oldest =
        static_cast<std::uint32_t>(held_before + kept_.count - buffer_->held_pixels()) - abandoned_pixels_;
    if (release.any() || fifo_wires_.release.read().any()) {
        fifo_wires_.release.write(release);
    }
    kept_.count = 0;
    abandoned_pixels_ = 0;
}

/// At this edge the FIFO puts out what it was commanded to read. If the next position shows another pixel, that pixel
/// bypasses the FIFO: it has come at this edge, or the column stands still and the pixel that stood at the output is
/// still to be used.
void Composer::follow_read() {
    const std::int64_t stood = word_pixel_;
    if (fifo_wires_.read.read().enable) {
        word_pixel_ = read_pixel_;
    }
    if (!running_ || !walker_->covered()) {
        return;
    }
    const std::int64_t pixel = walker_->pixel();
    if (word_pixel_ == pixel || bypass_pixel_ == pixel) {
        return;
    }
    if (stood == pixel) {
        bypass_pixel_ = pixel;
        bypass_word_ = fifo_wires_.word.read();
        return;
    }
    const BusBeat& beat = bus_i.read();
    const std::int64_t place = pixel - std::int64_t{beat.first};
    if (kept_.count > 0 && place >= 0 && place < beat.count && buffer_->has_arrived(pixel)) {
        bypass_pixel_ = pixel;
        bypass_word_ = beat.words[static_cast<std::size_t>(place)];
    }
}

/// Commands the FIFO to read the pixel of the position after the next one, if it has arrived and is not in a register
/// yet.
void Composer::read_ahead() {
    const std::int64_t pixel = pixel_ahead();
    const bool reads = pixel != kNoPixel && pixel != word_pixel_ && pixel != bypass_pixel_ &&
                       buffer_->has_arrived(pixel) && !buffer_->abandoned();
    if (reads) {
        fifo_wires_.read.write({true, static_cast<std::uint32_t>(buffer_->address_of(pixel))});
        read_pixel_ = pixel;
    } else if (fifo_wires_.read.read().enable) {
        fifo_wires_.read.write({false, fifo_wires_.read.read().address});
    }
}

/// The pixel of the position after the next one; none where the segment does not show. Before a frame, that of its
/// first position.
std::int64_t Composer::pixel_ahead() const {
    if (running_) {
        return !ahead_->done() && ahead_->covered() ? ahead_->pixel() : kNoPixel;
    }
    const bool covered = buffer_->has_segment() && buffer_->segment().covers(0, 0);
    return covered ? 0 : kNoPixel;
}

/// The same for all the pixels that are mixed there.
std::optional<BlendWindow<std::int64_t>> Composer::window_ahead() const {
    if (running_) {
        if (ahead_->done() || !ahead_->covered()) return std::nullopt;
        return ahead_->window();
    }
    if (!buffer_->has_segment() || !buffer_->segment().covers(0, 0)) return std::nullopt;
    return buffer_->segment().window_at(0, 0);
}

// ---- the handshakes ----

bool Composer::slot_ready() const { return buffer_->free_pixels() - announced_ >= ready_space_pixels_; }

bool Composer::prefetched() const {
    return !running_ && buffer_->table_complete() &&
           (buffer_->segment_complete() || buffer_->free_pixels() < ready_space_pixels_);
}

void Composer::drive_handshakes(bool was_running) {
    if (burst_cut_ > 0) {
        --burst_cut_;
        if (burst_cut_ == 0) {
            announced_ = 0;
        }
    }
    bool busready = burst_cut_ == 0;
    if (!busready) {
        // What the bus sends before it reads the drop is still to come.
    } else if (announced_ > pixels_per_beat_) {
        busready = buffer_->free_pixels() >= std::min(announced_.value(), in_flight_pixels_);
        if (!busready) {
            burst_cut_ = cut_cycles_;
            count_busready_drop(clock_edge_number(core_period_picoseconds_));
        }
    } else {
        busready = slot_ready();
    }
    if (busready != busready_) {
        busready_ = busready;
        busready_o.write(busready);
    }
    const bool tableready = buffer_->wants_frame();
    if (tableready != tableready_) {
        tableready_ = tableready;
        tableready_o.write(tableready);
    }

    // A PIPEREADY from below that belongs to the frame just composited may still be high at the frame's last edge.
    const bool pipeready =
        !running_ && !was_running && !startframe_ && (pipeready_ || (prefetched() && pipeready_i.read()));
    if (pipeready != pipeready_) {
        pipeready_ = pipeready;
        pipeready_o.write(pipeready);
    }
    if (on_starvation_ == StarvationMode::kStall) {
        stall_ = next_pixel_missing();
        if (stall_) {
            note_starved(clock_edge_number(core_period_picoseconds_));
        }
        stall_o.write(stall_);
    }
}

void Composer::trace(sc_core::sc_trace_file* file) const {
    sc_core::sc_trace(file, pipemaster_i, path("PIPEMASTER"));
    sc_core::sc_trace(file, pipeready_i, path("PIPEREADY_in"));
    sc_core::sc_trace(file, pipeready_o, path("PIPEREADY"));
    sc_core::sc_trace(file, startframe_i, path("STARTFRAME_in"));
    sc_core::sc_trace(file, startframe_o, path("STARTFRAME"));
    sc_core::sc_trace(file, busready_o, path("BUSREADY"));
    sc_core::sc_trace(file, tableready_o, path("TABLEREADY"));
    sc_core::sc_trace(file, stall_o, path("STALL"));
    sc_trace(file, pipe_i.read(), path("PIPE_in"));
    sc_trace(file, pipe_o.read(), path("PIPE"));
    registers_.trace(file, path(""));
    if (window_ != nullptr) {
        walker_->visit_smoothing_state(StateTracer{file, path("")});
        ahead_->visit_smoothing_state(StateTracer{file, path("ahead_")});
    }
    fifo_.trace(file);
    trace_lanes(file, fifo_wires_.write.read().words, pixels_per_beat_, path("fifo.write.word"));
}

std::string Composer::waiting_for() const {
    if (running_) {
        return stall_ ? waits::for_segment_pixel(walker_->newest_pixel(), frame_, walker_->x(), walker_->y())
                      : waits::for_column();
    }
    const int next = frame_ + 1;
    if (!buffer_->table_complete()) {
        return waits::for_table(next);
    }
    if (!prefetched()) {
        return waits::for_prefetch(next);
    }
    return pipeready_ ? waits::for_startframe(next) : waits::for_pipeready(next);
}

}  // namespace metabuffer::rtl
