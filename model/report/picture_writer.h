#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/image.h"
#include "host/errors.h"
#include "scenario/scenario.h"

namespace metabuffer {

/// The bytes of an 8-bit RGB PNG file: the same for the same picture. `file` is what an error names. Throws
/// OutputError.
std::string png_bytes(const ColourImage& image, const std::filesystem::path& file = "picture.png");

/// Writes an 8-bit RGB PNG, by way of a temporary file beside it so that a failure leaves nothing
/// half-written. Throws OutputError.
void write_png(const std::filesystem::path& file, const ColourImage& image);

/// Writes a text file the same way. Throws OutputError.
void write_text(const std::filesystem::path& file, const std::string& text);

/// The displays as they hang side by side, `gap_pixels` of mid grey between them.
ColourImage collage(const std::vector<ColourImage>& displays, const DisplayConfig& config,
                    int gap_pixels = 4);

}  // namespace metabuffer
