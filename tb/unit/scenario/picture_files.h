#pragma once

#include <OpenImageIO/imageio.h>

#include <catch2/catch.hpp>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "images/image_codec.h"

namespace metabuffer::test {

/// What a file is to look like: `file_type` of all channels, or one type per channel.
struct PictureFormat {
    std::vector<std::string> channels{"R", "G", "B"};
    OIIO::TypeDesc file_type = OIIO::TypeDesc::UINT8;
    std::vector<OIIO::TypeDesc> channel_types = {};
    bool unassociated_alpha = false;
    int orientation = 0;            ///< 0: none is written
    OIIO::ROI display_window = {};  ///< with `data_x`, `data_y`, if it is not what the samples cover
    int data_x = 0;
    int data_y = 0;
};

/// Writes samples (all of one type, pixel by pixel) with OpenImageIO.
template <typename Sample>
void write_picture(const std::filesystem::path& file, int width, int height, const PictureFormat& format,
                   const std::vector<Sample>& samples) {
    static_cast<void>(image_codec());  // starts its process while this one has no threads of OpenImageIO's
    const int channels = static_cast<int>(format.channels.size());
    REQUIRE(samples.size() == static_cast<std::size_t>(width * height * channels));
    OIIO::ImageSpec spec(width, height, channels, format.file_type);
    spec.channelnames = format.channels;
    spec.channelformats = format.channel_types;
    spec.alpha_channel = -1;
    spec.z_channel = -1;
    for (int c = 0; c < channels; ++c) {
        if (format.channels[static_cast<std::size_t>(c)] == "A") spec.alpha_channel = c;
        if (format.channels[static_cast<std::size_t>(c)] == "Z") spec.z_channel = c;
    }
    if (format.orientation != 0) spec.attribute("Orientation", format.orientation);
    if (format.display_window.defined()) {
        spec.set_roi_full(format.display_window);
        spec.x = format.data_x;
        spec.y = format.data_y;
    }
    if (format.unassociated_alpha) spec.attribute("oiio:UnassociatedAlpha", 1);
    const auto output = OIIO::ImageOutput::create(file.string());
    REQUIRE(output != nullptr);
    INFO(output->geterror());
    REQUIRE(output->open(file.string(), spec));
    REQUIRE(output->write_image(OIIO::BaseTypeFromC<Sample>::value, samples.data()));
    REQUIRE(output->close());
}

}  // namespace metabuffer::test
