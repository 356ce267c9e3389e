#include "tlm/metabuffer.h"

#include <algorithm>
#include <utility>

#include "report/composer_record.h"
#include "scenario/derived_timing.h"
#include "scenario/fault_keys.h"
#include "simulation/numbered.h"

namespace metabuffer::tlm {
namespace {

constexpr std::int64_t kFirstCycle = 2;  ///< the first core clock without reset

/// Makes one more of a kind of module.
template <typename Module, typename... Arguments>
Module& make(std::vector<std::unique_ptr<Module>>& modules, const std::string& name,
             Arguments&&... arguments) {
    return *modules.emplace_back(
        std::make_unique<Module>(name.c_str(), std::forward<Arguments>(arguments)...));
}

}  // namespace

Metabuffer::Metabuffer(const sc_core::sc_module_name& name, const Scenario& scenario, Options options)
    : sc_core::sc_module(name),
      scenario_(scenario),
      options_(std::move(options)),
      core_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      dvi_in_(clock_period_picoseconds(scenario.clocks.dvi_in_mhz)),
      reset_picoseconds_(core_.picoseconds_of(kFirstCycle) - core_.period_picoseconds() / 2),
      shown_(displays()),
      watchdog_interval_(watchdog_interval_picoseconds(scenario)) {
    refuse_faults_of_level_rtl(scenario, "tlm");
    if (options_.images) {
        cache_ = std::make_unique<ContentCache>(scenario.depth_format);
    }
    agenda_ = std::make_unique<Agenda>("agenda", core_, [this] { return certain_end(); });
    make_display_side();
    make_renderer_side();
    make_composers();
    SC_METHOD(look);
    SC_METHOD(settle);
    sensitive << settle_event_;
    dont_initialize();
    SC_METHOD(finish);
    sensitive << finish_event_;
    dont_initialize();
}

/// For each destroyed port the kernel searches its list from the newest on, so the newest modules are destroyed first.
Metabuffer::~Metabuffer() {
    while (!composers_.empty()) {
        composers_.pop_back();
    }
    while (!buses_.empty()) {
        buses_.pop_back();
    }
}

void Metabuffer::make_display_side() {
    const ClockDomain dvi_out(clock_period_picoseconds(scenario_.clocks.dvi_out_mhz));
    swap_lock_ = std::make_unique<SwapLock>("swap_lock", scenario_, dvi_out.edge_from(reset_picoseconds_),
                                            kFirstCycle);
    swap_lock_->on_shown_by(options_.observer);
    const std::int64_t raster_pixels =
        std::int64_t{scenario_.displays.raster_width_pixels()} * scenario_.displays.raster_height_pixels();
    const bool may_stall = scenario_.composer.may_stall();
    for (std::size_t d = 0; d < displays(); ++d) {
        relays_.emplace_back();
        columns_.push_back(
            std::make_unique<ColumnTime>(static_cast<int>(renderers()), raster_pixels, may_stall));
        if (options_.observer != nullptr) {
            columns_.back()->on_stall([this, d](int frame, CycleSpan stall) {
                options_.observer->column_stall(static_cast<int>(d) + 1, frame, stall);
            });
        }
        OutputFramebuffer& framebuffer =
            make(output_framebuffers_, numbered("output_framebuffer", d), scenario_, static_cast<int>(d) + 1,
                 *columns_.back(), *swap_lock_, kFirstCycle);
        DviDisplay& display = make(dvi_displays_, numbered("dvi_display", d));
        framebuffer.dvi_socket.bind(display.dvi_socket);
        display.on_frame([this, d](int frame, const ColourImage* image) { frame_shown(d, frame, image); });
    }
}

Metabuffer::Memory Metabuffer::make_memory(const char* name, int renderer) const {
    if (options_.make_memory) {
        return options_.make_memory(name, scenario_, renderer);
    }
    auto memory = std::make_unique<FrameMemory>(name, scenario_.memory, kFirstCycle);
    AnyTargetSocket<MemoryAccess>* const socket = &memory->socket;
    return {std::move(memory), socket};
}

void Metabuffer::make_renderer_side() {
    const std::int64_t first_link_edge = dvi_in_.edge_from(reset_picoseconds_);
    for (std::size_t r = 0; r < renderers(); ++r) {
        const auto index = static_cast<int>(r);
        DviSource& source = make(dvi_sources_, numbered("dvi_source", r), scenario_, index, first_link_edge);
        DviDecoder& decoder = make(dvi_decoders_, numbered("dvi_decoder", r), scenario_.renderers[r].timing(),
                                   scenario_.links.latency_clocks());
        const InputFramebuffer::Settings settings{index, first_link_edge, kFirstCycle, cache_.get(),
                                                  options_.observer};
        InputFramebuffer& framebuffer =
            make(input_framebuffers_, numbered("input_framebuffer", r), scenario_, *agenda_, settings);
        auto& request = make(pair_requests_, numbered("pair_request", r), true);
        source.pair_request_i(request);
        framebuffer.pair_request_o(request);
        source.link_socket.bind(decoder.link_socket);
        decoder.framebuffer_socket.bind(framebuffer.link_socket);
        frame_memories_.push_back(make_memory(numbered("frame_memory", r).c_str(), index));
        framebuffer.memory_socket.bind(*frame_memories_.back().socket);
        Bus& bus = make(buses_, numbered("bus", r), static_cast<int>(displays()));
        framebuffer.bus_socket.bind(bus.framebuffer_socket);
    }
}

void Metabuffer::make_composers() {
    for (std::size_t r = 0; r < renderers(); ++r) {
        for (std::size_t d = 0; d < displays(); ++d) {
            const Composer::Settings settings{static_cast<int>(r), static_cast<int>(d) + 1, options_.images,
                                              options_.observer};
            Composer& made = make(composers_, numbered("composer", r, d), scenario_, *agenda_, *columns_[d],
                                  relays_[d], settings);
            buses_[r]->composer_socket(settings.display).bind(made.bus_socket);
            if (r > 0) composer(r - 1, d).pipe_out_socket.bind(made.pipe_in_socket);
        }
    }
    for (std::size_t d = 0; d < displays(); ++d) {
        composer(renderers() - 1, d).pipe_out_socket.bind(output_framebuffers_[d]->pipe_socket);
    }
}

/// The run ends when the last frame has been shown, long after its last pixel has been composited, or at a check of the
/// watchdog.
std::int64_t Metabuffer::certain_end() const {
    const std::int64_t before_look = next_look_ == 0 ? kUnknownCycle : core_.edge_at(next_look_ - 1);
    if (swap_lock_->end_picoseconds() != kUnknownCycle) {
        return std::min(before_look, core_.edge_at(swap_lock_->end_picoseconds()));
    }
    std::int64_t end = 0;
    for (const auto& column : columns_) {
        end = std::max(end, column->not_before(scenario_.frames - 1, column->last_step(), agenda_->now()));
    }
    return std::min(before_look, end);
}

// ---- the end of a run ----

void Metabuffer::frame_shown(std::size_t display, int frame, const ColourImage* image) {
    const bool on_all_displays = shown_.add(display, frame);
    if (image != nullptr && on_frame_shown_) {
        std::vector<int> pairs;
        std::int64_t starved_pixels = 0;
        for (std::size_t r = 0; r < renderers(); ++r) {
            pairs.push_back(input_framebuffers_[r]->frame_sources()[static_cast<std::size_t>(frame)].pair);
            starved_pixels += composer(r, display).buffer().counters().starved_pixels_of(frame);
        }
        on_frame_shown_({frame, static_cast<int>(display) + 1, *image, pairs, starved_pixels, false});
    }
    if (on_all_displays) {
        if (options_.observer != nullptr) {
            for (std::size_t d = 0; d < displays(); ++d) {
                options_.observer->composited(static_cast<int>(d) + 1, frame,
                                              columns_[d]->composition(frame));
            }
        }
        if (shown_.on_all_displays() == scenario_.frames) {
            settle_event_.notify(sc_core::SC_ZERO_TIME);
        }
    }
}

std::int64_t Metabuffer::progress(std::int64_t picoseconds) const {
    const std::int64_t cycle = picoseconds == 0 ? -1 : core_.edge_at(picoseconds - 1);
    const std::int64_t link_edge = picoseconds == 0 ? -1 : dvi_in_.edge_at(picoseconds - 1);
    std::int64_t count = raster_pixels_taken(cycle) +
                         swap_lock_->swaps_before(picoseconds) * static_cast<std::int64_t>(displays());
    for (const auto& framebuffer : input_framebuffers_) {
        count += framebuffer->bus_progress(cycle);
        if (scenario_.pacing == Pacing::kLockstep) {
            count += framebuffer->link_pixels(link_edge);  // a free-running link never stops
        }
    }
    return count;
}

/// The watchdog.
void Metabuffer::look() {
    if (finished_) {
        return;
    }
    const std::int64_t count = progress(now_picoseconds());
    if (count == last_progress_) {
        watchdog_tripped_ = true;
        settle_event_.notify(sc_core::SC_ZERO_TIME);
        return;
    }
    last_progress_ = count;
    next_look_ = now_picoseconds() + watchdog_interval_;
    next_trigger(sc_core::sc_time::from_value(static_cast<sc_dt::uint64>(watchdog_interval_)));
}

/// In a separate delta cycle, so that every block has executed the present clock before.
void Metabuffer::settle() { finish_event_.notify(sc_core::SC_ZERO_TIME); }

void Metabuffer::finish() {
    if (finished_) {
        return;
    }
    finished_ = true;
    report_ = make_report();
    if (on_finished_) {
        on_finished_();
    }
}

// ---- what a run reports ----

std::int64_t Metabuffer::raster_pixels_taken(std::int64_t through_cycle) const {
    std::int64_t count = 0;
    for (const auto& framebuffer : output_framebuffers_) {
        count += framebuffer->pixels_taken(through_cycle);
    }
    return count;
}

/// All columns have composited the frame.
std::int64_t Metabuffer::last_pixel_cycle(int frame) const {
    std::int64_t cycle = 0;
    for (const auto& column : columns_) cycle = std::max(cycle, column->composition(frame).last);
    return cycle;
}

/// Buses run ahead of each other, and what starves is counted when a frame has been composited. Once a frame has been
/// shown, nothing more is reported for clocks up to its last pixel. What was reported for clocks after the run's end
/// does not happen.
std::int64_t Metabuffer::if_certain(std::int64_t cycle) const {
    const int shown = shown_.on_all_displays();
    std::int64_t through = -1;
    if (finished_) {
        through = report_.core_cycles - 1;
    } else if (shown > 0) {
        through = last_pixel_cycle(shown - 1);
    }
    return cycle <= through ? cycle : ComposerRecord::kNever;
}

MachineEvent Metabuffer::certain(MachineEvent event) const {
    event.cycle = if_certain(event.cycle);
    return event;
}

/// The earliest of the composers' events of a kind, given each one's clock.
template <typename CycleOf>
MachineEvent Metabuffer::first_of_composers(const CycleOf& cycle_of) const {
    MachineEvent first;
    for (std::size_t r = 0; r < renderers(); ++r) {
        for (std::size_t d = 0; d < displays(); ++d) {
            first =
                earlier(first, certain({cycle_of(r, d), static_cast<int>(r) + 1, static_cast<int>(d) + 1}));
        }
    }
    return first;
}

MachineEvent Metabuffer::first_busready_drop() const {
    return first_of_composers(
        [this](std::size_t r, std::size_t d) { return composer(r, d).buffer().first_drop_cycle(); });
}

MachineEvent Metabuffer::first_starved() const {
    return first_of_composers([this](std::size_t r, std::size_t d) {
        return std::min(composer(r, d).buffer().first_starved_cycle(),
                        columns_[d]->first_stall_cycle(static_cast<int>(r)));
    });
}

MachineEvent Metabuffer::first_recovered_slot() const {
    MachineEvent first;
    for (std::size_t r = 0; r < renderers(); ++r) {
        MachineEvent of_bus = input_framebuffers_[r]->first_recovered_slot();
        of_bus.renderer = static_cast<int>(r) + 1;
        first = earlier(first, certain(of_bus));
    }
    return first;
}

MachineEvent Metabuffer::startframe(int frame) const {
    MachineEvent first;
    for (std::size_t d = 0; d < displays(); ++d) {
        if (columns_[d]->started(frame))
            first = earlier(first, certain({columns_[d]->start_cycle(frame), 1, static_cast<int>(d) + 1}));
    }
    return first;
}

std::int64_t Metabuffer::frame_end_cycle(int frame) const {
    const bool composited = std::all_of(columns_.begin(), columns_.end(),
                                        [frame](const auto& column) { return column->composited(frame); });
    return composited ? if_certain(last_pixel_cycle(frame)) : ComposerRecord::kNever;
}

std::vector<std::string> Metabuffer::who_waits() const {
    std::vector<std::string> findings;
    const auto add = [&findings](const std::string& name, const std::string& waiting) {
        if (!waiting.empty()) {
            findings.push_back(name + " " + waiting);
        }
    };
    const std::int64_t cycle = core_cycle();
    for (std::size_t r = 0; r < renderers(); ++r) {
        add(numbered("dvi_source", r), dvi_sources_[r]->waiting_for(now_picoseconds()));
        add(numbered("dvi_decoder", r), dvi_decoders_[r]->waiting_for(dvi_in_.edge_at(now_picoseconds())));
        add(numbered("input_framebuffer", r), input_framebuffers_[r]->waiting_for(cycle));
    }
    for (std::size_t r = 0; r < renderers(); ++r) {
        for (std::size_t d = 0; d < displays(); ++d) {
            add(numbered("composer", r, d), composer(r, d).waiting_for(cycle));
        }
    }
    for (std::size_t d = 0; d < displays(); ++d) {
        add(numbered("output_framebuffer", d), output_framebuffers_[d]->waiting_for(cycle));
    }
    return findings;
}

RunReport Metabuffer::make_report() {
    const std::int64_t cycle = core_cycle();
    // Before the composers finish their counters.
    std::vector<std::string> findings = watchdog_tripped_ ? who_waits() : std::vector<std::string>{};
    MachineReport report(scenario_, "tlm", shown_, cycle + 1);
    for (std::size_t r = 0; r < renderers(); ++r) {
        RendererCounters counters = input_framebuffers_[r]->counters(cycle);
        counters.rejected_frames = dvi_decoders_[r]->rejected_frames(dvi_in_.edge_at(now_picoseconds()));
        counters.injected_faults = dvi_sources_[r]->injected_faults();
        report.add_renderer(std::move(counters), input_framebuffers_[r]->frame_sources());
        for (std::size_t d = 0; d < displays(); ++d) {
            report.add_composer(composer(r, d).finish(cycle));
        }
    }
    for (std::size_t d = 0; d < displays(); ++d) {
        DisplayCounters counters;
        counters.stalled_cycles = columns_[d]->stalled_cycles(cycle);
        report.add_display(counters);
        for (int frame = 0; frame < shown_.on_all_displays(); ++frame) {
            const CycleSpan composition = columns_[d]->composition(frame);
            report.add_composition(frame, composition.first, composition.last);
        }
    }
    for (int frame = 0; frame < shown_.on_all_displays(); ++frame) {
        report.add_swap(frame, swap_lock_->swap_to(frame));
    }
    return report.finish(std::move(findings));
}

}  // namespace metabuffer::tlm
