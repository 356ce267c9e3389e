#pragma once

#include <cstdint>

namespace metabuffer {

/// Geometry of a DVI mode in pixel clocks and lines. A line is its active pixels, front porch, sync and back
/// porch; a frame is back porch lines, active lines, front porch lines and sync lines, in that order, so that
/// the rising edge of VSYNC ends a frame. Blanking is that of reduced-blanking modes.
struct DviTiming {
    static constexpr int kHorizontalFrontPixels = 8;
    static constexpr int kHorizontalSyncPixels = 32;
    static constexpr int kHorizontalBackPixels = 40;
    static constexpr int kVerticalFrontLines = 1;
    static constexpr int kVerticalSyncLines = 8;
    static constexpr int kVerticalBackLines = 6;

    int active_pixels = 0;
    int active_lines = 0;

    constexpr int line_clocks() const {
        return active_pixels + kHorizontalFrontPixels + kHorizontalSyncPixels + kHorizontalBackPixels;
    }
    constexpr int frame_lines() const {
        return active_lines + kVerticalFrontLines + kVerticalSyncLines + kVerticalBackLines;
    }
    constexpr std::int64_t frame_clocks() const { return std::int64_t{line_clocks()} * frame_lines(); }
};

/// The mode of a renderer's link: its image below one control scanline.
constexpr DviTiming renderer_dvi_timing(int image_width_pixels, int image_height_pixels) {
    return {image_width_pixels, image_height_pixels + 1};
}

}  // namespace metabuffer
