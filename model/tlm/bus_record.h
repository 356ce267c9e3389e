#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/report.h"
#include "tlm/schedule_observer.h"

namespace metabuffer::tlm {

/// What a bus has done with its clocks. A decision counts what it decides to the end at once, and that may lie ahead of the
/// present clock. So a count up to a clock leaves out what the newest decision has behind it.
class BusRecord {
  public:
    /// renderer: from 1. observer: is called with each span that has a clock; may be null.
    BusRecord(int renderer, int pixels_per_beat, int cycles_per_beat, ScheduleObserver* observer)
        : renderer_(renderer),
          pixels_per_beat_(pixels_per_beat),
          cycles_per_beat_(cycles_per_beat),
          observer_(observer) {}

    /// What was decided before lies in the past.
    void begin_decision() { newest_.clear(); }
    void add(const BusSpan& span);
    /// The arbiter's answer comes in that clock.
    void add_burst(std::int64_t cycle, int recovered_slots);
    /// From that clock on there is something to send, but no composer can receive it. It may have begun earlier.
    void begin_poll(std::int64_t cycle);
    /// Ends the poll before that clock, if there is one.
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
    int renderer_;
    int pixels_per_beat_;
    int cycles_per_beat_;
    ScheduleObserver* observer_;
    BusCounters counters_;
    std::vector<BusSpan> newest_;
    struct Burst {
        std::int64_t cycle = 0;
        int recovered_slots = 0;
    };
    Burst newest_burst_;
    bool polls_ = false;
    std::int64_t poll_began_ = 0;
};

}  // namespace metabuffer::tlm
