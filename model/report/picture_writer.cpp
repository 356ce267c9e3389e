#include "report/picture_writer.h"

#include <algorithm>
#include <cstdint>

#include "host/output_file.h"
#include "images/image_codec.h"

namespace metabuffer {
namespace {

constexpr std::uint32_t kMidGrey = 0x80'8080U;

}  // namespace

void write_png(const std::filesystem::path& file, const ColourImage& image) {
    write_output_file(file, image_codec().png(image, file));
}

ColourImage collage(const std::vector<ColourImage>& displays, const DisplayConfig& config, int gap_pixels) {
    const int pitch_x = config.width_pixels + gap_pixels;
    const int pitch_y = config.height_pixels + gap_pixels;
    ColourImage picture(config.columns * pitch_x - gap_pixels, config.rows * pitch_y - gap_pixels, kMidGrey);
    for (std::size_t index = 0; index < displays.size(); ++index) {
        const ColourImage& display = displays[index];
        const int left = static_cast<int>(index) % config.columns * pitch_x;
        const int top = static_cast<int>(index) / config.columns * pitch_y;
        for (int y = 0; y < display.height_pixels; ++y) {
            const auto* row = &display.values[display.index(0, y)];
            std::copy(row, row + display.width_pixels, &picture.values[picture.index(left, top + y)]);
        }
    }
    return picture;
}

}  // namespace metabuffer
