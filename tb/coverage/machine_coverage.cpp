#include "machine_coverage.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "rtl/wires.h"

namespace metabuffer::coverage {

ClockRatio clock_ratio(std::int64_t core_picoseconds, std::int64_t out_picoseconds) {
    if (core_picoseconds == out_picoseconds) return ClockRatio::kEqual;
    if (core_picoseconds < out_picoseconds) {
        return out_picoseconds % core_picoseconds == 0 ? ClockRatio::kSlowerByWholeFactor
                                                       : ClockRatio::kSlower;
    }
    return core_picoseconds % out_picoseconds == 0 ? ClockRatio::kFasterByWholeFactor : ClockRatio::kFaster;
}

MachineCoverage::MachineCoverage(const sc_core::sc_module_name& name, rtl::Metabuffer& machine,
                                 const Scenario& scenario)
    : sc_core::sc_module(name),
      machine_(machine),
      scenario_(scenario),
      renderers_(scenario.renderers.size()),
      displays_(static_cast<std::size_t>(scenario.displays.count())),
      goals_(coverage_),
      display_(goals_.display),
      handshakes_(goals_.handshake, machine.faults()),
      beats_(renderers_),
      tables_ready_(renderers_, true),
      frames_seen_(renderers_),
      contested_(static_cast<std::size_t>(scenario.frames)) {
    for (std::size_t r = 0; r < renderers_; ++r) {
        buses_.emplace_back(goals_.bus, scenario_, r);
        links_.emplace_back(goals_.link, scenario_);
        memories_.emplace_back(goals_.memory, scenario_);
        arbiters_.emplace_back(goals_.arbiter, scenario_);
        for (std::size_t d = 0; d < displays_; ++d) {
            composers_.emplace_back(goals_.composer, scenario_, r, static_cast<int>(d) + 1);
            fifos_.emplace_back(goals_.fifo, scenario_);
        }
    }
    for (std::size_t d = 0; d < displays_; ++d) {
        columns_.emplace_back(goals_.column, scenario_, static_cast<int>(d) + 1);
        ColumnWires column;
        column.pipeready.resize(renderers_ + 1);
        column.startframe.resize(renderers_ + 1);
        column.stall.resize(renderers_);
        column_wires_.push_back(std::move(column));
        std::vector<const ComposerCoverage*> composers;
        for (std::size_t r = 0; r < renderers_; ++r) composers.push_back(&composers_[r * displays_ + d]);
        column_composers_.push_back(std::move(composers));
    }
    for (std::size_t i = 0; i < composers_.size(); ++i) stalls_.push_back(&machine_.wires().stall[i]);
    for (const rtl::MachineFaults::Handshaking& wire : machine_.faults().handshakes()) {
        if (wire.handshake != rtl::Handshake::kStall) continue;
        stalls_[wire.renderer * displays_ + wire.display] = &wire.driven;
    }
    display_wires_.framedone.resize(displays_);
    for (const BusCoverage& bus : buses_) all_buses_.push_back(&bus);
    SC_METHOD(core_edge);
    sensitive << machine_.core_clk().posedge_event();
    dont_initialize();
    // Not by a clock, since a fault can give a link its own.
    SC_METHOD(link_events);
    for (std::size_t r = 0; r < renderers_; ++r) sensitive << machine_.wires().event[r];
    dont_initialize();
}

void MachineCoverage::core_edge() {
    if (machine_.reset().read()) return;
    sample_composers();
    sample_buses();
    sample_columns();
    sample_displays();
    handshakes_.clock_edge();
    sample_inner_wires();
}

void MachineCoverage::link_events() {
    for (std::size_t r = 0; r < renderers_; ++r) {
        auto& wire = machine_.wires().event[r];
        if (wire.event()) links_[r].event(wire.read(), buses_[r]);
    }
}

void MachineCoverage::sample_composers() {
    rtl::Wires& wires = machine_.wires();
    for (std::size_t i = 0; i < composers_.size(); ++i) {
        const std::size_t below = i + displays_;
        const monitors::ComposerInputs inputs{wires.bus_seen_by(i).read(), wires.startframe[i].read(),
                                              wires.pipe[i].read(), wires.pipeready[below].read(),
                                              wires.column_stall[i % displays_].read()};
        composers_[i].clock_edge(
            {inputs, wires.pipe[below].read(), wires.startframe[below].read(), wires.busready[i].read()});
    }
}

/// The composers have just sampled the edge before, so the buses' beats of that edge are sampled now.
void MachineCoverage::sample_buses() {
    rtl::Wires& wires = machine_.wires();
    for (std::size_t r = 0; r < renderers_; ++r) {
        const rtl::BusBeat& beat = beats_[r];
        const ComposerCoverage* destination = nullptr;
        if (beat.kind == rtl::BusBeat::Kind::kPixels && beat.destination >= 1 &&
            beat.destination <= displays_) {
            destination = &composers_[r * displays_ + beat.destination - 1];
            if (!destination->in_step()) destination = nullptr;
        }
        buses_[r].clock(beat, destination, tables_ready_[r]);
        if (destination != nullptr && destination->beats_of_burst() == 1) {
            sample_competition(r, *destination);
        }
        if (buses_[r].frames() != frames_seen_[r]) {
            links_[r].frame_starts(frames_seen_[r]);
            frames_seen_[r] = buses_[r].frames();
        }
        beats_[r] = wires.bus[r].read();
        tables_ready_[r] = true;
        for (std::size_t d = 0; d < displays_; ++d) {
            tables_ready_[r] = tables_ready_[r] && wires.tableready[r * displays_ + d].read();
        }
    }
}

/// A burst begins: samples whether another composer of the bus wanted it too.
void MachineCoverage::sample_competition(std::size_t renderer, const ComposerCoverage& granted) {
    const auto frame = static_cast<std::size_t>(buses_[renderer].frames()) - 1;
    if (frame >= contested_.size() || contested_[frame]) return;
    for (std::size_t d = 0; d < displays_; ++d) {
        const ComposerCoverage& composer = composers_[renderer * displays_ + d];
        if (&composer != &granted && composer.competes()) contested_[frame] = true;
    }
}

void MachineCoverage::sample_columns() {
    rtl::Wires& wires = machine_.wires();
    for (std::size_t d = 0; d < displays_; ++d) {
        ColumnWires& column = column_wires_[d];
        for (std::size_t r = 0; r <= renderers_; ++r) {
            column.pipeready[r] = wires.pipeready[r * displays_ + d].read();
            column.startframe[r] = wires.startframe[r * displays_ + d].read();
            if (r < renderers_) column.stall[r] = stalls_[r * displays_ + d]->read();
        }
        column.column_stall = wires.column_stall[d].read();
        column.pipe_out = wires.pipe[renderers_ * displays_ + d].read();
        columns_[d].clock_edge(column, column_composers_[d], all_buses_);
    }
    if (displays_ < 2) return;
    const auto stalled = std::count_if(columns_.begin(), columns_.end(),
                                       [](const ColumnCoverage& column) { return column.stalled(); });
    if (stalled == 0) return;
    goals_.columns_stall.all_at_once.hit_if(stalled == static_cast<std::ptrdiff_t>(displays_));
    goals_.columns_stall.one_while_another_runs.hit_if(
        std::any_of(columns_.begin(), columns_.end(),
                    [](const ColumnCoverage& column) { return column.running() && !column.stalled(); }));
}

void MachineCoverage::sample_displays() {
    rtl::Wires& wires = machine_.wires();
    DisplayWires& display = display_wires_;
    for (std::size_t d = 0; d < displays_; ++d) display.framedone[d] = wires.framedone[d].read();
    display.swaplock = wires.swaplock.read();
    display.swapskip = wires.swapskip.read();
    display.vsync = wires.link_out_driven(0).read().vsync;
    display.de = wires.link_out_driven(0).read().de;
    display_.clock_edge(display);
}

/// A replaced block may have no such wires.
void MachineCoverage::sample_inner_wires() {
    for (std::size_t r = 0; r < renderers_; ++r) {
        if (rtl::FramebufferWires* const wires = machine_.inner_wires(r); wires != nullptr) {
            memories_[r].clock(wires->command.read());
            arbiters_[r].clock(*wires);
        }
        for (std::size_t d = 0; d < displays_; ++d) {
            if (rtl::FifoWires* const wires = machine_.fifo_wires(r, d); wires != nullptr) {
                fifos_[r * displays_ + d].clock(*wires);
            }
        }
    }
}

void MachineCoverage::finished(const RunReport& report) {
    cover_run(goals_.run, scenario_, report);
    cover_combination(report);
    if (displays_ > 1) cover_columns_together();
}

/// Counts contested frames, as far as the displays have shown them.
void MachineCoverage::cover_combination(const RunReport& report) {
    const std::size_t shown = std::min(contested_.size(), static_cast<std::size_t>(report.frames_shown()));
    const auto end = contested_.begin() + static_cast<std::ptrdiff_t>(shown);
    const auto frames = std::count(contested_.begin(), end, true);
    const ClockRatio ratio = clock_ratio(clock_period_picoseconds(scenario_.clocks.core_mhz),
                                         clock_period_picoseconds(scenario_.clocks.dvi_out_mhz));
    const BusConfig& bus = scenario_.bus;
    goals_.combination.bins(bus.arbitration, bus.width_bits, ratio, scenario_.composer.on_starvation)
        .hit(frames);
}

void MachineCoverage::cover_columns_together() {
    const auto same = [this](std::size_t frame, auto edges) {
        return std::all_of(columns_.begin(), columns_.end(), [&](const ColumnCoverage& column) {
            return edges(column)[frame] == edges(columns_.front())[frame];
        });
    };
    const auto starts = [](const ColumnCoverage& column) -> const std::vector<std::int64_t>& {
        return column.starts();
    };
    const auto ends = [](const ColumnCoverage& column) -> const std::vector<std::int64_t>& {
        return column.ends();
    };
    std::size_t started = columns_.front().starts().size();
    std::size_t ended = columns_.front().ends().size();
    for (const ColumnCoverage& column : columns_) {
        started = std::min(started, column.starts().size());
        ended = std::min(ended, column.ends().size());
    }
    for (std::size_t frame = 0; frame < started; ++frame) {
        const bool together = same(frame, starts);
        const ColumnsSequenceGoals& goals = goals_.columns_sequence;
        (together ? goals.start_together : goals.start_apart).hit();
        (together ? goals_.columns_ready.same_clock : goals_.columns_ready.different_clocks).hit();
    }
    for (std::size_t frame = 0; frame < ended; ++frame) {
        goals_.columns_sequence.end_apart.hit_if(!same(frame, ends));
    }
}

}  // namespace metabuffer::coverage
