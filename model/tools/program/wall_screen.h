#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/image.h"
#include "scenario/scenario.h"
#include "simulation/frame_shown.h"
#include "tools/program/wall_window.h"

namespace metabuffer {

/// Shows the frames of all displays, side by side, while a run goes on: in a window, and as raw video (R, G and B of each
/// pixel, one byte each, row after row, frame after frame).
class WallScreen {
  public:
    /// video: a file, or "-" for standard output; empty: none. window: whether one is wanted. The scenario must outlive
    /// the screen. Throws OutputError.
    WallScreen(const Scenario& scenario, const std::string& video, bool window);

    /// Why there is no window though one is wanted; empty if there is one.
    const std::string& why_no_window() const { return why_no_window_; }
    /// A display has shown a frame. Once all have, the frame is shown here. Throws OutputError.
    void take(const DisplayedFrame& displayed, const std::vector<std::size_t>& wrong_pixels);
    /// Answers what the user does to the window.
    void poll();
    /// What is to be done when the user closes the window.
    void when_closed(std::function<void()> end) { end_ = std::move(end); }

  private:
    void write(const ColourImage& picture);

    const Scenario& scenario_;
    std::vector<ColourImage> displays_;
    std::vector<ColourImage> marked_;           ///< the same, wrong pixels marked
    std::vector<int> frames_;                   ///< by display: the newest
    std::vector<std::int64_t> starved_pixels_;  ///< by display, of its newest frame; hidden ones as well
    std::vector<std::int64_t> wrong_pixels_;    ///< by display, of its newest frame
    std::string video_name_;
    std::ofstream video_file_;
    std::ostream* video_ = nullptr;
    std::string bytes_;
    std::unique_ptr<WallWindow> window_;
    std::string why_no_window_;
    std::function<void()> end_;
};

}  // namespace metabuffer
