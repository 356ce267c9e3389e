#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <systemc>
#include <vector>

#include "formats/image.h"
#include "functional/functional_compositor.h"
#include "monitors/picture_reference.h"
#include "monitors/swap_lock_monitor.h"
#include "monitors/violation.h"
#include "report/report.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::rtl {
struct Wires;
}  // namespace metabuffer::rtl

namespace metabuffer::monitors {

/// Compares what a machine does with the functional level, value by value, on the machine's wires:
/// - scoreboard/pair: a frame is made of a pair that the renderer's link has brought whole (EVENT), and never of an
///   older pair than the frame before
/// - scoreboard/table: a bus broadcasts the valid rows of the pair's table, in their order
/// - scoreboard/bus: each pixel on a bus is the one of the pair's image at its position
/// - scoreboard/pixel: each raster pixel at the bottom of a pipeline is the functional level's, less the local pixels
///   that starved there; one marked `lost` is not compared
/// - scoreboard/picture: each picture that a display shows is the averaged and corrected raster; for a frame with lost
///   pixels it is the picture before
///
/// Where faults disturb the characters of a link, the image of a pair is what the link's decoder has given (PIXEL): the
/// faults themselves are not judged, and all that follows is compared.
///
/// The first wrong raster pixel of a frame and display is traced back: which renderer should have won, with which
/// source pixel and Z, which one did, and which composer's PIPE was the first to be wrong, at which core clock.
/// A violation's cycle is the edge that samples the wrong value.
class Scoreboard final : public sc_core::sc_module {
  public:
    /// The pair that a renderer (index, from 0) contributes to a composited frame (from 0); -1: the frame has none. Empty
    /// before the renderer's input framebuffer has started the frame. No wire shows the pair.
    using PairOfFrame = std::function<std::optional<int>(std::size_t renderer, int frame)>;

    /// Binds to the wires. Scenario and wires must outlive the simulation.
    Scoreboard(const sc_core::sc_module_name& name, const Scenario& scenario, rtl::Wires& wires,
               sc_core::sc_signal_in_if<bool>& core_clk, sc_core::sc_signal_in_if<bool>& reset,
               PairOfFrame pair_of_frame, ViolationLog& log);
    ~Scoreboard() override;
    SC_HAS_PROCESS(Scoreboard);

    /// The local pixel of a renderer and display (indices, from 0) starved. To be called before the raster pixel leaves
    /// the pipeline.
    void starved(std::size_t renderer, std::size_t display, const StarvedPixel& pixel);
    /// A display has shown a composited frame in full for the first time.
    void shown(const SwapLockMonitor::Shown& shown);

    /// What has been compared.
    std::int64_t bus_pixels() const { return bus_pixels_; }
    std::int64_t raster_pixels() const { return raster_pixels_; }
    std::int64_t pictures() const { return pictures_; }

  private:
    sc_core::sc_in<bool> clk_i_{"clk_i"};
    sc_core::sc_in<bool> reset_i_{"reset_i"};

    struct Bus;
    struct Column;

    void restart();
    void core_edge();
    void take_events();
    void take_pixels();
    void put_received(functional::Contribution& contribution, std::size_t renderer, int pair) const;
    void take_beat(std::size_t renderer, std::int64_t cycle);
    void begin_table(std::size_t renderer, std::int64_t cycle);
    void check_pixels(std::size_t renderer, const rtl::BusBeat& beat, std::int64_t cycle);
    void column_edge(std::size_t display, std::int64_t cycle);
    void begin_frame(std::size_t display);
    void take_raster_pixel(std::size_t display, std::int64_t cycle);
    void end_frame(std::size_t display);
    std::string trace_back(std::size_t display, const PictureReference::Column& wanted,
                           Violation& violation) const;
    std::string pixel_text(Pixel pixel) const;
    std::string renderer_text(int renderer) const;
    const std::vector<functional::Contribution>& contributions_of(int frame);

    const Scenario& scenario_;
    rtl::Wires& wires_;
    PairOfFrame pair_of_frame_;
    ViolationLog& log_;
    std::size_t renderers_;
    std::size_t displays_;
    int raster_width_;
    int raster_pixels_of_frame_;
    bool may_stall_;
    std::int64_t core_period_picoseconds_;

    PictureReference reference_;
    functional::Compositor compositor_;
    int contributions_frame_ = -1;  ///< of the contributions held
    std::vector<functional::Contribution> contributions_;

    std::vector<bool> link_errs_;  ///< by renderer: faults disturb the characters of its link
    std::vector<Bus> buses_;
    std::vector<Column> columns_;
    std::set<std::int64_t> bad_frames_;  ///< composited frames with lost pixels
    bool fresh_ = true;                  ///< nothing has happened since a reset

    std::int64_t bus_pixels_ = 0;
    std::int64_t raster_pixels_ = 0;
    std::int64_t pictures_ = 0;
};

}  // namespace metabuffer::monitors
