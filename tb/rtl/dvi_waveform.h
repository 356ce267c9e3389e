#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/control_scanline.h"
#include "formats/depth_format.h"
#include "formats/image.h"
#include "rtl/signals.h"

/// DVI waveforms made in the simplest way, to drive a link and to check one. The blanking is written out here and not
/// copied from the model.
namespace metabuffer::test {

constexpr int kFrontPixels = 8;
constexpr int kSyncPixels = 32;
constexpr int kBackPixels = 40;
constexpr int kFrontLines = 1;
constexpr int kSyncLines = 8;
constexpr int kBackLines = 6;

using Waveform = std::vector<rtl::DviLink>;
using LinkLines = std::vector<std::vector<std::uint32_t>>;

constexpr int line_clocks(int active_pixels) {
    return active_pixels + kFrontPixels + kSyncPixels + kBackPixels;
}
constexpr int frame_clocks(int active_pixels, int active_lines) {
    return line_clocks(active_pixels) * (kBackLines + active_lines + kFrontLines + kSyncLines);
}

/// One line of a mode of `active_pixels`; data may be shorter or longer than that, or empty.
inline void append_line(Waveform& wave, int active_pixels, const std::vector<std::uint32_t>& data,
                        bool vsync) {
    for (int x = 0; x < line_clocks(active_pixels); ++x) {
        rtl::DviLink link;
        const auto index = static_cast<std::size_t>(x);
        link.de = index < data.size();
        link.data = link.de ? data[index] : 0;
        link.hsync = x >= active_pixels + kFrontPixels && x < active_pixels + kFrontPixels + kSyncPixels;
        link.vsync = vsync;
        wave.push_back(link);
    }
}

inline void append_blank_lines(Waveform& wave, int active_pixels, int lines, bool vsync) {
    for (int line = 0; line < lines; ++line) append_line(wave, active_pixels, {}, vsync);
}

/// A frame: back porch, the active lines, front porch, vertical sync.
inline void append_frame(Waveform& wave, int active_pixels, const LinkLines& lines) {
    append_blank_lines(wave, active_pixels, kBackLines, false);
    for (const auto& line : lines) append_line(wave, active_pixels, line, false);
    append_blank_lines(wave, active_pixels, kFrontLines, false);
    append_blank_lines(wave, active_pixels, kSyncLines, true);
}

/// Where in a frame's waveform an active pixel lies.
constexpr int clock_in_frame(int active_pixels, int x, int active_line) {
    return (kBackLines + active_line) * line_clocks(active_pixels) + x;
}
/// Where in a frame's waveform VSYNC rises.
constexpr int vsync_in_frame(int active_pixels, int active_lines) {
    return (kBackLines + active_lines + kFrontLines) * line_clocks(active_pixels);
}

/// What a frame of a renderer's link shows below its control scanline: R G B, or A and a 16-bit Z, or a Z of 24 bits.
inline LinkLines image_lines(const PixelImage& image, FrameKind kind,
                             DepthFormat format = DepthFormat::kA8Z16) {
    LinkLines lines;
    for (int y = 0; y < image.height_pixels; ++y) {
        lines.emplace_back();
        for (int x = 0; x < image.width_pixels; ++x) {
            const Pixel pixel = image.at(x, y);
            const std::uint32_t colour =
                (std::uint32_t{pixel.r()} << 16) | (std::uint32_t{pixel.g()} << 8) | pixel.b();
            const std::uint32_t depth = format == DepthFormat::kZ24
                                            ? pixel.z()
                                            : (std::uint32_t{pixel.a()} << 16) | (pixel.z() & 0xFFFFU);
            lines.back().push_back(kind == FrameKind::kColour ? colour : depth);
        }
    }
    return lines;
}

/// The control scanline as the host writes it: the record of docs/design.md, bit by bit.
inline std::vector<std::uint32_t> control_line(int width, FrameKind kind, std::uint32_t number,
                                               const ViewportTable& table = {},
                                               const std::vector<std::uint8_t>& payload = {}) {
    using Bytes = std::vector<std::uint8_t>;
    const auto put = [](Bytes& bytes, std::size_t value, int count) {
        for (; count > 0; --count, value >>= 8) bytes.push_back(static_cast<std::uint8_t>(value));
    };
    Bytes record{'M', 'B', 'U', 'F', 1};
    put(record, static_cast<std::size_t>(kind), 1);
    put(record, table.size(), 2);
    put(record, number, 4);
    Bytes behind_crc;
    for (const ViewportRow& row : table) {
        for (const int value : {int{row.dcomp}, int{row.sx}, int{row.sy}, int{row.sdx}, int{row.sdy},
                                int{row.dx}, int{row.dy}, int{row.dmultiple}}) {
            put(behind_crc, static_cast<std::uint16_t>(value), 2);
        }
    }
    put(behind_crc, payload.size(), 2);
    behind_crc.insert(behind_crc.end(), payload.begin(), payload.end());

    std::uint32_t crc = 0xFFFF'FFFFU;
    for (const Bytes* const bytes : {&record, &behind_crc}) {
        for (const std::uint8_t byte : *bytes) {
            crc ^= byte;
            for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1U) != 0 ? 0xEDB8'8320U : 0U);
        }
    }
    put(record, ~crc, 4);
    record.insert(record.end(), behind_crc.begin(), behind_crc.end());

    std::vector<std::uint32_t> pixels(static_cast<std::size_t>(width));
    for (std::size_t i = 0; i < record.size(); ++i) {
        pixels.at(i / 3) |= std::uint32_t{record[i]} << (16 - 8 * (i % 3));
    }
    return pixels;
}

/// A renderer's frame: control scanline and image.
inline LinkLines renderer_lines(const PixelImage& image, FrameKind kind, std::uint32_t number,
                                const ViewportTable& table = {},
                                const std::vector<std::uint8_t>& payload = {}) {
    LinkLines lines = image_lines(image, kind);
    lines.insert(lines.begin(), control_line(image.width_pixels, kind, number, table, payload));
    return lines;
}

}  // namespace metabuffer::test
