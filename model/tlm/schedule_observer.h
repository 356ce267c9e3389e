#pragma once

#include <cstdint>
#include <optional>

#include "datapath/link/reject_cause.h"
#include "formats/control_scanline.h"
#include "report/bus_use.h"
#include "report/cycle_span.h"
#include "report/report.h"

namespace metabuffer::tlm {

/// A frame of a link, as the decoder has read it.
struct LinkFrameSeen {
    CycleSpan span;                 ///< from its first pixel to its last, in the input framebuffer
    std::optional<FrameKind> kind;  ///< none: its control scanline cannot be read
    std::uint32_t pair = 0;         ///< with kind
    bool taken = false;             ///< it is half of a pair, as far as is known at its end
    std::optional<RejectCause> cause = std::nullopt;  ///< why it was rejected; none: it was ignored
};

/// Clocks that a bus spends in one way.
struct BusSpan {
    BusUse use = BusUse::kPoll;
    CycleSpan cycles;
    int frame = 0;                 ///< of a table and of beats
    int display = 0;               ///< of beats and of a page miss: whose composer's
    std::int64_t first_pixel = 0;  ///< of beats: index in the segment
    /// Of beats, which follow each other on an open page. A burst with page misses in it comes in several parts.
    int pixels = 0;
    int recovered_slots = 0;        ///< of a burst, with its first beats
    std::int64_t word_address = 0;  ///< of a page miss
    int page_misses = 0;            ///< 1: the opening of a page begins
};

/// Listens to what the transaction-level machine does with its time. Renderers and displays count from 1, frames from 0;
/// every span is in core clocks and has at least one. Calls come in the order in which things are decided: one bus's
/// spans are in order of time, but those of different buses are not, since a bus may run ahead of the others.
class ScheduleObserver {
  public:
    ScheduleObserver() = default;
    ScheduleObserver(const ScheduleObserver&) = delete;
    ScheduleObserver& operator=(const ScheduleObserver&) = delete;
    virtual ~ScheduleObserver() = default;

    virtual void bus(int renderer, const BusSpan& span) = 0;
    /// The pixels that a composer's buffer holds at the end of a clock; called where the slope may change.
    virtual void buffer_level(int renderer, int display, std::int64_t cycle, int held_pixels) = 0;
    /// A clock for which buffer_level is called for every buffer in use; -1: none. Called before the run.
    virtual std::int64_t level_wanted_cycle() const { return -1; }
    /// A frame's composition in one column, from its first pixel in the top composer to its last in the
    /// bottom one.
    virtual void composited(int display, int frame, CycleSpan span) = 0;
    /// A column stands still.
    virtual void column_stall(int display, int frame, CycleSpan span) = 0;
    /// A frame on the display's screen: from the swap to the clock in which it has been shown in full once.
    virtual void shown(int display, int frame, CycleSpan span) = 0;

    // An observer need not override these.
    /// A frame of a renderer's link; its span may end after the run.
    virtual void link_frame(int /*renderer*/, const LinkFrameSeen& /*frame*/) {}
    /// Raster pixels of a frame that starved in a composer. Called once the frame has been composited, in raster order.
    virtual void starved(int /*renderer*/, int /*display*/, const StarvedRun& /*run*/) {}
};

}  // namespace metabuffer::tlm
