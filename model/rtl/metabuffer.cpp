#include "rtl/metabuffer.h"

#include <fnmatch.h>

#include <algorithm>
#include <utility>

#include "rtl/machine_faults.h"
#include "rtl/wires.h"
#include "scenario/derived_timing.h"

namespace metabuffer::rtl {
namespace {

constexpr int kResetCycles = 2;

}  // namespace

Metabuffer::Metabuffer(const sc_core::sc_module_name& name, const Scenario& scenario, ClockGating gating)
    : Block(name),
      scenario_(scenario),
      gating_(gating),
      core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)),
      dvi_in_period_picoseconds_(clock_period_picoseconds(scenario.clocks.dvi_in_mhz)),
      dvi_out_period_picoseconds_(clock_period_picoseconds(scenario.clocks.dvi_out_mhz)),
      wires_(std::make_unique<Wires>(renderers(), displays(), scenario.bus.register_stages > 0,
                                     scenario.links.layer)),
      faults_(std::make_unique<MachineFaults>(scenario, *wires_)),
      shown_(displays()) {
    make_clocks();
    make_renderer_side();
    make_bus_registers();
    make_composers();
    make_display_side();
    blocks_.insert(blocks_.end(), faults_->blocks().begin(), faults_->blocks().end());
    watchdog_ = std::make_unique<Watchdog>(
        "watchdog", picoseconds(watchdog_interval_picoseconds(scenario)), [this] { return progress(); },
        [this] { watchdog_timeout(); });
    SC_METHOD(drive_reset);
    SC_METHOD(settle);
    sensitive << settle_event_;
    dont_initialize();
    SC_METHOD(finish);
    sensitive << finish_event_;
    dont_initialize();
}

Metabuffer::~Metabuffer() = default;

Metabuffer::Clock::Clock(const char* name, std::int64_t period_picoseconds, ClockGating gating)
    : clk(name, picoseconds(period_picoseconds)) {
    if (gating == ClockGating::kOn) {
        gated = std::make_unique<GatedClock>((std::string("gated_") + name).c_str());
        gated->clk_i(clk);
    }
}

const sc_core::sc_signal_in_if<bool>& Metabuffer::Clock::of_blocks() const {
    if (gated != nullptr) return *gated;
    return clk;
}

void Metabuffer::make_clocks() {
    core_clk_ = std::make_unique<Clock>("core_clk", core_period_picoseconds_, gating_);
    dvi_in_clk_ = core_clk_.get();
    if (dvi_in_period_picoseconds_ != core_period_picoseconds_) {
        own_dvi_in_clk_ = std::make_unique<Clock>("dvi_in_clk", dvi_in_period_picoseconds_, gating_);
        dvi_in_clk_ = own_dvi_in_clk_.get();
    }
    dvi_out_clk_ = core_clk_.get();
    if (dvi_out_period_picoseconds_ == dvi_in_period_picoseconds_) {
        dvi_out_clk_ = dvi_in_clk_;
    } else if (dvi_out_period_picoseconds_ != core_period_picoseconds_) {
        own_dvi_out_clk_ = std::make_unique<Clock>("dvi_out_clk", dvi_out_period_picoseconds_, gating_);
        dvi_out_clk_ = own_dvi_out_clk_.get();
    }
}

void Metabuffer::make_renderer_side() {
    for (std::size_t r = 0; r < renderers(); ++r) {
        sc_core::sc_signal<bool>* const drifting_clk = faults_->drifting_clock(r, dvi_in_period_picoseconds_);
        sc_core::sc_signal<bool>& link_clk = drifting_clk != nullptr ? *drifting_clk : dvi_in_clk_->clk;
        link_clks_.push_back(&link_clk);
        const sc_core::sc_signal_in_if<bool>& blocks_link_clk = link_clk_of_blocks(r);
        auto source =
            std::make_unique<DviSource>(numbered("dvi_source", r).c_str(), scenario_, static_cast<int>(r));
        source->clk_i(blocks_link_clk);
        source->reset_i(reset_);
        source->pair_request_i(wires_->pair_request[r]);
        source->link_o(wires_->link_in_driven(r));
        source->clock_ppm_o(wires_->clock_ppm[r]);
        source->disturbance_o(wires_->disturbance[r]);
        blocks_.push_back(source.get());
        if (scenario_.links.tmds()) {
            make_coding({numbered("tmds_encoder_in", r), numbered("tmds_decoder_in", r), blocks_link_clk,
                         wires_->link_in_driven(r), faults_->encoded(r, link_clk, reset_), wires_->tmds_in[r],
                         wires_->link_in[r]});
        }

        auto decoder =
            std::make_unique<DviDecoder>(numbered("dvi_decoder", r).c_str(), scenario_.renderers[r].timing());
        decoder->clk_i(blocks_link_clk);
        decoder->reset_i(reset_);
        decoder->link_i(wires_->link_in[r]);
        decoder->pixel_o(wires_->pixel[r]);
        decoder->event_o(wires_->event[r]);
        blocks_.push_back(decoder.get());

        auto framebuffer = std::make_unique<InputFramebuffer>(numbered("input_framebuffer", r).c_str(),
                                                              scenario_, static_cast<int>(r));
        framebuffer->clk_i(core_clk_->of_blocks());
        framebuffer->dvi_clk_i(blocks_link_clk);
        framebuffer->reset_i(reset_);
        framebuffer->pixel_i(wires_->pixel[r]);
        framebuffer->event_i(wires_->event[r]);
        framebuffer->pair_request_o(
            faults_->raised(Handshake::kPairRequest, r, 0, wires_->pair_request[r], link_clk));
        framebuffer->bus_o(wires_->bus_driven(r));
        for (std::size_t d = 0; d < displays(); ++d) {
            framebuffer->busready_i[d](wires_->busready_read(r * displays() + d));
            framebuffer->tableready_i[d](wires_->tableready_read(r * displays() + d));
        }
        blocks_.push_back(framebuffer.get());

        dvi_sources_.push_back(std::move(source));
        dvi_decoders_.push_back(std::move(decoder));
        input_framebuffers_.push_back(std::move(framebuffer));
        wires_->pipemaster[r].write(r == 0);
    }
}

void Metabuffer::make_coding(const CodedLink& link) {
    auto encoder = std::make_unique<TmdsEncoder>(link.encoder.c_str());
    encoder->clk_i(link.clk);
    encoder->reset_i(reset_);
    encoder->link_i(link.driven);
    encoder->tmds_o(link.encoded);
    blocks_.push_back(encoder.get());

    auto decoder = std::make_unique<TmdsDecoder>(link.decoder.c_str());
    decoder->clk_i(link.clk);
    decoder->reset_i(reset_);
    decoder->tmds_i(link.received);
    decoder->link_o(link.seen);
    blocks_.push_back(decoder.get());

    tmds_encoders_.push_back(std::move(encoder));
    tmds_decoders_.push_back(std::move(decoder));
}

void Metabuffer::make_bus_registers() {
    const int stages = scenario_.bus.register_stages;
    for (std::size_t r = 0; stages > 0 && r < renderers(); ++r) {
        auto registers =
            std::make_unique<BusRegisters>(numbered("bus_registers", r).c_str(), stages, displays(),
                                           BusBeat::lanes(pixels_per_beat(scenario_.bus, scenario_.memory)));
        registers->clk_i(core_clk_->of_blocks());
        registers->reset_i(reset_);
        registers->bus_i(wires_->bus_driven(r));
        registers->bus_o(wires_->bus[r]);
        for (std::size_t d = 0; d < displays(); ++d) {
            const std::size_t i = r * displays() + d;
            registers->busready_i[d](wires_->busready[i]);
            registers->busready_o[d](wires_->busready_read(i));
            registers->tableready_i[d](wires_->tableready[i]);
            registers->tableready_o[d](wires_->tableready_read(i));
        }
        blocks_.push_back(registers.get());
        bus_registers_.push_back(std::move(registers));
    }
}

void Metabuffer::make_composers() {
    for (std::size_t r = 0; r < renderers(); ++r) {
        for (std::size_t d = 0; d < displays(); ++d) {
            auto composer = std::make_unique<Composer>(numbered("composer", r, d).c_str(), scenario_,
                                                       static_cast<int>(d) + 1);
            const std::size_t above = r * displays() + d;
            const std::size_t below = above + displays();
            composer->clk_i(core_clk_->of_blocks());
            composer->reset_i(reset_);
            composer->pipemaster_i(wires_->pipemaster[r]);
            composer->bus_i(faults_->bus_for(r, d));
            composer->busready_o(
                faults_->raised(Handshake::kBusready, r, d, wires_->busready[above], core_clk_->clk));
            composer->tableready_o(
                faults_->raised(Handshake::kTableready, r, d, wires_->tableready[above], core_clk_->clk));
            composer->startframe_i(wires_->startframe[above]);
            composer->startframe_o(wires_->startframe[below]);
            composer->pipe_i(wires_->pipe[above]);
            composer->pipe_o(wires_->pipe[below]);
            composer->pipeready_i(wires_->pipeready[below]);
            composer->pipeready_o(
                faults_->raised(Handshake::kPipeready, r, d, wires_->pipeready[above], core_clk_->clk));
            composer->column_stall_i(wires_->column_stall[d]);
            composer->stall_o(faults_->raised(Handshake::kStall, r, d, wires_->stall[above], core_clk_->clk));
            blocks_.push_back(composer.get());
            composers_.push_back(std::move(composer));
        }
    }
}

void Metabuffer::make_display_side() {
    swap_lock_ = std::make_unique<SwapLock>("swap_lock", static_cast<int>(displays()));
    const MachineFaults::SwapWires swap = faults_->raised_swap(core_clk_->clk);
    swap_lock_->swaplock_o(swap.swaplock);
    swap_lock_->swapskip_o(swap.swapskip);
    blocks_.push_back(swap_lock_.get());
    const std::size_t bottom = renderers() * displays();
    for (std::size_t d = 0; d < displays(); ++d) {
        auto stall =
            std::make_unique<ColumnStall>(numbered("column_stall", d).c_str(), static_cast<int>(renderers()));
        for (std::size_t r = 0; r < renderers(); ++r) {
            stall->stall_i[r](wires_->stall[r * displays() + d]);
        }
        stall->column_stall_o(wires_->column_stall[d]);
        blocks_.push_back(stall.get());

        auto framebuffer = std::make_unique<OutputFramebuffer>(numbered("output_framebuffer", d).c_str(),
                                                               scenario_, static_cast<int>(d) + 1);
        framebuffer->clk_i(core_clk_->of_blocks());
        framebuffer->reset_i(reset_);
        framebuffer->dvi_clk_i(dvi_out_clk_->of_blocks());
        framebuffer->startframe_i(wires_->startframe[bottom + d]);
        framebuffer->pipe_i(wires_->pipe[bottom + d]);
        framebuffer->column_stall_i(wires_->column_stall[d]);
        framebuffer->pipeready_o(faults_->raised(Handshake::kPipeready, renderers(), d,
                                                 wires_->pipeready[bottom + d], core_clk_->clk));
        framebuffer->framedone_o(
            faults_->raised(Handshake::kFramedone, renderers() - 1, d, wires_->framedone[d], core_clk_->clk));
        framebuffer->framebad_o(wires_->framebad[d]);
        framebuffer->swaplock_i(wires_->swaplock);
        framebuffer->swapskip_i(wires_->swapskip);
        framebuffer->link_o(wires_->link_out_driven(d));
        swap_lock_->framedone_i[d](wires_->framedone[d]);
        swap_lock_->framebad_i[d](wires_->framebad[d]);
        blocks_.push_back(framebuffer.get());
        if (scenario_.links.tmds()) {
            make_coding({numbered("tmds_encoder_out", d), numbered("tmds_decoder_out", d),
                         dvi_out_clk_->of_blocks(), wires_->link_out_driven(d), wires_->tmds_out[d],
                         wires_->tmds_out[d], wires_->link_out[d]});
        }

        auto display = std::make_unique<DviDisplay>(numbered("dvi_display", d).c_str());
        display->clk_i(dvi_out_clk_->of_blocks());
        display->reset_i(reset_);
        display->link_i(wires_->link_out[d]);
        display->on_frame([this, d](const ColourImage& image) { frame_captured(d, image); });
        blocks_.push_back(display.get());

        column_stalls_.push_back(std::move(stall));
        output_framebuffers_.push_back(std::move(framebuffer));
        dvi_displays_.push_back(std::move(display));
    }
}

/// Reset changes half a clock before the edge that sees it.
void Metabuffer::drive_reset() {
    const std::int64_t cycle = sc_core::sc_time_stamp() == sc_core::SC_ZERO_TIME ? 0 : next_reset_cycle_;
    const bool in_reset = cycle < kResetCycles || faults_->reset_at(cycle);
    if (!in_reset && reset_.read()) {
        forget_frames();
    }
    reset_.write(in_reset);
    next_reset_cycle_ = faults_->next_reset_change(cycle);
    if (cycle < kResetCycles) {
        next_reset_cycle_ = std::min<std::int64_t>(next_reset_cycle_, kResetCycles);
    }
    if (next_reset_cycle_ != MachineFaults::kNoChange) {
        const std::int64_t at = next_reset_cycle_ * core_period_picoseconds_ - core_period_picoseconds_ / 2;
        next_trigger(picoseconds(at) - sc_core::sc_time_stamp());
    }
}

/// After a reset frames are numbered from 0 again. Counters keep their values.
void Metabuffer::forget_frames() {
    shown_ = ShownFrames(displays());
    for (const auto& composer : composers_) {
        composer->forget_frames();
    }
    for (const auto& framebuffer : input_framebuffers_) {
        framebuffer->forget_frames();
    }
}

void Metabuffer::on_starved_pixel(const std::function<void(int, int, const StarvedPixel&)>& callback) {
    for (std::size_t i = 0; i < composers_.size(); ++i) {
        const int renderer = static_cast<int>(i / displays()) + 1;
        const int display = static_cast<int>(i % displays()) + 1;
        composers_[i]->on_starved_pixel(
            [=](const StarvedPixel& pixel) { callback(renderer, display, pixel); });
    }
}

void Metabuffer::frame_captured(std::size_t display, const ColourImage& image) {
    const int frame = output_framebuffers_[display]->front_frame();
    if (frame == shown_.last(display)) {
        return;  // nothing new was on the screen
    }
    const bool on_all_displays = shown_.add(display, frame);
    if (on_frame_shown_) {
        const auto f = static_cast<std::size_t>(frame);
        std::vector<int> pairs;
        std::int64_t starved_pixels = 0;
        for (std::size_t r = 0; r < renderers(); ++r) {
            pairs.push_back(input_framebuffers_[r]->frame_sources()[f].pair);
            starved_pixels += composer(r, display).counters().starved_pixels_of(frame);
        }
        on_frame_shown_({frame, static_cast<int>(display) + 1, image, pairs, starved_pixels,
                         output_framebuffers_[display]->swaps()[f].kept});
    }
    if (on_all_displays && shown_.on_all_displays() == scenario_.frames) {
        // In a later delta cycle, when every block has done the clock that is being executed.
        finish_event_.notify(sc_core::SC_ZERO_TIME);
    }
}

void Metabuffer::finish() {
    if (finished_) {
        return;
    }
    finished_ = true;
    if (watchdog_tripped_) {
        find_who_waits();
    }
    if (on_finished_) {
        on_finished_();
    }
}

// ---- the watchdog ----

std::int64_t Metabuffer::progress() const {
    std::int64_t count = raster_pixels_taken();
    for (const auto& framebuffer : input_framebuffers_) {
        const BusCounters& bus = framebuffer->counters().bus;
        count += bus.pixels_sent + bus.table_cycles;
        if (scenario_.pacing == Pacing::kLockstep) {
            count += framebuffer->link_pixels();  // a free-running link never stops
        }
    }
    for (const auto& framebuffer : output_framebuffers_) {
        count += framebuffer->front_frame();
    }
    return count;
}

/// The watchdog checks before the clock edges of the same time, if there are any; the run ends after them.
void Metabuffer::watchdog_timeout() {
    if (!finished_) {
        watchdog_tripped_ = true;
        settle_event_.notify(sc_core::SC_ZERO_TIME);
    }
}

void Metabuffer::settle() { finish_event_.notify(sc_core::SC_ZERO_TIME); }

void Metabuffer::find_who_waits() {
    const std::string own_prefix = std::string(name()) + ".";
    for (const Block* block : blocks_) {
        const std::string waiting = block->waiting_for();
        if (!waiting.empty()) {
            watchdog_findings_.push_back(std::string(block->name()).substr(own_prefix.size()) + " " +
                                         waiting);
        }
    }
}

// ---- what a run reports ----

std::int64_t Metabuffer::raster_pixels_taken() const {
    std::int64_t count = 0;
    for (const auto& framebuffer : output_framebuffers_) {
        count += framebuffer->pixels_taken();
    }
    return count;
}

RunReport Metabuffer::report() const {
    MachineReport report(scenario_, "rtl", shown_, core_cycle() + 1);
    for (std::size_t r = 0; r < renderers(); ++r) {
        RendererCounters counters = input_framebuffers_[r]->counters();
        counters.rejected_frames = dvi_decoders_[r]->rejected_frames();
        counters.injected_faults = dvi_sources_[r]->injected_faults() + faults_->injected_faults(r);
        report.add_renderer(std::move(counters), input_framebuffers_[r]->frame_sources());
        for (std::size_t d = 0; d < displays(); ++d) {
            report.add_composer(composer(r, d).counters());
        }
    }
    for (std::size_t d = 0; d < displays(); ++d) {
        DisplayCounters counters;
        counters.stalled_cycles = output_framebuffers_[d]->stalled_cycles();
        counters.kept_frames = output_framebuffers_[d]->kept_frames();
        report.add_display(counters);
        for (int frame = 0; frame < shown_.on_all_displays(); ++frame) {
            const auto f = static_cast<std::size_t>(frame);
            report.add_composition(frame, composer(0, d).frame_spans()[f].start_cycle,
                                   composer(renderers() - 1, d).frame_spans()[f].end_cycle);
        }
    }
    // All displays swap together.
    for (int frame = 0; frame < shown_.on_all_displays(); ++frame) {
        report.add_swap(frame, output_framebuffers_.front()->swaps()[static_cast<std::size_t>(frame)]);
    }
    return report.finish(watchdog_findings_);
}

/// The earliest of the composers' events of a kind, given each one's clock.
template <typename CycleOf>
MachineEvent Metabuffer::first_of_composers(const CycleOf& cycle_of) const {
    MachineEvent first;
    for (std::size_t r = 0; r < renderers(); ++r) {
        for (std::size_t d = 0; d < displays(); ++d) {
            first =
                earlier(first, {cycle_of(composer(r, d)), static_cast<int>(r) + 1, static_cast<int>(d) + 1});
        }
    }
    return first;
}

MachineEvent Metabuffer::first_busready_drop() const {
    return first_of_composers([](const Composer& composer) { return composer.first_busready_drop_cycle(); });
}

MachineEvent Metabuffer::first_starved() const {
    return first_of_composers([](const Composer& composer) { return composer.first_starved_cycle(); });
}

MachineEvent Metabuffer::first_recovered_slot() const {
    MachineEvent first;
    for (std::size_t r = 0; r < renderers(); ++r) {
        MachineEvent of_bus = input_framebuffers_[r]->first_recovered_slot();
        of_bus.renderer = static_cast<int>(r) + 1;
        first = earlier(first, of_bus);
    }
    return first;
}

MachineEvent Metabuffer::startframe(int frame) const {
    MachineEvent first;
    for (std::size_t d = 0; d < displays(); ++d) {
        const auto& spans = composer(0, d).frame_spans();
        if (spans.size() > static_cast<std::size_t>(frame)) {
            const std::int64_t cycle = spans[static_cast<std::size_t>(frame)].startframe_cycle;
            first = earlier(first, {cycle, 1, static_cast<int>(d) + 1});
        }
    }
    return first;
}

std::int64_t Metabuffer::frame_end_cycle(int frame) const {
    std::int64_t cycle = Composer::kNever;
    for (std::size_t d = 0; d < displays(); ++d) {
        const auto& spans = composer(renderers() - 1, d).frame_spans();
        if (spans.size() <= static_cast<std::size_t>(frame) ||
            spans[static_cast<std::size_t>(frame)].end_cycle == Composer::kNever) {
            return Composer::kNever;
        }
        cycle = std::max(cycle, spans[static_cast<std::size_t>(frame)].end_cycle);
    }
    return cycle;
}

bool Metabuffer::matches(const Block& block, const std::vector<std::string>& patterns) const {
    const std::string child = std::string(block.name()).substr(std::string(name()).size() + 1);
    return patterns.empty() || std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
               return fnmatch(pattern.c_str(), child.c_str(), 0) == 0;
           });
}

int Metabuffer::matching_blocks(const std::vector<std::string>& patterns) const {
    return static_cast<int>(std::count_if(blocks_.begin(), blocks_.end(),
                                          [&](const Block* block) { return matches(*block, patterns); }));
}

void Metabuffer::trace_blocks(sc_core::sc_trace_file* file, const std::vector<std::string>& patterns) const {
    for (Clock* const clock : {core_clk_.get(), dvi_in_clk_, dvi_out_clk_}) clock->clk.show_falls();
    sc_core::sc_trace(file, core_clk_->clk, path("core_clk"));
    sc_core::sc_trace(file, dvi_in_clk_->clk, path("dvi_in_clk"));
    sc_core::sc_trace(file, dvi_out_clk_->clk, path("dvi_out_clk"));
    sc_core::sc_trace(file, reset_, path("reset"));
    for (const Block* block : blocks_) {
        if (matches(*block, patterns)) {
            block->trace(file);
        }
    }
}

void Metabuffer::trace(sc_core::sc_trace_file* file) const { trace_blocks(file, {}); }

void Metabuffer::stop_clocks() {
    for (Clock* const clock : {core_clk_.get(), dvi_in_clk_, dvi_out_clk_}) clock->clk.stop();
    faults_->stop_clocks();
}

}  // namespace metabuffer::rtl
