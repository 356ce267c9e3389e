#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <systemc>
#include <utility>
#include <vector>

#include "formats/image.h"
#include "report/machine_event.h"
#include "report/machine_report.h"
#include "scenario/scenario.h"
#include "simulation/frame_shown.h"
#include "tlm/agenda.h"
#include "tlm/bus.h"
#include "tlm/column_time.h"
#include "tlm/composer.h"
#include "tlm/content_cache.h"
#include "tlm/cycle.h"
#include "tlm/dvi_decoder.h"
#include "tlm/dvi_display.h"
#include "tlm/dvi_source.h"
#include "tlm/frame_memory.h"
#include "tlm/input_framebuffer.h"
#include "tlm/output_framebuffer.h"
#include "tlm/relay.h"
#include "tlm/schedule_observer.h"
#include "tlm/swap_lock.h"

namespace metabuffer::tlm {

/// The whole machine of the paper's Figure 1 as TLM-2.0 modules, from the renderers' graphics cards to the displays,
/// with the names of level rtl. Reports and pictures are those of level rtl, clock for clock.
///
/// Throws InputError if the scenario has a fault that happens clock by clock, which only level rtl has. Otherwise only
/// the blocks' own errors are raised; see their headers.
class Metabuffer final : public sc_core::sc_module {
  public:
    /// What replaces FrameMemory for a renderer (index, from 0): any module with a target socket that answers
    /// MemoryAccess. It must answer at once, without wait(), since SystemC methods call it.
    struct Memory {
        std::unique_ptr<sc_core::sc_module> module;
        AnyTargetSocket<MemoryAccess>* socket = nullptr;
    };
    struct Options {
        bool images = true;                    ///< false: no pixel is touched, on_frame_shown is not called
        ScheduleObserver* observer = nullptr;  ///< not owned
        /// Makes the memories; FrameMemory if it is not set.
        std::function<Memory(const char* name, const Scenario& scenario, int renderer)> make_memory;
    };
    /// The scenario must have passed check_scenario and must outlive the machine.
    Metabuffer(const sc_core::sc_module_name& name, const Scenario& scenario, Options options);
    ~Metabuffer() override;
    SC_HAS_PROCESS(Metabuffer);

    void on_frame_shown(FrameShown callback) { on_frame_shown_ = std::move(callback); }
    /// Called once, when the scenario's last frame has been shown on every display or the watchdog has found that
    /// nothing moves. If several machines are in one elaboration, what a machine does after its end means nothing.
    void on_finished(std::function<void()> callback) { on_finished_ = std::move(callback); }
    bool finished() const { return finished_; }

    /// The run from its start to its end; call it from on_finished or later.
    const RunReport& report() const { return report_; }

    /// The events at which a trace window can start, the same as at level rtl. An event has not happened until it is
    /// certain: until a frame that ends at its clock or later has been shown, or the run has finished.
    MachineEvent first_busready_drop() const;
    MachineEvent first_starved() const;
    MachineEvent first_recovered_slot() const;
    MachineEvent startframe(int frame) const;
    /// Core cycle of a frame's last pixel in the column that ends it last; ComposerRecord::kNever until it is certain.
    std::int64_t frame_end_cycle(int frame) const;

    std::int64_t core_cycle() const { return core_.edge_at(now_picoseconds()); }
    /// Raster pixels that have left the pipelines, of raster_pixels_to_take() in the whole run: for a progress
    /// display.
    std::int64_t raster_pixels_taken() const { return raster_pixels_taken(core_cycle()); }
    std::int64_t raster_pixels_to_take() const { return raster_pixels_of_run(scenario_); }

  private:
    std::size_t displays() const { return static_cast<std::size_t>(scenario_.displays.count()); }
    std::size_t renderers() const { return scenario_.renderers.size(); }
    Composer& composer(std::size_t renderer, std::size_t display) const {
        return *composers_[renderer * displays() + display];
    }

    std::int64_t certain_end() const;
    void make_display_side();
    void make_renderer_side();
    void make_composers();
    Memory make_memory(const char* name, int renderer) const;
    std::int64_t last_pixel_cycle(int frame) const;
    std::int64_t if_certain(std::int64_t cycle) const;
    MachineEvent certain(MachineEvent event) const;
    template <typename CycleOf>
    MachineEvent first_of_composers(const CycleOf& cycle_of) const;
    std::int64_t raster_pixels_taken(std::int64_t through_cycle) const;
    void look();
    std::int64_t progress(std::int64_t picoseconds) const;
    void settle();
    void finish();
    void frame_shown(std::size_t display, int frame, const ColourImage* image);
    std::vector<std::string> who_waits() const;
    RunReport make_report();

    const Scenario& scenario_;
    Options options_;
    ClockDomain core_;
    ClockDomain dvi_in_;
    std::int64_t reset_picoseconds_;  ///< every clock domain's first edge without reset follows from it
    std::unique_ptr<ContentCache> cache_;

    std::vector<std::unique_ptr<ColumnTime>> columns_;
    std::deque<ColumnRelays> relays_;  ///< of each column; composers keep references
    std::unique_ptr<Agenda> agenda_;
    std::unique_ptr<SwapLock> swap_lock_;
    std::vector<std::unique_ptr<sc_core::sc_signal<bool>>> pair_requests_;
    std::vector<std::unique_ptr<DviSource>> dvi_sources_;
    std::vector<std::unique_ptr<DviDecoder>> dvi_decoders_;
    std::vector<std::unique_ptr<InputFramebuffer>> input_framebuffers_;
    std::vector<Memory> frame_memories_;
    std::vector<std::unique_ptr<Bus>> buses_;
    std::vector<std::unique_ptr<Composer>> composers_;  ///< renderer by renderer
    std::vector<std::unique_ptr<OutputFramebuffer>> output_framebuffers_;
    std::vector<std::unique_ptr<DviDisplay>> dvi_displays_;

    FrameShown on_frame_shown_;
    std::function<void()> on_finished_;
    ShownFrames shown_;
    bool finished_ = false;
    sc_core::sc_event settle_event_;
    sc_core::sc_event finish_event_;
    std::int64_t watchdog_interval_;
    std::int64_t next_look_ = 0;
    std::int64_t last_progress_ = -1;
    bool watchdog_tripped_ = false;
    RunReport report_;
};

}  // namespace metabuffer::tlm
