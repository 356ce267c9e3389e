#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenario/scenario.h"
#include "tlm/schedule_observer.h"
#include "tlm/schedule_slices.h"

namespace metabuffer::tlm {

/// Writes what is reported to it as a trace for ui.perfetto.dev and chrome://tracing (Trace Event Format, JSON): a
/// track for each bus, a counter for each composer's buffer, two tracks for each display. docs/schedule-trace.md
/// explains how to read it.
///
/// Times are in microseconds, to the nanosecond: core clock n is at n periods, rounded, and a span ends where the clock
/// after it begins. Perfetto rounds `ts` and `dur` to nanoseconds separately. With finer numbers neighbouring slices
/// could overlap by one nanosecond, and Perfetto removes overlapping slices from their track. `first_cycle` among the
/// arguments is the exact core clock.
///
/// With a window, only what lies in it is written. Slices are cut at its edges; their arguments then have the clocks of
/// the whole slice. Levels begin at the window's first clock.
///
/// Events are written as they come, so memory holds only a buffer and a few numbers for each composer. The file grows
/// as FILE.part and gets its name when finish() has completed it; without that it is removed.
class ScheduleTrace final : public ScheduleObserver {
  public:
    /// Throws InputError unless the name ends in .json, OutputError if the file cannot be written.
    ScheduleTrace(const std::filesystem::path& file, const Scenario& scenario);
    ~ScheduleTrace() override;

    /// Throws InputError unless the file's name ends in .json.
    static void check_name(const std::filesystem::path& file);

    /// Only these clocks are shown. Call it before any event.
    void show_only(CycleSpan window);

    /// Completes the file and puts it in place. Call it once, after all events. Returns the clocks that the file shows;
    /// nothing, and no file is left, if nothing has happened in the window. Throws OutputError, also for a write that
    /// failed earlier: a run never fails at an event.
    std::optional<CycleSpan> finish(std::int64_t core_cycles);

    void bus(int renderer, const BusSpan& span) override;
    std::int64_t level_wanted_cycle() const override { return window_ ? window_->first : -1; }
    /// Writes a level only if it differs from the composer's last one.
    void buffer_level(int renderer, int display, std::int64_t cycle, int held_pixels) override;
    void composited(int display, int frame, CycleSpan span) override;
    void column_stall(int display, int frame, CycleSpan span) override;
    void shown(int display, int frame, CycleSpan span) override;

  private:
    class Output;

    void write_tracks(const Scenario& scenario);
    CycleSpan in_window(CycleSpan span) const;
    /// number: what stands for D or F in the kind's name. arguments: those of its row.
    void write_slice(Slice kind, int number, int process, int thread, CycleSpan span,
                     std::initializer_list<std::int64_t> arguments);

    /// The level of a composer's buffer.
    struct Level {
        int written = -1;        ///< the last in the file; -1: none
        bool is_before = false;  ///< the last one reported is of a clock before the window
        int reported = 0;
    };
    void write_level(int renderer, int display, std::int64_t cycle, int held_pixels);
    Level& level(int renderer, int display) {
        return levels_[static_cast<std::size_t>((renderer - 1) * displays_ + display - 1)];
    }

    std::unique_ptr<Output> output_;
    std::string scenario_name_;
    double core_mhz_;
    std::int64_t period_picoseconds_;
    int displays_;
    std::vector<std::string>
        counter_names_;          ///< of each renderer's composers, the text before the display's number
    std::vector<Level> levels_;  ///< by renderer and display
    std::optional<CycleSpan> window_;
    bool is_empty_ = true;  ///< nothing has been written except for the window's first levels
};

}  // namespace metabuffer::tlm
