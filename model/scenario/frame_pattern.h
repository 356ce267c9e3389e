#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/viewport_splitter.h"

/// One entry of a renderer's list that stands for many frames: files with numbers in their names, and a viewport that
/// moves.
namespace metabuffer::input {

/// The numbers of the frames, both ends included.
struct FrameNumbers {
    int first = 0;
    int last = 0;

    int count() const { return last - first + 1; }
};

/// "0-299" or "7". Nothing if it is neither, or if the first number is the larger one.
std::optional<FrameNumbers> parse_frame_numbers(const std::string& text);

/// The name with its %d replaced by the number, or %04d by at least four digits; a name without % as it is. Nothing if the
/// name has another % or more than one.
std::optional<std::string> numbered_name(const std::string& name, int number);

/// A position of a moving viewport.
struct PathPosition {
    int frame = 0;
    Viewport viewport;
};

/// Where a viewport is in a frame: between two positions it moves evenly, to whole raster pixels, with the
/// magnification of the position before. Before the first position it is at the first one, after the last position at
/// the last one. path: at least one position, in the order of frames, no two in one frame.
Viewport viewport_on_path(const std::vector<PathPosition>& path, int frame);

}  // namespace metabuffer::input
