#include "rtl/run.h"

#include <sysc/tracing/sc_tracing_ids.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "host/errors.h"
#include "rtl/block.h"
#include "rtl/metabuffer.h"
#include "rtl/waveform_file.h"
#include "simulation/simulation_run.h"

namespace metabuffer::rtl {
namespace {

/// Core clocks between two checks of the machine from outside.
constexpr std::int64_t kChunkCycles = 20'000;

sc_core::sc_time cycles_to_time(const Scenario& scenario, std::int64_t cycles) {
    return picoseconds(cycles * clock_period_picoseconds(scenario.clocks.core_mhz));
}

/// The number of the core clock, for a waveform: the one by which reports, messages and --trace-window count.
class CycleCounter final : public sc_core::sc_module {
  public:
    CycleCounter(const sc_core::sc_module_name& name, const Scenario& scenario, sc_core::sc_clock& clock)
        : sc_core::sc_module(name),
          core_period_picoseconds_(clock_period_picoseconds(scenario.clocks.core_mhz)) {
        SC_METHOD(clock_edge);
        sensitive << clock.posedge_event();
        dont_initialize();
    }
    SC_HAS_PROCESS(CycleCounter);

    const std::uint64_t& cycle() const { return cycle_; }

  private:
    void clock_edge() { cycle_ = static_cast<std::uint64_t>(clock_edge_number(core_period_picoseconds_)); }

    std::int64_t core_period_picoseconds_;
    std::uint64_t cycle_ = 0;
};

/// The waveform of a run: open between its first and last cycle.
class Waveform {
  public:
    Waveform(WaveformFile& file, const TraceRequest& request, const Metabuffer& machine,
             const CycleCounter& counter)
        : file_(file) {
        sc_core::sc_report_handler::set_actions(sc_core::SC_ID_TRACING_TIMESCALE_UNIT_,
                                                sc_core::SC_DO_NOTHING);
        trace_ = sc_core::sc_create_vcd_trace_file(file.stem().c_str());
        trace_->set_time_unit(1.0, sc_core::SC_PS);
        sc_core::sc_trace(trace_, counter.cycle(), std::string(machine.name()) + ".core_cycle");
        machine.trace_blocks(trace_, request.blocks);
    }
    Waveform(const Waveform&) = delete;
    Waveform& operator=(const Waveform&) = delete;
    /// SystemC cannot close a file that it has not opened: if the first clock failed, the file is left as it is.
    ~Waveform() {
        if (trace_ != nullptr && is_open_) sc_core::sc_close_vcd_trace_file(trace_);
    }

    /// Call it after the first clock, which opens the file.
    void note_opened() {
        is_open_ = true;
        file_.note_opened();
    }
    bool is_open() const { return is_open_; }

    /// Throws OutputError.
    void finish() {
        sc_core::sc_close_vcd_trace_file(std::exchange(trace_, nullptr));
        file_.put_in_place();
    }

  private:
    WaveformFile& file_;
    sc_core::sc_trace_file* trace_ = nullptr;
    bool is_open_ = false;
};

/// Says where the window's event was, if the search has found it elsewhere; else empty.
std::string misplaced(const TraceWindow& window, const std::optional<CycleSpan>& found,
                      const Metabuffer& machine) {
    if (window.fixed_cycles()) return {};
    const std::optional<WindowEvent> event = event_of(window, machine);
    if (!event) return found ? "what the waveform should show does not happen at level rtl" : "";
    const CycleSpan right = window.around(event->cycles());
    if (found && found->first == right.first && found->last == right.last) return {};
    return "what the waveform should show is elsewhere at level rtl; use --trace-window cycles:" +
           std::to_string(right.first) + "-" + std::to_string(right.last);
}

/// Closes the waveform once, at its end.
void finish(std::unique_ptr<Waveform>& waveform) {
    if (waveform != nullptr) waveform->finish();
    waveform.reset();
}

}  // namespace

void check_trace_name(const std::filesystem::path& file) {
    if (!is_waveform_name(file)) {
        throw InputError("--trace " + file.string() + ": a waveform file must end in .vcd or .fst");
    }
}

/// The machine runs to the end of the chunk after an event, so of several events the earliest is found.
WindowSearch find_event(const Scenario& scenario, const TraceWindow& window) {
    return scout([&scenario, &window] {
        Metabuffer machine("metabuffer", scenario);
        WindowSearch search;
        machine.on_finished([] { sc_core::sc_pause(); });
        while (!(search.event = event_of(window, machine)) && !machine.finished()) {
            advance_kernel(scenario, cycles_to_time(scenario, kChunkCycles));
        }
        search.whole_run = machine.finished() && machine.watchdog_findings().empty();
        return search;
    });
}

RunResult run(const Scenario& scenario, const RunOptions& options) {
    RunResult result;
    std::optional<CycleSpan> window;
    std::optional<WaveformFile> waveform_file;
    if (options.trace) {
        check_trace_name(options.trace->file);
        waveform_file.emplace(options.trace->file, options.trace->header);
        const TraceWindow& wanted = options.trace->window;
        window = wanted.fixed_cycles();
        if (options.trace->event) window = wanted.around(options.trace->event->cycles());
        if (window) {
            waveform_file->start(window->first * clock_period_picoseconds(scenario.clocks.core_mhz));
        }
    }

    SimulationRun simulation(scenario, options.on_frame_shown);
    Metabuffer machine("metabuffer", scenario);
    std::unique_ptr<CycleCounter> counter;
    if (options.trace)
        counter = std::make_unique<CycleCounter>("cycle_counter", scenario, machine.core_clk());
    if (options.trace && machine.matching_blocks(options.trace->blocks) == 0) {
        throw InputError(
            "--trace-modules: no block matches; blocks are named like input_framebuffer_1, composer_1_2 or "
            "output_framebuffer_1");
    }
    machine.on_frame_shown(
        [&simulation](const DisplayedFrame& displayed) { simulation.frame_shown(displayed); });
    if (options.on_built) options.on_built(machine);
    machine.on_finished([&] {
        result.report = machine.report();
        sc_core::sc_pause();
    });
    std::unique_ptr<Waveform> waveform;
    std::int64_t cycle = 0;  // the next to run
    while (!machine.finished()) {
        std::int64_t next = cycle + kChunkCycles;
        if (window && cycle > window->last) {
            finish(waveform);
        } else if (window && cycle >= window->first) {
            if (!waveform) {
                waveform = std::make_unique<Waveform>(*waveform_file, *options.trace, machine, *counter);
                result.traced = CycleSpan{cycle, cycle};
                next = cycle + 1;  // this clock opens the file
            }
            if (window->last < next) {
                next = window->last + 1;
            }
        } else if (window) {
            next = std::min(next, window->first);
        }
        try {
            simulation.advance(cycles_to_time(scenario, next - cycle));
        } catch (const sc_core::sc_report& error) {
            if (waveform == nullptr || waveform->is_open() ||
                std::string(error.get_msg_type()) != sc_core::SC_ID_TRACING_FOPEN_FAILED_)
                throw;
            fail_to_write(options.trace->file, "the pipe to its process cannot be opened");
        }
        if (waveform) {
            waveform->note_opened();
            result.traced->last = machine.finished() ? machine.core_cycle() : next - 1;
        }
        cycle = next;
        if (options.on_progress) {
            options.on_progress(machine.core_cycle(),
                                static_cast<double>(machine.raster_pixels_taken()) /
                                    static_cast<double>(machine.raster_pixels_to_take()));
        }
    }
    finish(waveform);
    if (options.trace) result.trace_warning = misplaced(options.trace->window, window, machine);
    if (options.trace && !result.traced) {
        if (window) {
            result.trace_note = "the window begins at core clock " + std::to_string(window->first) +
                                ", and the run ends at " + std::to_string(machine.core_cycle());
        } else if (result.trace_warning.empty()) {
            result.trace_note = "what the waveform should show does not happen in this run";
        } else {
            result.trace_note = std::exchange(result.trace_warning, "");
        }
    }
    result.simulation_seconds = simulation.seconds();
    return result;
}

}  // namespace metabuffer::rtl
