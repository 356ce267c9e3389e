#include "tlm/bus_record.h"

#include <algorithm>
#include <utility>

#include "report/waits.h"

namespace metabuffer::tlm {
namespace {

std::int64_t cycles_through(const CycleSpan& span, std::int64_t cycle) {
    return std::clamp<std::int64_t>(cycle + 1 - span.first, 0, span.cycles());
}

}  // namespace

void BusRecord::add(const BusSpan& span) {
    counters_.*row_of(kBusUseTable, span.use).counter += span.cycles.cycles();
    counters_.pixels_sent += span.pixels;
    counters_.page_misses += span.page_misses;
    newest_.push_back(span);
    if (observer_ != nullptr && span.cycles.cycles() > 0) observer_->bus(renderer_, span);
}

void BusRecord::add_burst(std::int64_t cycle, int recovered_slots) {
    ++counters_.bursts;
    counters_.recovered_slots += recovered_slots;
    newest_burst_ = {cycle, recovered_slots};
}

void BusRecord::begin_poll(std::int64_t cycle) {
    if (!polls_) poll_began_ = cycle;
    polls_ = true;
}

void BusRecord::end_poll(std::int64_t cycle) {
    if (!std::exchange(polls_, false)) return;
    counters_.poll_cycles += cycle - poll_began_;  // it lies in the past
    if (observer_ != nullptr && cycle > poll_began_) {
        observer_->bus(renderer_, {BusUse::kPoll, {poll_began_, cycle - 1}});
    }
}

std::int64_t BusRecord::pixels_behind(std::int64_t cycle) const {
    std::int64_t pixels = 0;
    for (const BusSpan& span : newest_) {
        const std::int64_t beats =
            (cycles_through(span.cycles, cycle) + cycles_per_beat_ - 1) / cycles_per_beat_;
        pixels += span.pixels - std::min<std::int64_t>(span.pixels, beats * pixels_per_beat_);
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
    for (const BusSpan& span : newest_) {
        bus.*row_of(kBusUseTable, span.use).counter -=
            span.cycles.cycles() - cycles_through(span.cycles, through_cycle);
        if (through_cycle < span.cycles.first) bus.page_misses -= span.page_misses;
    }
    bus.pixels_sent -= pixels_behind(through_cycle);
    bus.idle_cycles = through_cycle + 1 - bus.wanted_cycles();
    return bus;
}

std::optional<std::string> BusRecord::waiting_for(std::int64_t cycle) const {
    for (const BusSpan& span : newest_) {
        if (cycle < span.cycles.first || cycle >= span.cycles.last) continue;
        switch (span.use) {
            case BusUse::kTable:
                return std::string();
            case BusUse::kPageMiss:
                return waits::for_memory_page();
            case BusUse::kRefresh:
                return waits::for_memory_refresh();
            case BusUse::kWrite:
                return waits::for_memory_write();
            case BusUse::kLost:
                return waits::for_lost_slot();
            case BusUse::kBusy:
            case BusUse::kGrant:
            case BusUse::kPoll:
                break;
        }
    }
    return std::nullopt;
}

}  // namespace metabuffer::tlm
