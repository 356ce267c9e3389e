#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "host/enum_table.h"

namespace metabuffer::tlm {

/// The kinds of slices of a schedule.
enum class Slice : std::uint8_t {
    kTable,
    kBeats,
    kRecoveredBeats,
    kPageMiss,
    kRefresh,
    kLinkWrites,
    kArbitration,
    kPoll,
    kLostSlot,
    kComposite,
    kStall,
    kShows
};

/// What a schedule writes of a kind, and what that says to its readers.
struct SliceRow {
    Slice value;
    /// D or F in it is the number of a display or of a frame. Perfetto chooses its colours by the name without its numbers,
    /// so the name must show the kind.
    std::string_view name;
    std::string_view colour_name;  ///< the cname of chrome://tracing; empty: it chooses one itself
    std::string_view colour;       ///< the same as one sees it
    std::array<std::string_view, 4> arguments;  ///< besides the clocks
    std::string_view meaning;
};

inline constexpr std::array kSliceTable{
    SliceRow{Slice::kTable,
             "table of frame F",
             "",
             "",
             {"frame"},
             "a frame begins: its table goes to all composers"},
    SliceRow{Slice::kBeats,
             "display D",
             "",
             "a colour for each display",
             {"frame", "first_pixel", "pixels", "recovered_slots"},
             "pixels of a burst for that display's composer, from one open page; first_pixel counts in the "
             "segment"},
    SliceRow{Slice::kRecoveredBeats,
             "display D, recovered",
             "good",
             "green",
             {"frame", "first_pixel", "pixels", "recovered_slots"},
             "the same, and so many slots were passed over to get here: their composers took none"},
    SliceRow{Slice::kPageMiss,
             "page miss",
             "bad",
             "brown",
             {"word_address", "display"},
             "the bus waits for its memory to open a page"},
    SliceRow{Slice::kRefresh,
             "refresh",
             "bad",
             "brown",
             {},
             "a burst waits for the end of its memory's refresh (memory.refresh_cycles)"},
    SliceRow{Slice::kLinkWrites,
             "link writes",
             "bad",
             "brown",
             {},
             "a burst waits while the memory writes what the link brings (memory.ports: shared)"},
    SliceRow{
        Slice::kArbitration,
        "arbitration",
        "bad",
        "brown",
        {},
        "the bus waits for its arbiter's answer (bus.grant_cycles), or for the slot table (bus.slot_table: "
        "arbiter)"},
    SliceRow{
        Slice::kPoll, "poll", "grey", "grey", {}, "there is something to send, and no composer takes it"},
    SliceRow{Slice::kLostSlot,
             "lost slot",
             "terrible",
             "red",
             {},
             "a slot whose composer could not use it (bus.arbitration: slot-allocation)"},
    SliceRow{Slice::kComposite,
             "composite frame F",
             "",
             "",
             {"frame"},
             "from the first pixel in the top composer to the last in the bottom one"},
    SliceRow{Slice::kStall,
             "stall",
             "terrible",
             "red",
             {"frame"},
             "the column stands still for a missing pixel (composer.on_starvation: stall)"},
    SliceRow{Slice::kShows,
             "shows frame F",
             "",
             "",
             {"frame"},
             "from the swap until the frame has been shown in full once"},
};
static_assert(is_in_order(kSliceTable));

}  // namespace metabuffer::tlm
