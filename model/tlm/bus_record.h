#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/cycle_span.h"
#include "report/report.h"

namespace metabuffer::tlm {

/// What a bus has done with its clocks. A decision counts what it decides to the end at once, and that may lie ahead of the
/// present clock. So a count up to a clock leaves out what the newest decision has behind it.
class BusRecord {
  public:
    enum class Use : std::uint8_t { kTable, kBeats, kPageMiss, kRefresh, kWrite, kGrant, kLost };

    BusRecord(int pixels_per_beat, int cycles_per_beat)
        : pixels_per_beat_(pixels_per_beat), cycles_per_beat_(cycles_per_beat) {}

    /// What was decided before lies in the past.
    void begin_decision() { newest_.clear(); }
    /// amount: of kBeats the pixels; of kPageMiss the pages that it opens, 0 or 1.
    void add(Use use, CycleSpan cycles, int amount = 0);
    /// The arbiter's answer comes in that clock.
    void add_burst(std::int64_t cycle, int recovered_slots);
    /// There is something to send, but no composer can receive it.
    void begin_poll(std::int64_t cycle);
    void end_poll(std::int64_t cycle);
    bool polls() const { return polls_; }
    std::int64_t poll_began() const { return poll_began_; }

    /// Everything up to a clock, which must be the present one.
    BusCounters counters(std::int64_t through_cycle) const;
    /// Pixels that are counted, but move behind that clock.
    std::int64_t pixels_behind(std::int64_t cycle) const;
    /// What the bus waits for in a clock of the newest decision, as the watchdog says it: empty while a table is sent;
    /// nothing in clocks of beats and of the arbiter.
    std::optional<std::string> waiting_for(std::int64_t cycle) const;

  private:
    struct Span {
        Use use = Use::kTable;
        CycleSpan cycles;
        int amount = 0;
        std::int64_t cycles_through(std::int64_t cycle) const;
    };

    int pixels_per_beat_;
    int cycles_per_beat_;
    BusCounters counters_;
    std::vector<Span> newest_;
    struct Burst {
        std::int64_t cycle = 0;
        int recovered_slots = 0;
    };
    Burst newest_burst_;
    bool polls_ = false;
    std::int64_t poll_began_ = 0;
};

}  // namespace metabuffer::tlm
