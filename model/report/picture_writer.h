#pragma once

#include <filesystem>
#include <vector>

#include "formats/image.h"
#include "scenario/scenario.h"

namespace metabuffer {

/// Writes an 8-bit RGB PNG as write_output_file() does. Throws OutputError.
void write_png(const std::filesystem::path& file, const ColourImage& image);

/// The displays in their arrangement on the wall, `gap_pixels` of mid grey between them.
ColourImage collage(const std::vector<ColourImage>& displays, const DisplayConfig& config,
                    int gap_pixels = 4);

}  // namespace metabuffer
