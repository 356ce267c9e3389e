#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "formats/viewport_table.h"

namespace metabuffer {

/// The first scanline of every frame. It is never displayed, and carries the viewport table and whatever else the host
/// wants to send (section 4 of the paper). Its pixels' bytes, in the order R, G, B, hold a little-endian record: magic,
/// version, kind, row count, frame number, CRC-32, the rows, and a payload.
enum class FrameKind : std::uint8_t { kColour = 0, kDepth = 1 };

struct ControlScanline {
    FrameKind kind = FrameKind::kColour;
    std::uint32_t frame_number = 0;
    ViewportTable table;
    std::vector<std::uint8_t> payload;
};

/// Why a control scanline is rejected, in the order of the checks. A row count or payload length that exceeds the
/// scanline makes it impossible to check the CRC and counts as kCrc. kKind is reported only for a scanline whose CRC is
/// right.
enum class ScanlineDefect : std::uint8_t { kNone, kMagic, kVersion, kCrc, kKind };

struct DecodedScanline {
    ScanlineDefect defect = ScanlineDefect::kNone;
    ControlScanline content;  ///< meaningful when defect is kNone
};

constexpr std::uint8_t kControlScanlineVersion = 1;
constexpr std::int64_t kLargestFrameNumber = 0xFFFF'FFFF;  ///< after it comes 0
constexpr int kControlHeaderBytes = 16;
constexpr int kControlRowBytes = 16;
constexpr int kControlPayloadLengthBytes = 2;
constexpr int kLinkBytesPerPixel = 3;
constexpr int kControlMagicOffset = 0;
constexpr int kControlVersionOffset = 4;
constexpr int kControlKindOffset = 5;
constexpr int kControlRowCountOffset = 6;
constexpr int kControlCrcOffset = 12;

/// The host's error: the content does not fit the scanline or its 16-bit counts.
class ScanlineOverflow : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Bytes that the content takes in the scanline.
std::size_t control_scanline_bytes(const ControlScanline& content);

/// Bytes of payload that fit into a scanline of so many pixels with an empty table; 0 if it is too narrow.
std::size_t payload_room_bytes(int width_pixels);

/// The scanline as link pixels (0xRRGGBB), zero after the content. Throws ScanlineOverflow with a message that names
/// the bytes needed and the bytes there are.
std::vector<std::uint32_t> encode_control_scanline(const ControlScanline& content, int width_pixels);

/// Raises nothing: the result says what is wrong.
DecodedScanline decode_control_scanline(const std::vector<std::uint32_t>& link_pixels);

/// The control scanlines of a pair as they are sent, and what a decoder reads from them.
struct SentControls {
    std::vector<std::uint32_t> colour;  ///< link pixels
    std::vector<std::uint32_t> depth;
    std::optional<std::uint32_t> number;  ///< of the pair; none if a decoder takes the two for no pair
    ViewportTable table;                  ///< of the colour frame, empty if there is none
    std::vector<std::uint8_t> payload;    ///< of the depth frame
};

SentControls sent_controls(std::vector<std::uint32_t> colour, std::vector<std::uint32_t> depth);

/// A scanline's bytes as hexadecimal digits, without the zeros after the last other one; and back, for a scanline of so
/// many pixels. None if the text is no such digits or has more bytes than the scanline.
std::string hex_of_scanline(const std::vector<std::uint32_t>& link_pixels);
std::optional<std::vector<std::uint32_t>> scanline_of_hex(const std::string& digits, int width_pixels);

}  // namespace metabuffer
