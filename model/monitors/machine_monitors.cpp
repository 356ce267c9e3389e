#include "monitors/machine_monitors.h"

#include <algorithm>
#include <numeric>

#include "monitors/bus_timing.h"
#include "monitors/link_plan.h"
#include "report/counters.h"
#include "rtl/framebuffer_wires.h"
#include "rtl/metabuffer.h"
#include "rtl/wires.h"
#include "scenario/fault_keys.h"

namespace metabuffer::monitors {

const std::vector<std::string>& machine_rules() {
    static const std::vector<std::string> rules{"bus/tableready",
                                                "bus/incomplete",
                                                "bus/table",
                                                "bus/frames",
                                                "bus/frame-number",
                                                "bus/row",
                                                "bus/row-number",
                                                "bus/destination",
                                                "bus/one-burst",
                                                "bus/count",
                                                "bus/remaining",
                                                "bus/order",
                                                "bus/beyond",
                                                "bus/pace",
                                                "bus/busready",
                                                "bus/passed-over",
                                                "arbiter/one-hot",
                                                "arbiter/search",
                                                "arbiter/request",
                                                "arbiter/order",
                                                "arbiter/recovered",
                                                "arbiter/slot",
                                                "memory/device",
                                                "memory/open",
                                                "memory/write",
                                                "memory/activate",
                                                "memory/timing",
                                                "memory/refresh",
                                                "memory/data",
                                                "composer/pixel",
                                                "composer/lost",
                                                "composer/busready",
                                                "composer/tableready",
                                                "composer/stall",
                                                "composer/occupancy",
                                                "composer/table",
                                                "fifo/overwrite",
                                                "fifo/read",
                                                "fifo/release",
                                                "fifo/word",
                                                "fifo/free",
                                                "pipeline/raster",
                                                "pipeline/startframe",
                                                "pipeline/freeze",
                                                "pipeline/skew",
                                                "pipeline/frame",
                                                "pipeline/bubble",
                                                "pipeline/outside",
                                                "pipeready/prefetched",
                                                "pipeready/below",
                                                "pipeready/taken-back",
                                                "pipeready/startframe",
                                                "pipeready/late",
                                                "pipeready/unready",
                                                "pipeready/framebuffer",
                                                "swap-lock/all-done",
                                                "swap-lock/any-bad",
                                                "swap-lock/framedone-fall",
                                                "swap-lock/framedone-rise",
                                                "swap-lock/framebad",
                                                "swap-lock/in-step",
                                                "swap-lock/picture",
                                                "swap-lock/kept",
                                                "dvi/active-lines",
                                                "dvi/active-pixels",
                                                "dvi/line-length",
                                                "dvi/hsync",
                                                "dvi/vsync",
                                                "dvi/vsync-at-line-start",
                                                "tmds/character",
                                                "tmds/control",
                                                "tmds/data",
                                                "tmds/disparity",
                                                "tmds/link",
                                                "scoreboard/pair",
                                                "scoreboard/table",
                                                "scoreboard/bus",
                                                "scoreboard/pixel",
                                                "scoreboard/picture",
                                                "counters/bus",
                                                "counters/composer",
                                                "counters/display"};
    return rules;
}

MachineMonitors::MachineMonitors(const sc_core::sc_module_name& name, const Scenario& scenario,
                                 rtl::Metabuffer& machine, ViolationLog& log)
    : sc_core::sc_module(name),
      scenario_(scenario),
      machine_(machine),
      log_(log),
      renderers_(scenario.renderers.size()),
      displays_(static_cast<std::size_t>(scenario.displays.count())) {
    bind_swap_lock();
    scoreboard_ = std::make_unique<Scoreboard>(
        "scoreboard", scenario, machine.wires(), machine.core_clk(), machine.reset(),
        [&machine](std::size_t renderer, int frame) { return machine.pair_of_frame(renderer, frame); }, log);
    swap_lock_->on_picture([this](const SwapLockMonitor::Shown& shown) { scoreboard_->shown(shown); });
    for (std::size_t r = 0; r < renderers_; ++r) {
        bind_bus(r);
        bind_arbiter(r);
        bind_memory(r);
        bind_link(r);
        if (scenario_.links.tmds()) bind_characters_in(r);
        for (std::size_t d = 0; d < displays_; ++d) {
            bind_composer(r, d);
            bind_fifo(r, d);
        }
    }
    for (std::size_t d = 0; d < displays_; ++d) {
        bind_pipeline(d);
        bind_output(d);
        if (scenario_.links.tmds()) bind_characters_out(d);
    }
}

MachineMonitors::~MachineMonitors() = default;

void MachineMonitors::bind_swap_lock() {
    rtl::Wires& wires = machine_.wires();
    swap_lock_ = std::make_unique<SwapLockMonitor>("swap_lock_monitor", scenario_, log_);
    swap_lock_->clk_i(machine_.core_clk());
    swap_lock_->dvi_clk_i(machine_.dvi_out_clk());
    swap_lock_->reset_i(machine_.reset());
    swap_lock_->swaplock_i(wires.swaplock);
    swap_lock_->swapskip_i(wires.swapskip);
    for (std::size_t d = 0; d < displays_; ++d) {
        swap_lock_->framedone_i[d](wires.framedone[d]);
        swap_lock_->framebad_i[d](wires.framebad[d]);
        swap_lock_->link_i[d](wires.link_out_driven(d));
    }
}

void MachineMonitors::bind_bus(std::size_t r) {
    rtl::Wires& wires = machine_.wires();
    auto monitor = std::make_unique<BusMonitor>(rtl::numbered("bus_monitor", r).c_str(), scenario_,
                                                static_cast<int>(r), log_);
    monitor->clk_i(machine_.core_clk_of_blocks());
    monitor->reset_i(machine_.reset());
    monitor->bus_i(wires.bus_driven(r));
    for (std::size_t d = 0; d < displays_; ++d) {
        monitor->busready_i[d](wires.busready_read(r * displays_ + d));
        monitor->tableready_i[d](wires.tableready_read(r * displays_ + d));
    }
    buses_.push_back(std::move(monitor));
}

void MachineMonitors::bind_arbiter(std::size_t r) {
    arbiters_.emplace_back();
    rtl::FramebufferWires* const wires = machine_.inner_wires(r);
    if (wires == nullptr) {
        return;
    }
    auto monitor = std::make_unique<ArbiterMonitor>(rtl::numbered("arbiter_monitor", r).c_str(), scenario_,
                                                    static_cast<int>(r), log_);
    monitor->clk_i(machine_.core_clk_of_blocks());
    monitor->reset_i(machine_.reset());
    monitor->start_i(wires->start);
    monitor->table_i(wires->table);
    monitor->take_i(wires->take);
    monitor->grant_valid_i(wires->grant_valid);
    monitor->search_i(wires->search);
    monitor->lost_i(wires->lost);
    monitor->recovered_i(wires->recovered);
    monitor->slot_i(wires->slot);
    for (std::size_t d = 0; d < displays_; ++d) {
        monitor->pending_i[d](wires->pending[d]);
        monitor->ready_i[d](wires->ready[d]);
        monitor->grant_i[d](wires->grant[d]);
        if (monitor->deadline_i.size() > 0) monitor->deadline_i[d](wires->deadline[d]);
    }
    arbiters_.back() = std::move(monitor);
}

void MachineMonitors::bind_memory(std::size_t r) {
    memories_.emplace_back();
    rtl::FramebufferWires* const wires = machine_.inner_wires(r);
    if (wires == nullptr) {
        return;
    }
    auto monitor = std::make_unique<MemoryMonitor>(rtl::numbered("memory_monitor", r).c_str(), scenario_,
                                                   static_cast<int>(r), log_);
    monitor->clk_i(machine_.core_clk_of_blocks());
    monitor->reset_i(machine_.reset());
    monitor->write_clk_i(machine_.link_clk_of_blocks(r));
    monitor->write_i(wires->write);
    monitor->front_i(wires->front);
    monitor->command_i(wires->command);
    monitor->data_i(wires->data);
    if (scenario_.memory.shared()) monitor->write_data_i[0](wires->write_data);
    memories_.back() = std::move(monitor);
}

void MachineMonitors::bind_link(std::size_t r) {
    DviMonitor::Link link;
    link.kind = DviMonitor::Kind::kInput;
    link.timing = scenario_.renderers[r].timing();
    link.signal = rtl::numbered("DVI_IN", r);
    link.clock = "dvi_in";
    const auto plan = std::make_shared<LinkPlan>(scenario_, static_cast<int>(r));
    link.restart = [plan] { plan->restart(); };
    link.next_frame = [plan] {
        const LinkPlan::Frame frame = plan->next();
        return DviMonitor::Frame{frame.pair, frame.corrupt};
    };
    auto monitor = std::make_unique<DviMonitor>(rtl::numbered("dvi_in_monitor", r).c_str(), link, log_);
    monitor->clk_i(machine_.link_clk(r));
    monitor->reset_i(machine_.reset());
    monitor->link_i(machine_.wires().link_in_driven(r));
    links_.push_back(std::move(monitor));
}

void MachineMonitors::bind_composer(std::size_t r, std::size_t d) {
    rtl::Wires& wires = machine_.wires();
    auto monitor =
        std::make_unique<ComposerMonitor>(rtl::numbered("composer_monitor", r, d).c_str(), scenario_,
                                          static_cast<int>(r), static_cast<int>(d), log_);
    const std::size_t above = r * displays_ + d;
    const std::size_t below = above + displays_;
    monitor->clk_i(machine_.core_clk_of_blocks());
    monitor->reset_i(machine_.reset());
    monitor->pipemaster_i(wires.pipemaster[r]);
    monitor->bus_i(wires.bus_seen_by(above));
    monitor->busready_o(wires.busready[above]);
    monitor->tableready_o(wires.tableready[above]);
    monitor->startframe_i(wires.startframe[above]);
    monitor->startframe_o(wires.startframe[below]);
    monitor->pipe_i(wires.pipe[above]);
    monitor->pipe_o(wires.pipe[below]);
    monitor->pipeready_i(wires.pipeready[below]);
    monitor->pipeready_o(wires.pipeready[above]);
    monitor->column_stall_i(wires.column_stall[d]);
    monitor->stall_o(wires.stall[above]);
    monitor->on_starved_pixel([this, r, d](const StarvedPixel& pixel) { scoreboard_->starved(r, d, pixel); });
    composers_.push_back(std::move(monitor));
}

void MachineMonitors::bind_pipeline(std::size_t d) {
    rtl::Wires& wires = machine_.wires();
    auto monitor = std::make_unique<PipelineMonitor>(rtl::numbered("pipeline_monitor", d).c_str(), scenario_,
                                                     static_cast<int>(d), log_);
    monitor->clk_i(machine_.core_clk_of_blocks());
    monitor->reset_i(machine_.reset());
    monitor->column_stall_i(wires.column_stall[d]);
    for (std::size_t r = 0; r < renderers_; ++r) {
        const std::size_t below = (r + 1) * displays_ + d;
        monitor->startframe_o[r](wires.startframe[below]);
        monitor->pipe_o[r](wires.pipe[below]);
    }
    monitor->pipeready_i(wires.pipeready[renderers_ * displays_ + d]);
    pipelines_.push_back(std::move(monitor));
}

void MachineMonitors::bind_fifo(std::size_t r, std::size_t d) {
    fifos_.emplace_back();
    rtl::FifoWires* const wires = machine_.fifo_wires(r, d);
    if (wires == nullptr) {
        return;
    }
    auto monitor = std::make_unique<FifoMonitor>(rtl::numbered("fifo_monitor", r, d).c_str(), scenario_,
                                                 rtl::numbered("composer", r, d), log_);
    monitor->clk_i(machine_.core_clk_of_blocks());
    monitor->reset_i(machine_.reset());
    monitor->write_i(wires->write);
    monitor->read_i(wires->read);
    monitor->release_i(wires->release);
    monitor->word_i(wires->word);
    monitor->free_i(wires->free);
    if (wires->second_row != nullptr) {
        monitor->second_row->next_word_i(wires->second_row->next_word);
        monitor->second_row->row_read_i(wires->second_row->read);
        monitor->second_row->row_word_i(wires->second_row->word);
        monitor->second_row->row_next_word_i(wires->second_row->row_next_word);
    }
    fifos_.back() = std::move(monitor);
}

void MachineMonitors::bind_output(std::size_t d) {
    DviMonitor::Link link;
    link.kind = DviMonitor::Kind::kOutput;
    link.timing = scenario_.displays.timing();
    link.signal = rtl::numbered("DVI_OUT", d);
    link.clock = "dvi_out";
    link.next_frame = [this] { return DviMonitor::Frame{swap_lock_->frame(), false}; };
    auto monitor = std::make_unique<DviMonitor>(rtl::numbered("dvi_out_monitor", d).c_str(), link, log_);
    monitor->clk_i(machine_.dvi_out_clk());
    monitor->reset_i(machine_.reset());
    monitor->link_i(machine_.wires().link_out_driven(d));
    links_.push_back(std::move(monitor));
}

void MachineMonitors::bind_characters_in(std::size_t r) {
    rtl::Wires& wires = machine_.wires();
    auto monitor = std::make_unique<TmdsMonitor>(
        rtl::numbered("tmds_in_monitor", r).c_str(),
        TmdsMonitor::Link{rtl::numbered("TMDS_IN", r), rtl::numbered("DVI_IN", r), "dvi_in",
                          disturbs_characters(scenario_, r)},
        log_);
    monitor->clk_i(machine_.link_clk(r));
    monitor->reset_i(machine_.reset());
    monitor->link_i(wires.link_in_driven(r));
    monitor->tmds_i(wires.tmds_in_driven(r));
    monitor->seen_i(wires.link_in[r]);
    characters_.push_back(std::move(monitor));
}

void MachineMonitors::bind_characters_out(std::size_t d) {
    rtl::Wires& wires = machine_.wires();
    auto monitor = std::make_unique<TmdsMonitor>(
        rtl::numbered("tmds_out_monitor", d).c_str(),
        TmdsMonitor::Link{rtl::numbered("TMDS_OUT", d), rtl::numbered("DVI_OUT", d), "dvi_out"}, log_);
    monitor->clk_i(machine_.dvi_out_clk());
    monitor->reset_i(machine_.reset());
    monitor->link_i(wires.link_out_driven(d));
    monitor->tmds_i(wires.tmds_out[d]);
    monitor->seen_i(wires.link_out[d]);
    characters_.push_back(std::move(monitor));
}

// ---- the end of a run ----

void MachineMonitors::finish(const RunReport& report) {
    const std::int64_t cycle = report.core_cycles - 1;
    for (std::size_t r = 0; r < renderers_; ++r) {
        finish_bus(r, report.renderers.at(r), cycle);
        if (arbiters_[r] != nullptr) finish_arbiter(*arbiters_[r], report.renderers.at(r), cycle);
    }
    for (std::size_t i = 0; i < composers_.size(); ++i) finish_composer(i, report.composers.at(i), cycle);
    for (std::size_t d = 0; d < displays_; ++d) {
        finish_display(d, report.displays.at(d), cycle);
        finish_stalls(d, report.displays.at(d), cycle);
    }
}

std::int64_t MachineMonitors::resets() const {
    return std::count_if(scenario_.faults.begin(), scenario_.faults.end(),
                         [](const Fault& fault) { return fault.kind == FaultKind::kReset; });
}

/// The bus may show only a little later what the machine has put into a beat or granted.
void MachineMonitors::finish_bus(std::size_t r, const RendererCounters& counters, std::int64_t cycle) {
    const std::int64_t pixels_to_come = counters.bus.pixels_sent - buses_[r]->pixels_sent();
    const std::int64_t bursts_to_come = counters.bus.bursts - buses_[r]->bursts();
    const BusTiming timing(scenario_);
    const std::int64_t beat = timing.beat_pixels;
    const std::int64_t cycles = timing.beat_cycles;
    const std::int64_t in_flight = 1 + (scenario_.memory.read_latency_cycles + cycles - 1) / cycles;
    const std::int64_t beats_to_come =
        (1 + resets()) * in_flight;  // what is on its way when a reset begins is lost
    if (pixels_to_come >= 0 && pixels_to_come <= beats_to_come * beat && bursts_to_come >= 0 &&
        bursts_to_come <= beats_to_come) {
        return;
    }
    log_.add({"counters/bus", rtl::numbered("BUS", r), "core", cycle, -1,
              "the report has " + std::to_string(counters.bus.pixels_sent) + " pixels in " +
                  std::to_string(counters.bus.bursts) + " bursts, the bus showed " +
                  std::to_string(buses_[r]->pixels_sent()) + " in " + std::to_string(buses_[r]->bursts())});
}

/// The report may count already what the monitor sees only at the next edge, or the reverse.
void MachineMonitors::finish_arbiter(const ArbiterMonitor& arbiter, const RendererCounters& counters,
                                     std::int64_t cycle) {
    const std::int64_t bursts_apart = counters.bus.bursts - arbiter.grants();
    const bool slots_agree = counters.bus.recovered_slots == arbiter.recovered_slots() || bursts_apart != 0;
    const std::int64_t most_apart = 1 + resets();
    if (bursts_apart >= -most_apart && bursts_apart <= most_apart && slots_agree) return;
    log_.add({"counters/bus", counters.name, "core", cycle, -1,
              "the report has " + std::to_string(counters.bus.bursts) + " bursts and " +
                  std::to_string(counters.bus.recovered_slots) +
                  " recovered slots, the arbiter's wires showed " + std::to_string(arbiter.grants()) +
                  " and " + std::to_string(arbiter.recovered_slots())});
}

void MachineMonitors::finish_composer(std::size_t i, const ComposerCounters& counters, std::int64_t cycle) {
    const ComposerCounters& seen = composers_[i]->counters();
    const auto differs = [&](const std::string& what) {
        log_.add({"counters/composer", rtl::numbered("composer", i / displays_, i % displays_), "core", cycle,
                  -1, what});
    };
    const auto compare = [&](const char* counter, std::int64_t reported, std::int64_t derived) {
        if (reported == derived) return;
        differs(std::string("the report has ") + counter + " " + std::to_string(reported) +
                ", the wires showed " + std::to_string(derived));
    };
    for (const Counter<ComposerCounters>& counter : Counters<ComposerCounters>::kTable) {
        compare(counter.name, counters.*counter.member, seen.*counter.member);
    }
    compare("starved_run_count", counters.starved_run_count, seen.starved_run_count);
    if (counters.starved_by_frame != seen.starved_by_frame) {
        differs("the report's starved pixels are not those of the frames in which the wires showed them");
    }
    if (!(counters.starved_runs == seen.starved_runs)) {
        differs("the report's starved_runs are not those that the wires showed");
    }
}

/// A run that the watchdog ends may have swapped to a frame that is not yet shown in full.
void MachineMonitors::finish_display(std::size_t d, const DisplayCounters& counters, std::int64_t cycle) {
    const std::int64_t swaps = swap_lock_->frame() + 1;
    const std::int64_t to_come = swaps - counters.frames_shown;
    if (to_come >= 0 && to_come <= 1 && counters.kept_frames == swap_lock_->kept_frames()) return;
    log_.add({"counters/display", rtl::numbered("DVI_OUT", d), "core", cycle, -1,
              "the report has " + std::to_string(counters.frames_shown) + " frames, " +
                  std::to_string(counters.kept_frames) + " of them replaced, the wires showed " +
                  std::to_string(swaps) + " swaps, " + std::to_string(swap_lock_->kept_frames()) +
                  " skipped"});
}

void MachineMonitors::finish_stalls(std::size_t d, const DisplayCounters& counters, std::int64_t cycle) {
    const std::int64_t seen = pipelines_[d]->stalled_cycles();
    if (counters.stalled_cycles == seen) return;
    log_.add({"counters/display", rtl::numbered("COLUMNSTALL", d), "core", cycle, -1,
              "the report has stalled_cycles " + std::to_string(counters.stalled_cycles) +
                  ", the wire was high in " + std::to_string(seen)});
}

std::int64_t MachineMonitors::unreported() const {
    const auto sum = [](const auto& monitors) {
        return std::accumulate(monitors.begin(), monitors.end(), std::int64_t{0},
                               [](std::int64_t total, const auto& monitor) {
                                   return total + (monitor != nullptr ? monitor->unreported() : 0);
                               });
    };
    return sum(buses_) + sum(arbiters_) + sum(memories_) + sum(composers_) + sum(fifos_) + sum(pipelines_) +
           sum(characters_);
}

}  // namespace metabuffer::monitors
