#pragma once

#include <filesystem>
#include <optional>

#include "formats/image.h"
#include "formats/pixel.h"

namespace metabuffer {

struct DepthRange {
    double near = 0.0;
    double far = 1.0;
};

/// Reads a renderer's image: channels R G B, A and Z where it has them (A = 255 and Z = 0 where it has not),
/// or Z from a one-channel file of its own. image_file.h tells the formats. Throws InputError (scenario_loader.h)
/// naming the file and what it lacks.
PixelImage load_image(const std::filesystem::path& colour_file,
                      const std::optional<std::filesystem::path>& depth_file, DepthFormat format,
                      const DepthRange& range);

}  // namespace metabuffer
