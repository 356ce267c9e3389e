#pragma once

#include "images/image_codec.h"

namespace metabuffer {

/// As ImageCodec::png, colour_tiff and depth_tiff say.
std::string encode_png(const ColourImage& image, const std::filesystem::path& file,
                       const std::string& description);
std::string encode_colour_tiff(const PixelImage& image, const std::filesystem::path& file);
std::string encode_depth_tiff(const PixelImage& image, DepthFormat format, const std::filesystem::path& file);

}  // namespace metabuffer
