// clang-format off
// Before SystemC's headers: with them Verilator's expect its older, global names.
#include "VerilatedComposer.h"

#include "rtl/composer.h"
// clang-format on

#include <verilated.h>

#include <algorithm>
#include <string>

#include "report/waits.h"
#include "rtl/verilated_pin.h"
#include "scenario/derived_timing.h"

namespace metabuffer::rtl {

namespace {

// The codes of composer.sv.
constexpr int kKindNone = 0;
constexpr int kKindFrameStart = 1;
constexpr int kKindTableRow = 2;
constexpr int kKindPixels = 3;
static_assert(static_cast<int>(BusBeat::Kind::kNone) == kKindNone &&
              static_cast<int>(BusBeat::Kind::kFrameStart) == kKindFrameStart &&
              static_cast<int>(BusBeat::Kind::kTableRow) == kKindTableRow &&
              static_cast<int>(BusBeat::Kind::kPixels) == kKindPixels);
static_assert(static_cast<int>(Composition::kZ) == 0 && static_cast<int>(Composition::kZAlphaKey) == 1 &&
              static_cast<int>(Composition::kOver) == 2 && kCompositionTable.size() == 3);
static_assert(static_cast<int>(Smoothing::kReplicate) == 0 && static_cast<int>(Smoothing::kBilinear) == 1 &&
              kSmoothingTable.size() == 2);
constexpr int kErrorNone = 0;
constexpr int kErrorFull = 1;
constexpr int kErrorOrder = 2;
constexpr int kErrorNoTable = 3;
constexpr int kErrorTables = 4;
constexpr int kErrorFrame = 5;

constexpr int kMaximumBufferPixels = COMPOSER_MAX_BUFFER_PIXELS;
constexpr int kWindowRows = COMPOSER_WINDOW_ROWS;
constexpr int kHalfWordBits = 32;
/// Registers that reset does not set start with random values.
constexpr int kRandomRegisters = 2;

bool high(unsigned char pin) { return pin != 0; }

}  // namespace

Composer::Composer(const sc_core::sc_module_name& name, const Scenario& scenario, int display)
    : Block(name),
      stall_mode_(scenario.composer.on_starvation == StarvationMode::kStall),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      context_(std::make_unique<VerilatedContext>()) {
    context_->randReset(kRandomRegisters);
    context_->randSeed(display);
    verilated_ = std::make_unique<VerilatedComposer>(context_.get(), "composer");
    configure(scenario, display);
}

Composer::~Composer() { verilated_->final(); }

void Composer::configure(const Scenario& scenario, int display) {
    const SmoothingRow& smoothing = row_of(kSmoothingTable, scenario.composer.smoothing);
    if (smoothing.window_rows > kWindowRows) {
        SC_REPORT_ERROR("/metabuffer/composer/smoothing",
                        (std::string(name()) + ": the verilated composer has a window of " +
                         std::to_string(kWindowRows) + " source row, and " + smoothing.name + " needs " +
                         std::to_string(smoothing.window_rows) + "; build with -DCOMPOSER_WINDOW_ROWS=2")
                            .c_str());
    }
    const int buffer_pixels = scenario.composer.buffer_pixels;
    if (buffer_pixels > kMaximumBufferPixels) {
        SC_REPORT_ERROR("/metabuffer/composer/size",
                        (std::string(name()) + ": the scenario's buffer of " + std::to_string(buffer_pixels) +
                         " pixels is larger than the verilated composer's memory of " +
                         std::to_string(kMaximumBufferPixels) +
                         "; build with -DCOMPOSER_MAX_BUFFER_PIXELS=N, N a power of two")
                            .c_str());
    }
    verilated_->clk_i = 0;
    verilated_->reset_i = 1;
    verilated_->display_i = static_cast<SData>(display);
    verilated_->raster_width_i = static_cast<SData>(scenario.displays.raster_width_pixels());
    verilated_->raster_height_i = static_cast<SData>(scenario.displays.raster_height_pixels());
    put(verilated_->buffer_pixels_i, static_cast<std::uint32_t>(buffer_pixels));
    // More than the buffer holds is never free.
    put(verilated_->ready_space_pixels_i,
        static_cast<std::uint32_t>(
            std::min(scenario.composer.ready_space_pixels, 2 * kMaximumBufferPixels - 1)));
    verilated_->pixels_per_beat_i = static_cast<CData>(pixels_per_beat(scenario.bus, scenario.memory));
    verilated_->longest_gap_cycles_i = static_cast<IData>(longest_beat_gap_cycles(scenario));
    verilated_->in_flight_pixels_i = static_cast<CData>(in_flight_pixels(scenario.bus, scenario.memory));
    verilated_->cut_cycles_i = static_cast<CData>(busready_cut_cycles(scenario.bus, scenario.memory));
    verilated_->composition_i = static_cast<CData>(scenario.composition);
    verilated_->stall_mode_i = stall_mode_ ? 1 : 0;
    verilated_->smoothing_i = static_cast<CData>(smoothing.value);
    verilated_->far_z_i = far_z(scenario.depth_format);
    verilated_->background_i = scenario.background_pixel().word();
    verilated_->eval();
}

/// One rising edge: the pins have their present values, and the outputs change after it as registers do.
void Composer::clock_edge() {
    const Before before{high(verilated_->running_o), verilated_->x_o, verilated_->y_o};
    drive_inputs();
    verilated_->clk_i = 1;
    verilated_->eval();
    verilated_->clk_i = 0;
    verilated_->eval();
    drive_outputs();
    if (reset_i.read()) {
        pipemaster_ = pipemaster_i.read();
        clocked_.stay_awake();
        return;
    }
    count(before);
    report_protocol_error();
    if (!idle(before.running)) {
        clocked_.stay_awake();
    }
}

void Composer::drive_inputs() {
    verilated_->reset_i = reset_i.read() ? 1 : 0;
    verilated_->pipemaster_i = pipemaster_i.read() ? 1 : 0;
    verilated_->startframe_i = startframe_i.read() ? 1 : 0;
    verilated_->pipeready_i = pipeready_i.read() ? 1 : 0;
    verilated_->column_stall_i = column_stall_i.read() ? 1 : 0;
    const PipePixel& upstream = pipe_i.read();
    verilated_->pipe_pixel_i = upstream.pixel.word();
    verilated_->pipe_lost_i = upstream.lost ? 1 : 0;

    const BusBeat& beat = bus_i.read();
    verilated_->bus_kind_i = static_cast<CData>(beat.kind);
    if (beat.kind == BusBeat::Kind::kNone) {
        return;  // the other pins of the bus mean nothing
    }
    verilated_->bus_last_i = beat.last ? 1 : 0;
    verilated_->bus_frame_i = beat.frame;
    verilated_->bus_count_i = beat.count;
    verilated_->bus_destination_i = beat.destination;
    verilated_->bus_remaining_i = static_cast<SData>(beat.remaining);
    verilated_->bus_first_i = beat.first;
    for (std::size_t i = 0; i < beat.count; ++i) {
        verilated_->bus_words_i[2 * i] = static_cast<EData>(beat.words[i]);
        verilated_->bus_words_i[2 * i + 1] = static_cast<EData>(beat.words[i] >> kHalfWordBits);
    }
}

void Composer::drive_outputs() {
    busready_o.write(high(verilated_->busready_o));
    tableready_o.write(high(verilated_->tableready_o));
    startframe_o.write(high(verilated_->startframe_o));
    pipe_o.write(PipePixel{Pixel(verilated_->pipe_pixel_o), high(verilated_->pipe_valid_o),
                           high(verilated_->pipe_lost_o)});
    pipeready_o.write(high(verilated_->pipeready_o));
    stall_o.write(high(verilated_->stall_o));
}

/// The counters are not part of the hardware: they follow from the status outputs about the edge just past.
void Composer::count(const Before& before) {
    const std::int64_t cycle = clock_edge_number(core_period_picoseconds_);
    count_frame(before, cycle);
    if (high(verilated_->starved_o)) {
        count_starved_pixel({static_cast<int>(verilated_->frame_o), before.x, before.y}, cycle);
    }
    if (high(verilated_->stall_o)) {
        note_starved(cycle);
    }
    if (high(verilated_->cut_o)) {
        count_busready_drop(cycle);
    }
    counters_.replayed_pixels += verilated_->replayed_o;
    counters_.stalled_cycles += verilated_->stalled_o;
    counters_.late_pixels += verilated_->late_o;
    counters_.lost_pixels += verilated_->lost_o;
    counters_.lost_tables += verilated_->lost_tables_o;
    counters_.buffer_high_water = std::max<std::int64_t>(counters_.buffer_high_water, verilated_->held_o);
}

void Composer::count_frame(const Before& before, std::int64_t cycle) {
    if (!before.running && high(verilated_->running_o)) {
        frame_spans_.emplace_back();
        frame_spans_.back().startframe_cycle = cycle;
    }
    if (high(verilated_->composited_o) && before.x == 0 && before.y == 0) {
        frame_spans_.back().start_cycle = cycle;
    }
    if (before.running && !high(verilated_->running_o)) {
        frame_spans_.back().end_cycle = cycle;
    }
}

void Composer::report_protocol_error() const {
    if (verilated_->error_o == kErrorNone) {
        return;
    }
    std::string text = std::string(name()) + " was sent ";
    if (verilated_->error_o == kErrorFull) {
        text += "a pixel for a full buffer";
    } else if (verilated_->error_o == kErrorOrder || verilated_->error_o == kErrorNoTable) {
        text += "pixel " + std::to_string(bus_i.read().first) + " of its segment when ";
        text += verilated_->error_o == kErrorNoTable ? "it was sent no table"
                                                     : std::to_string(verilated_->expected_o) + " was next";
    } else if (verilated_->error_o == kErrorTables) {
        text += "a third frame's table";
    } else if (verilated_->error_o == kErrorFrame) {
        text += "a beat of a frame that is over, or that cannot have begun";
    } else {
        text += "row " + std::to_string(bus_i.read().first) + " of a table again";
    }
    SC_REPORT_ERROR("/metabuffer/composer/protocol", text.c_str());
}

/// No frame runs or starts, nothing comes over the bus, and nothing is on its way to a register.
bool Composer::idle(bool was_running) const {
    return !high(verilated_->running_o) && !was_running && !high(verilated_->startframe_o) &&
           !startframe_i.read() && !high(verilated_->pipe_valid_o) && !high(verilated_->cutting_o) &&
           verilated_->announced_o == 0 && !(pipemaster_ && high(verilated_->pipeready_o)) &&
           bus_i.read().kind == BusBeat::Kind::kNone;
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
    // The status outputs of the verilated module, which stay where they are in memory.
    sc_core::sc_trace(file, verilated_->running_o, path("running"), 1);
    sc_core::sc_trace(file, verilated_->frame_o, path("frame"));
    sc_core::sc_trace(file, verilated_->x_o, path("x"));
    sc_core::sc_trace(file, verilated_->y_o, path("y"));
    sc_core::sc_trace(file, verilated_->row_first_pixel_o, path("window_row_pixel"));
    sc_core::sc_trace(file, verilated_->column_o, path("window_column"));
    sc_core::sc_trace(file, verilated_->row_phase_o, path("window_repetition"));
    sc_core::sc_trace(file, verilated_->held_o, path("buffer_held"));
    sc_core::sc_trace(file, verilated_->announced_o, path("announced"));
    sc_core::sc_trace(file, verilated_->starved_o, path("starved"), 1);
}

std::string Composer::waiting_for() const {
    const auto frame = static_cast<std::int32_t>(verilated_->frame_o);
    if (high(verilated_->running_o)) {
        return high(verilated_->stall_o)
                   ? waits::for_segment_pixel(verilated_->pixel_o, frame, static_cast<int>(verilated_->x_o),
                                              static_cast<int>(verilated_->y_o))
                   : waits::for_column();
    }
    const std::int32_t next = frame + 1;
    if (!high(verilated_->table_complete_o)) {
        return waits::for_table(next);
    }
    if (!high(verilated_->prefetched_o)) {
        return waits::for_prefetch(next);
    }
    return high(verilated_->pipeready_o) ? waits::for_startframe(next) : waits::for_pipeready(next);
}

}  // namespace metabuffer::rtl
