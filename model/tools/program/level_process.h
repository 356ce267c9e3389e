#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/image.h"
#include "host/child_process.h"
#include "scenario/scenario.h"
#include "tools/program/failure.h"
#include "tools/program/timed_level.h"

namespace metabuffer {

struct LevelMessage;

/// A run of one level in a process of its own, which hands its pictures and its report over, waits while nobody reads,
/// and ends with this object. Construct it before this process elaborates anything.
class LevelProcess {
  public:
    /// A frame (from 0) as it was shown on a display (from 1).
    struct Picture {
        int frame = 0;
        int display = 0;
        ColourImage image;
    };
    struct Result {
        std::string report;  ///< as report_json() makes it
        std::int64_t core_cycles = 0;
        double simulation_seconds = 0.0;
        bool watchdog_tripped = false;
    };

    /// Starts the run. Without `images` no picture comes. Throws InputError if this computer has no process for
    /// it.
    LevelProcess(TimedLevel level, const Scenario& scenario, bool images);

    TimedLevel level() const { return level_; }
    /// Whether all has been received that will ever come.
    bool ended() const { return process_.ended(); }
    /// To poll for reading until the process has ended.
    int descriptor() const { return process_.descriptor(); }
    /// Reads what is there, waiting if there is nothing, and returns the pictures that are complete.
    std::vector<Picture> receive();

    /// Share of the run's raster pixels that have been composited, as last heard.
    double progress() const { return progress_; }
    /// Once it has ended: exactly one of the two is there.
    const std::optional<Result>& result() const { return result_; }
    const std::optional<Failure>& failure() const { return failure_; }

  private:
    void take_messages(std::vector<Picture>& pictures);
    void take_message(const LevelMessage& message, const char* payload, std::vector<Picture>& pictures);
    void end();

    TimedLevel level_;
    ChildProcess process_;
    std::string received_;  ///< up to one message that is not complete
    double progress_ = 0.0;
    std::optional<Result> result_;
    std::optional<Failure> failure_;
};

}  // namespace metabuffer
