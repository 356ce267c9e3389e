#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "report/machine_event.h"
#include "report/machine_report.h"
#include "rtl/block.h"
#include "rtl/bus_registers.h"
#include "rtl/composer.h"
#include "rtl/dvi_decoder.h"
#include "rtl/dvi_display.h"
#include "rtl/dvi_source.h"
#include "rtl/gated_clock.h"
#include "rtl/input_framebuffer.h"
#include "rtl/output_framebuffer.h"
#include "rtl/swap_lock.h"
#include "rtl/tmds_decoder.h"
#include "rtl/tmds_encoder.h"
#include "rtl/watchdog.h"
#include "rtl/wire.h"
#include "simulation/frame_shown.h"

namespace metabuffer::rtl {

struct Wires;
class MachineFaults;

/// The whole machine of the paper's Figure 1, from the renderers' graphics cards to the displays: M
/// renderers, N displays, M x N composers, wired and clocked. Renderer r, display d and their composer are
/// the children dvi_source_r, dvi_decoder_r, input_framebuffer_r, composer_r_d, output_framebuffer_d and
/// dvi_display_d, all counted from 1.
///
/// Each clock domain has its clock; domains of equal period share one, since their edges are the same. All
/// clocks rise at time 0; reset is high for the first two core clocks. With `links.layer: tmds` each link has an encoder
/// and a decoder: tmds_encoder_in_r, tmds_decoder_in_r, tmds_encoder_out_d and tmds_decoder_out_d. Only machines with
/// faults inside them have the blocks of MachineFaults. Errors are those of the blocks.
class Metabuffer final : public Block {
  public:
    /// The scenario must have passed check_scenario and must outlive the machine.
    Metabuffer(const sc_core::sc_module_name& name, const Scenario& scenario,
               ClockGating gating = ClockGating::kOn);
    ~Metabuffer() override;
    SC_HAS_PROCESS(Metabuffer);

    void on_frame_shown(FrameShown callback) { on_frame_shown_ = std::move(callback); }

    /// Called once, after the clock in which the scenario's last frame has been shown on every display or the
    /// watchdog has found that nothing moves.
    void on_finished(std::function<void()> callback) { on_finished_ = std::move(callback); }

    /// Called for each starved raster pixel of a composer (renderer and display from 1), `glitch` mode only.
    void on_starved_pixel(
        const std::function<void(int renderer, int display, const StarvedPixel&)>& callback);

    /// What the watchdog found, one line for each block that waits; empty if it has not tripped.
    const std::vector<std::string>& watchdog_findings() const { return watchdog_findings_; }
    bool finished() const { return finished_; }

    /// The run so far. Call it between clocks, best from on_finished.
    RunReport report() const;

    /// How many blocks trace_blocks would add.
    int matching_blocks(const std::vector<std::string>& patterns) const;
    /// Adds the clocks, and the blocks whose names within the machine match a shell pattern; all blocks without patterns.
    void trace_blocks(sc_core::sc_trace_file* file, const std::vector<std::string>& patterns) const;
    void trace(sc_core::sc_trace_file* file) const override;
    /// Nothing of the machine moves from now on, so that it costs others in its elaboration no time. For a test that has
    /// seen enough.
    void stop_clocks();

    /// The events that a trace window can start at, as far as they have happened.
    MachineEvent first_busready_drop() const;
    MachineEvent first_starved() const;
    MachineEvent first_recovered_slot() const;
    /// In the top composer of the column that starts first.
    MachineEvent startframe(int frame) const;
    /// The pair that a renderer (index, from 0) contributes to a composited frame (from 0); -1: the frame has none. Empty
    /// before the renderer's input framebuffer has started the frame.
    std::optional<int> pair_of_frame(std::size_t renderer, int frame) const {
        const auto& sources = input_framebuffers_[renderer]->frame_sources();
        const auto f = static_cast<std::size_t>(frame);
        return f < sources.size() ? std::optional<int>(sources[f].pair) : std::nullopt;
    }
    /// Core cycle of a frame's last pixel in the column that ends it last; Composer::kNever until every column has.
    std::int64_t frame_end_cycle(int frame) const;

    std::int64_t core_cycle() const { return clock_edge_number(core_period_picoseconds_); }
    /// For a progress display: raster pixels that have left the pipelines, and those of the whole run.
    std::int64_t raster_pixels_taken() const;
    std::int64_t raster_pixels_to_take() const { return raster_pixels_of_run(scenario_); }

    /// Every wire between two blocks, for code that binds to the machine from outside.
    Wires& wires() { return *wires_; }
    /// The wires inside a renderer's (index) input framebuffer, if it is made of blocks.
    FramebufferWires* inner_wires(std::size_t renderer) {
        return input_framebuffers_[renderer]->inner_wires();
    }
    /// The wires inside a composer (indices), if it is made of blocks.
    FifoWires* fifo_wires(std::size_t renderer, std::size_t display) {
        return composers_[renderer * displays() + display]->fifo_wires();
    }
    /// The fault modules between these wires and the blocks that drive them.
    const MachineFaults& faults() const { return *faults_; }
    sc_core::sc_clock& core_clk() { return core_clk_->clk; }
    sc_core::sc_clock& dvi_in_clk() { return dvi_in_clk_->clk; }
    /// The clock of a renderer's link (index): the DVI input clock, unless a fault lets it drift.
    sc_core::sc_signal<bool>& link_clk(std::size_t renderer) { return *link_clks_[renderer]; }
    sc_core::sc_clock& dvi_out_clk() { return dvi_out_clk_->clk; }
    // The gated clocks of the blocks, for other modules that sleep (rtl/clocked.h).
    const sc_core::sc_signal_in_if<bool>& core_clk_of_blocks() const { return core_clk_->of_blocks(); }
    const sc_core::sc_signal_in_if<bool>& link_clk_of_blocks(std::size_t renderer) const {
        const sc_core::sc_signal<bool>& clk = *link_clks_[renderer];
        return &clk == &dvi_in_clk_->clk ? dvi_in_clk_->of_blocks() : clk;
    }
    sc_core::sc_signal<bool>& reset() { return reset_; }

  private:
    std::size_t displays() const { return static_cast<std::size_t>(scenario_.displays.count()); }
    std::size_t renderers() const { return scenario_.renderers.size(); }
    const Composer& composer(std::size_t renderer, std::size_t display) const {
        return *composers_[renderer * displays() + display];
    }

    template <typename CycleOf>
    MachineEvent first_of_composers(const CycleOf& cycle_of) const;

    void make_clocks();
    void make_renderer_side();
    void make_bus_registers();
    void make_composers();
    void make_display_side();
    /// A link with an encoder and a decoder, from what drives it to what reads it.
    struct CodedLink {
        std::string encoder;
        std::string decoder;
        const sc_core::sc_signal_in_if<bool>& clk;
        sc_core::sc_signal<DviLink>& driven;
        sc_core::sc_signal<TmdsLink>& encoded;
        sc_core::sc_signal<TmdsLink>& received;  ///< the same wire, unless a fault lies between
        sc_core::sc_signal<DviLink>& seen;
    };
    void make_coding(const CodedLink& link);
    void drive_reset();
    void forget_frames();
    void frame_captured(std::size_t display, const ColourImage& image);
    void finish();
    std::int64_t progress() const;
    bool matches(const Block& block, const std::vector<std::string>& patterns) const;
    void watchdog_timeout();
    void settle();
    void find_who_waits();

    const Scenario& scenario_;
    ClockGating gating_;
    std::int64_t core_period_picoseconds_;
    std::int64_t dvi_in_period_picoseconds_;
    std::int64_t dvi_out_period_picoseconds_;

    /// A clock, and the gated one that the blocks have.
    struct Clock {
        Clock(const char* name, std::int64_t period_picoseconds, ClockGating gating);
        RisingClock clk;
        std::unique_ptr<GatedClock> gated;  ///< null without gating
        const sc_core::sc_signal_in_if<bool>& of_blocks() const;
    };
    std::unique_ptr<Clock> core_clk_;
    std::unique_ptr<Clock> own_dvi_in_clk_;
    std::unique_ptr<Clock> own_dvi_out_clk_;
    Clock* dvi_in_clk_ = nullptr;
    Clock* dvi_out_clk_ = nullptr;
    Wire<bool> reset_{"reset", true};
    std::int64_t next_reset_cycle_ = 0;  ///< core clock at which it may change next
    std::unique_ptr<Wires> wires_;
    std::unique_ptr<MachineFaults> faults_;
    std::vector<sc_core::sc_signal<bool>*> link_clks_;  ///< by renderer

    std::vector<std::unique_ptr<DviSource>> dvi_sources_;
    std::vector<std::unique_ptr<DviDecoder>> dvi_decoders_;
    std::vector<std::unique_ptr<InputFramebuffer>> input_framebuffers_;
    std::vector<std::unique_ptr<TmdsEncoder>>
        tmds_encoders_;  ///< by renderer, then by display, if there are any
    std::vector<std::unique_ptr<TmdsDecoder>> tmds_decoders_;   ///< likewise
    std::vector<std::unique_ptr<BusRegisters>> bus_registers_;  ///< by renderer, if there are any
    std::vector<std::unique_ptr<Composer>> composers_;          ///< renderer by renderer
    std::vector<std::unique_ptr<ColumnStall>> column_stalls_;
    std::vector<std::unique_ptr<OutputFramebuffer>> output_framebuffers_;
    std::vector<std::unique_ptr<DviDisplay>> dvi_displays_;
    std::unique_ptr<SwapLock> swap_lock_;
    std::unique_ptr<Watchdog> watchdog_;
    std::vector<const Block*> blocks_;

    FrameShown on_frame_shown_;
    std::function<void()> on_finished_;
    ShownFrames shown_;
    std::vector<std::string> watchdog_findings_;
    bool watchdog_tripped_ = false;
    sc_core::sc_event settle_event_;
    sc_core::sc_event finish_event_;
    bool finished_ = false;
};

}  // namespace metabuffer::rtl
