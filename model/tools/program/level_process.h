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

/// A run of one level in a process of its own. That process sends its pictures and its report, waits while they are not
/// read, and ends with this object. Construct it before SystemC elaborates anything in this process.
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

    /// Starts the run. Without `images` it sends no pictures. Throws InputError if the process cannot be started.
    LevelProcess(TimedLevel level, const Scenario& scenario, bool images);

    TimedLevel level() const { return level_; }
    /// Whether everything has been received.
    bool ended() const { return process_.ended(); }
    /// Poll it for reading until the process has ended.
    int descriptor() const { return process_.descriptor(); }
    /// Reads what has arrived, waits if nothing has, and returns the pictures that are complete.
    std::vector<Picture> receive();

    /// Share of the run's raster pixels that have been composited, as last reported.
    double progress() const { return progress_; }
    /// Once it has ended, exactly one of the two has a value.
    const std::optional<Result>& result() const { return result_; }
    const std::optional<Failure>& failure() const { return failure_; }

  private:
    void take_messages(std::vector<Picture>& pictures);
    void take_message(const LevelMessage& message, const char* payload, std::vector<Picture>& pictures);
    void end();

    TimedLevel level_;
    ChildProcess process_;
    std::string received_;  ///< the beginning of a message that is not complete
    double progress_ = 0.0;
    std::optional<Result> result_;
    std::optional<Failure> failure_;
};

}  // namespace metabuffer
