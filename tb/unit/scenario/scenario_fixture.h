#pragma once

#include <OpenImageIO/imageio.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host/errors.h"
#include "scenario/scenario_loader.h"
#include "support/scratch_directory.h"

namespace metabuffer::test {

/// What a file is to look like: `file_type` of all channels, or one type per channel.
struct PictureFormat {
    std::vector<std::string> channels{"R", "G", "B"};
    OIIO::TypeDesc file_type = OIIO::TypeDesc::UINT8;
    std::vector<OIIO::TypeDesc> channel_types = {};
    bool unassociated_alpha = false;
};

/// Writes samples (all of one type, pixel by pixel) with OpenImageIO.
template <typename Sample>
void write_picture(const std::filesystem::path& file, int width, int height, const PictureFormat& format,
                   const std::vector<Sample>& samples) {
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
    if (format.unassociated_alpha) spec.attribute("oiio:UnassociatedAlpha", 1);
    const auto output = OIIO::ImageOutput::create(file.string());
    REQUIRE(output != nullptr);
    INFO(output->geterror());
    REQUIRE(output->open(file.string(), spec));
    REQUIRE(output->write_image(OIIO::BaseTypeFromC<Sample>::value, samples.data()));
    REQUIRE(output->close());
}

/// A black 8-bit RGB image.
inline void write_black(const std::filesystem::path& file, int width, int height) {
    write_picture(
        file, width, height, {},
        std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3));
}

/// The message of the InputError that the call throws; empty if it throws none.
template <typename Call>
std::string input_error_of(Call call) {
    try {
        call();
    } catch (const InputError& error) {
        std::string message = error.what();
        CHECK(message.find('\n') == std::string::npos);
        return message;
    }
    return "";
}

/// A directory with `image.png`, 16 x 8 pixels: wide enough for a table of one row (34 of 48 bytes), too
/// narrow for two (50).
class ScenarioFixture {
  public:
    static constexpr const char* kDisplays = "displays: {width: 16, height: 8}\n";
    static constexpr const char* kRenderers =
        "renderers:\n"
        "  - frames:\n"
        "      - image: image.png\n"
        "        viewport: {x: 0, y: 0}\n";

    ScenarioFixture() { write_black(directory_ / "image.png", 16, 8); }

    const ScratchDirectory& directory() const { return directory_; }

    Scenario parse(const std::string& text, const std::vector<std::string>& overrides = {}) const {
        std::vector<ScenarioOverride> parsed;
        parsed.reserve(overrides.size());
        for (const std::string& one : overrides) parsed.push_back(parse_override(one));
        return parse_scenario(text, "test.yaml", directory_.path(), parsed);
    }
    std::string error(const std::string& text, const std::vector<std::string>& overrides = {}) const {
        return input_error_of([&] { parse(text, overrides); });
    }

    /// The least scenario, with some lines above it.
    static std::string minimal(const std::string& lines_above = "") {
        return lines_above + kDisplays + kRenderers;
    }

  private:
    ScratchDirectory directory_;
};

}  // namespace metabuffer::test
