#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "monitors/bus_timing.h"
#include "monitors/segment_positions.h"
#include "report/composer_record.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// What a composer samples at a clock edge. Made for one call: it refers to the signals' present values.
struct ComposerInputs {
    const rtl::BusBeat& bus;
    bool startframe;             ///< from above
    const rtl::PipePixel& pipe;  ///< from above
    bool pipeready;              ///< from below
    bool column_stall;
};

/// The values on a composer's outputs after a clock edge.
struct ComposerOutputs {
    bool busready = false;
    bool tableready = false;
    bool startframe = false;
    rtl::PipePixel pipe;
    bool pipeready = false;
    bool stall = false;
};

/// A composer (box C of the paper's Figure 1) as seen from outside. From what a composer samples at each core clock
/// edge this derives its counters and what its outputs must be after that edge. It keeps what any composer must keep:
/// tables and pixels received, the raster position, the pixels held. It has no SystemC and none of the composer's own
/// code, so it can check a composer, or count for one that has no counters:
///
///     ComposerObserver observer(scenario, renderer, display);  // indices
///     at each rising edge of the core clock, with what the composer samples at it:
///         if (reset) observer.reset(pipemaster);
///         else observer.edge(inputs, core_cycle);
///     observer.expected();  // until the next edge
///     observer.counters();
///
/// Reports no errors: beats that break the bus's protocol are ignored, as a composer does after its report.
class ComposerObserver : public ComposerRecord {
  public:
    /// display, renderer: indices, from 0. The scenario is only read here.
    ComposerObserver(const Scenario& scenario, int renderer, int display);

    /// An edge that sees reset high. Counters stay.
    void reset(bool pipemaster);
    /// An edge that sees reset low. cycle: number of the edge, for the spans.
    void edge(const ComposerInputs& inputs, std::int64_t cycle);

    /// What the outputs must be since the last edge. The pixel counts only while `valid`.
    const ComposerOutputs& expected() const { return expected_; }
    /// PIPEREADY as the composer really has it, where that differs from what was expected.
    void set_pipeready(bool pipeready) { expected_.pipeready = pipeready; }
    /// With these inputs nothing changes at further edges.
    bool idle(const ComposerInputs& inputs) const;

    // ---- its state ----

    int frame() const { return frame_; }  ///< that is composited, or was last, from 0; -1: none yet
    int newest_frame() const {
        return frames_heard_ - 1;
    }                                          ///< number of the newest frame known; -1: none yet
    bool running() const { return running_; }  ///< raster pixels of frame() are being composited
    int x() const { return x_; }               ///< raster position composited next
    int y() const { return y_; }
    bool prefetched() const;  ///< for the next frame
    bool below_was_ready() const {
        return below_was_ready_;
    }                                                  ///< PIPEREADY from below counted at the last edge
    bool stood_still() const { return stood_still_; }  ///< COLUMNSTALL held the last edge
    std::int64_t held_pixels() const;
    std::int64_t free_pixels() const { return buffer_pixels_ - held_pixels(); }
    std::int64_t kept_pixels() const { return kept_pixels_; }     ///< that the last edge brought
    std::int64_t announced_pixels() const { return announced_; }  ///< of the burst under way, still to come
    bool overflowed() const { return overflowed_; }        ///< the last edge brought a pixel that had no room
    bool table_refused() const { return table_refused_; }  ///< the last edge brought a table that had no room

    // ---- frames that are known and not composited to their end ----

    bool has_frame() const { return !frames_.empty(); }
    bool has_room_for_table() const;
    // Of the oldest frame, which is composited or comes next. Lost pixels and rows count as arrived.
    bool table_complete() const { return has_frame() && oldest().table_complete; }
    bool has_segment() const { return oldest().has_segment; }
    const SegmentPositions& segment() const { return oldest().positions; }  ///< while has_segment()
    std::int64_t arrived_pixels() const { return oldest().arrived; }
    bool segment_complete() const { return oldest().abandoned || oldest().missing() == 0; }
    /// Pixels still to come of the newest frame, or of one that is over and that the bus still sends.
    std::int64_t missing_pixels() const;

    /// The segment's pixel that shows at the raster position composited next.
    struct LocalPixel {
        std::int64_t index = 0;  ///< in the segment
        std::int64_t newest =
            0;           ///< the highest index of the pixels that are mixed here; without smoothing, `index`
        int column = 0;  ///< in its source row
        bool arrived = false;    ///< all pixels that are mixed here have arrived or were lost
        bool abandoned = false;  ///< the frame is: the pixel from above passes
        bool repeated = false;   ///< its source row shows in the raster row above too
        bool last_use = false;   ///< it shows at no later position
        Pixel pixel;             ///< if it has arrived and is not abandoned; smoothed

        bool starves() const { return !arrived && !abandoned; }
    };
    /// While running(); none where the segment does not show.
    std::optional<LocalPixel> next_local_pixel() const;

  private:
    /// A frame that is known and not composited to its end.
    struct Frame {
        bool missed = false;          ///< nothing of its table was received
        bool table_complete = false;  ///< or lost
        bool has_segment = false;
        bool abandoned = false;  ///< pixels of it, or of its table, were lost
        SegmentPositions positions;
        std::int64_t arrived = 0;  ///< or lost
        std::int64_t used_up = 0;
        std::vector<std::uint64_t> ring;  ///< pixel k in [k & ring_mask]
        std::uint64_t ring_mask = 0;

        std::int64_t missing() const { return has_segment ? positions.pixels() - arrived : 0; }
        std::int64_t held() const { return abandoned || arrived <= used_up ? 0 : arrived - used_up; }
    };
    static constexpr std::size_t kFrames = 2;

    Frame& oldest() { return frames_.empty() ? unknown_ : frames_.front(); }
    const Frame& oldest() const { return frames_.empty() ? unknown_ : frames_.front(); }
    /// The frame that the bus sends, which may be over.
    Frame& receiving() { return ended_short_ ? ended_ : frames_.back(); }
    const Frame& receiving() const { return ended_short_ ? ended_ : frames_.back(); }
    bool table_open() const { return !frames_.empty() && !frames_.back().table_complete; }

    ReferenceMixture mixture_at(const Frame& frame, const ReferenceLines& columns,
                                const ReferenceLines& rows) const;
    void pipeline(const ComposerInputs& inputs, std::int64_t cycle);
    void composite(const rtl::PipePixel& upstream, std::int64_t cycle);
    bool needs_missing_pixel() const;
    void end_frame(std::int64_t cycle);
    void take_bus(const rtl::BusBeat& beat);
    bool follow_frames(const rtl::BusBeat& beat);
    void take_row(const rtl::BusBeat& beat);
    bool take_pixels(const rtl::BusBeat& beat);
    void lose(std::int64_t count);
    void lose_open_table();
    void handshakes(bool was_running, const ComposerInputs& inputs, std::int64_t cycle);

    std::uint16_t destination_;
    Composition composition_;
    std::uint32_t far_z_;
    Smoothing smoothing_;
    bool may_stall_;
    Pixel background_;
    int raster_width_;
    int raster_height_;
    std::int64_t buffer_pixels_;
    std::int64_t ready_space_pixels_;
    BusTiming timing_;

    bool pipemaster_ = false;
    std::vector<Frame> frames_;  ///< the oldest first
    Frame unknown_;              ///< stands for the oldest frame if none is known
    Frame ended_;                ///< the frame that is over, while ended_short_
    bool ended_short_ = false;   ///< pixels of a frame that is over may still come
    bool table_lost_ = false;    ///< of the newest frame known, whose pixels do not count
    std::uint32_t next_row_ = 0;
    bool running_ = false;
    int x_ = 0;
    int y_ = 0;
    SegmentPositions::RasterRow row_;  ///< the raster row of y_, in the frame that is composited
    int frame_ = -1;
    int frames_heard_ = 0;
    std::int64_t announced_ = 0;
    std::int64_t silent_edges_ = 0;   ///< since the last beat
    std::int64_t dropped_edges_ = 0;  ///< in which beats may still come of a burst that BUSREADY has ended
    bool below_was_ready_ = false;
    bool stood_still_ = false;
    bool overflowed_ = false;
    bool table_refused_ = false;
    std::int64_t kept_pixels_ = 0;
    ComposerOutputs expected_;
};

}  // namespace metabuffer::monitors
