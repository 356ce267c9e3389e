#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "functional/wrong_pixels.h"
#include "report/report.h"
#include "scenario/fault_keys.h"
#include "scenario/scenario.h"
#include "simulation/frame_shown.h"

namespace metabuffer {

/// Counts the wrong pixels of a run, for its report, in the pictures that it shows. It checks only pictures in which
/// something starved, and all of them if faults disturb a link's characters. So other runs take no longer.
class WrongPixelRecord {
  public:
    /// The scenario must outlive it.
    explicit WrongPixelRecord(const Scenario& scenario)
        : wrong_pixels_(scenario),
          displays_(static_cast<std::size_t>(scenario.displays.count())),
          links_err_(disturbs_characters(scenario)) {}

    /// Returns the wrong ones of this picture, as WrongPixels::find() has them, until the next call.
    const std::vector<std::size_t>& take(const DisplayedFrame& displayed);
    /// Writes the counts to the frames of the report. Call it once every picture has been taken.
    void put_into(RunReport& report) const;

  private:
    functional::WrongPixels wrong_pixels_;
    std::size_t displays_;
    bool links_err_;  ///< every picture may be wrong
    std::vector<std::size_t> found_;
    std::map<int, std::vector<std::int64_t>> counts_;  ///< by frame, then by display
};

}  // namespace metabuffer
