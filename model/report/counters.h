#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "report/report.h"

/// The table of counters. JSON, totals, figures of sweeps, the monitors' comparison, `metabuffer counters` and the
/// documentation use it. A new counter needs a member, a row, and the code that counts it.
namespace metabuffer {

/// How many counts make a total.
enum class CounterTotal : std::uint8_t { kSum, kMost };

template <typename Owner>
struct Counter {
    const char* name = nullptr;
    const char* unit = nullptr;
    const char* meaning = nullptr;
    std::int64_t Owner::*member = nullptr;
    CounterTotal total = CounterTotal::kSum;
    const char* total_name = nullptr;  ///< among the totals, where the name is another counter's

    constexpr const char* name_in_totals() const { return total_name != nullptr ? total_name : name; }
};

/// The counters of an owner, in the order of report.json, and what its owners are called.
template <typename Owner>
struct Counters;

template <>
struct Counters<BusCounters> {
    static constexpr const char* kOwners = "buses";
    static constexpr std::array kTable{
        Counter<BusCounters>{"busy_cycles", "clocks", "clocks in which a pixel, or a part of one, moves",
                             &BusCounters::busy_cycles},
        Counter<BusCounters>{"table_cycles", "clocks", "clocks of table broadcast",
                             &BusCounters::table_cycles},
        Counter<BusCounters>{"page_miss_cycles", "clocks",
                             "clocks that a burst waits for the memory to open a page",
                             &BusCounters::page_miss_cycles},
        Counter<BusCounters>{"refresh_cycles", "clocks",
                             "clocks that a burst waits for a refresh of the memory to end",
                             &BusCounters::refresh_cycles},
        Counter<BusCounters>{"write_cycles", "clocks",
                             "clocks that a burst waits for the link's words to be written (shared ports)",
                             &BusCounters::write_cycles},
        Counter<BusCounters>{"grant_cycles", "clocks",
                             "clocks in which the arbiter is at work and the bus waits for its answer",
                             &BusCounters::grant_cycles},
        Counter<BusCounters>{"poll_cycles", "clocks",
                             "clocks with something to send, tables included, and no composer ready for it",
                             &BusCounters::poll_cycles},
        Counter<BusCounters>{"lost_cycles", "clocks",
                             "clocks of slots that their composer could not use (slot-allocation)",
                             &BusCounters::lost_cycles},
        Counter<BusCounters>{"idle_cycles", "clocks", "clocks with nothing to send, reset included",
                             &BusCounters::idle_cycles},
        Counter<BusCounters>{"page_misses", "", "pages that the memory opened", &BusCounters::page_misses},
        Counter<BusCounters>{"pixels_sent", "pixels", "pixels put on the bus", &BusCounters::pixels_sent},
        Counter<BusCounters>{"bursts", "", "grants", &BusCounters::bursts},
        Counter<BusCounters>{"recovered_slots", "",
                             "slots passed over by grants and used by the next composer in the table",
                             &BusCounters::recovered_slots},
    };
};

template <>
struct Counters<RendererCounters> {
    static constexpr const char* kOwners = "renderers";
    static constexpr std::array kTable{
        Counter<RendererCounters>{"repeated_frames", "frames",
                                  "frames that showed the renderer's earlier pair again",
                                  &RendererCounters::repeated_frames},
        Counter<RendererCounters>{"dropped_frames", "frames",
                                  "pairs that newer ones overtook before they were shown",
                                  &RendererCounters::dropped_frames},
        Counter<RendererCounters>{"rejected_slot_tables", "pairs",
                                  "pairs whose slot table, which the host was to send, was missing or wrong, "
                                  "so that each row had one slot",
                                  &RendererCounters::rejected_slot_tables},
        Counter<RendererCounters>{
            "injected_faults", "",
            "faults of the scenario that have taken effect on the renderer's link, its bus and its composers",
            &RendererCounters::injected_faults},
    };
};

template <>
struct Counters<ComposerCounters> {
    static constexpr const char* kOwners = "composers";
    static constexpr std::array kTable{
        Counter<ComposerCounters>{
            "starved_pixels", "pixels",
            "covered raster pixels whose local pixel had not come in time, each repetition on its own",
            &ComposerCounters::starved_pixels},
        Counter<ComposerCounters>{
            "stalled_cycles", "clocks",
            "clocks that the column stood still because the composer's pixel had not come",
            &ComposerCounters::stalled_cycles},
        Counter<ComposerCounters>{"buffer_high_water", "pixels", "most pixels held at the end of a clock",
                                  &ComposerCounters::buffer_high_water, CounterTotal::kMost},
        Counter<ComposerCounters>{"busready_drops", "", "bursts that the composer cut short",
                                  &ComposerCounters::busready_drops},
        Counter<ComposerCounters>{
            "late_pixels", "pixels",
            "pixels dropped on arrival: after their last use, or of a frame that is over; "
            "those of an abandoned frame are not counted",
            &ComposerCounters::late_pixels},
        Counter<ComposerCounters>{
            "replayed_pixels", "pixels",
            "local pixels read again from the moving window: second and later repetitions "
            "of a source row",
            &ComposerCounters::replayed_pixels},
        Counter<ComposerCounters>{
            "lost_pixels", "pixels",
            "pixels that were sent on the bus and never came to the composer: their frame is not shown",
            &ComposerCounters::lost_pixels},
        Counter<ComposerCounters>{
            "lost_tables", "frames",
            "frames whose start, or a row of whose table, never came to the composer: they are not shown",
            &ComposerCounters::lost_tables},
    };
};

template <>
struct Counters<DisplayCounters> {
    static constexpr const char* kOwners = "displays";
    static constexpr std::array kTable{
        Counter<DisplayCounters>{"frames_shown", "frames", "composited frames that the display has shown",
                                 &DisplayCounters::frames_shown},
        Counter<DisplayCounters>{"stalled_cycles", "clocks", "clocks that the display's column stood still",
                                 &DisplayCounters::stalled_cycles, CounterTotal::kSum,
                                 "display_stalled_cycles"},
        Counter<DisplayCounters>{"kept_frames", "frames",
                                 "of frames_shown, those replaced by the picture before, because pixels or "
                                 "tables of them were lost",
                                 &DisplayCounters::kept_frames},
    };
};

/// Adds the counts of one owner to the total.
template <typename Owner>
void add_counters(Owner& total, const Owner& one) {
    for (const Counter<Owner>& counter : Counters<Owner>::kTable) {
        std::int64_t& sum = total.*counter.member;
        const std::int64_t count = one.*counter.member;
        sum = counter.total == CounterTotal::kMost ? std::max(sum, count) : sum + count;
    }
}

}  // namespace metabuffer
