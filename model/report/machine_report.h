#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/report.h"
#include "scenario/scenario.h"

namespace metabuffer {

/// What a composited frame was made of, as a renderer's input framebuffer keeps it.
struct FrameSource {
    int pair = -1;  ///< -1: none yet
    bool fresh = false;
    std::int64_t last_pixel_picoseconds = 0;  ///< when the pair's last pixel was on the link
};

/// The swap at which the displays switch to a composited frame.
struct Swap {
    std::int64_t picoseconds = 0;
    bool kept = false;  ///< the displays kept the picture before, since pixels of the frame were lost
};

/// Raster pixels of all displays in all frames of a run.
std::int64_t raster_pixels_of_run(const Scenario& scenario);

/// The images that have been read and have depths outside of the depth range, each once.
std::vector<ImageDepths> clamped_depths(const Scenario& scenario);

/// The composited frames (from 0) that the displays (indices) have shown in full.
class ShownFrames {
  public:
    explicit ShownFrames(std::size_t displays) : last_(displays, -1) {}

    /// True if every display has shown the frame now.
    bool add(std::size_t display, int frame);
    /// The newest on a display; -1: none yet.
    int last(std::size_t display) const { return last_[display]; }
    /// How many every display has shown.
    int on_all_displays() const { return on_all_displays_; }

  private:
    std::vector<int> last_;
    int on_all_displays_ = 0;
};

/// Puts together the report of a machine's run, at any level, from what its blocks have counted:
///
///     MachineReport report(scenario, "rtl", shown, core_cycles);
///     for each renderer: report.add_renderer(counters, sources);
///                        for each display: report.add_composer(counters);
///     for each display:  report.add_display(counters);
///                        for each frame that all have shown: report.add_composition(frame, first, last);
///     for each of these frames: report.add_swap(frame, swap);
///     report.finish(watchdog_findings);
///
/// Names and numbers of renderers and displays, the frames shown and what starved in each are filled in here. Wrong
/// pixels are filled in by the code that has the pictures. Scenario and shown frames must outlive it.
class MachineReport {
  public:
    MachineReport(const Scenario& scenario, const std::string& level, const ShownFrames& shown,
                  std::int64_t core_cycles);

    /// sources: of each frame that has been started.
    void add_renderer(RendererCounters counters, const std::vector<FrameSource>& sources);
    void add_composer(ComposerCounters counters);
    void add_display(DisplayCounters counters);
    /// The core cycles of a frame's first and last pixel composited in a column.
    void add_composition(int frame, std::int64_t first_cycle, std::int64_t last_cycle);
    void add_swap(int frame, const Swap& swap);
    RunReport finish(std::vector<std::string> watchdog_findings);

  private:
    const Scenario& scenario_;
    const ShownFrames& shown_;
    RunReport report_;
    std::vector<std::optional<std::int64_t>> newest_pixel_picoseconds_;  ///< by frame: of its fresh pairs
};

}  // namespace metabuffer
