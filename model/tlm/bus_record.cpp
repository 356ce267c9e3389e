#include "tlm/bus_record.h"

#include <algorithm>
#include <array>

#include "report/waits.h"

namespace metabuffer::tlm {
namespace {

struct UseRow {
    std::int64_t BusCounters::*clocks;
    std::string (*waits)();
};

/// By BusRecord::Use.
constexpr std::array<UseRow, 7> kUses = {{{&BusCounters::table_cycles, nullptr},
                                          {&BusCounters::busy_cycles, nullptr},
                                          {&BusCounters::page_miss_cycles, waits::for_memory_page},
                                          {&BusCounters::refresh_cycles, waits::for_memory_refresh},
                                          {&BusCounters::write_cycles, waits::for_memory_write},
                                          {&BusCounters::grant_cycles, nullptr},
                                          {&BusCounters::lost_cycles, waits::for_lost_slot}}};

const UseRow& row_of(BusRecord::Use use) { return kUses[static_cast<std::size_t>(use)]; }

}  // namespace

std::int64_t BusRecord::Span::cycles_through(std::int64_t cycle) const {
    return std::clamp<std::int64_t>(cycle + 1 - cycles.first, 0, std::max<std::int64_t>(0, cycles.cycles()));
}

void BusRecord::add(Use use, CycleSpan cycles, int amount) {
    counters_.*row_of(use).clocks += cycles.cycles();
    if (use == Use::kBeats) counters_.pixels_sent += amount;
    if (use == Use::kPageMiss) counters_.page_misses += amount;
    newest_.push_back({use, cycles, amount});
}

void BusRecord::add_burst(std::int64_t cycle, int recovered_slots) {
    ++counters_.bursts;
    counters_.recovered_slots += recovered_slots;
    newest_burst_ = {cycle, recovered_slots};
}

void BusRecord::begin_poll(std::int64_t cycle) {
    polls_ = true;
    poll_began_ = cycle;
}

void BusRecord::end_poll(std::int64_t cycle) {
    polls_ = false;
    counters_.poll_cycles += cycle - poll_began_;
}

std::int64_t BusRecord::pixels_behind(std::int64_t cycle) const {
    std::int64_t pixels = 0;
    for (const Span& span : newest_) {
        if (span.use != Use::kBeats) continue;
        const std::int64_t beats = (span.cycles_through(cycle) + cycles_per_beat_ - 1) / cycles_per_beat_;
        pixels += span.amount - std::min<std::int64_t>(span.amount, beats * pixels_per_beat_);
    }
    return pixels;
}

BusCounters BusRecord::counters(std::int64_t through_cycle) const {
    BusCounters bus = counters_;
    if (polls_) bus.poll_cycles += std::max<std::int64_t>(0, through_cycle + 1 - poll_began_);
    if (newest_burst_.cycle > through_cycle) {
        --bus.bursts;
        bus.recovered_slots -= newest_burst_.recovered_slots;
    }
    for (const Span& span : newest_) {
        bus.*row_of(span.use).clocks -= span.cycles.cycles() - span.cycles_through(through_cycle);
        if (span.use == Use::kPageMiss && through_cycle < span.cycles.first) bus.page_misses -= span.amount;
    }
    bus.pixels_sent -= pixels_behind(through_cycle);
    bus.idle_cycles = through_cycle + 1 - bus.wanted_cycles();
    return bus;
}

std::optional<std::string> BusRecord::waiting_for(std::int64_t cycle) const {
    for (const Span& span : newest_) {
        if (cycle < span.cycles.first || cycle >= span.cycles.last) continue;
        if (span.use == Use::kTable) return std::string();
        if (row_of(span.use).waits != nullptr) return row_of(span.use).waits();
    }
    return std::nullopt;
}

}  // namespace metabuffer::tlm
