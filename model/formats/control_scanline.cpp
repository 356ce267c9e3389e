#include "formats/control_scanline.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

namespace metabuffer {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::array<std::uint8_t, 4> kMagic = {'M', 'B', 'U', 'F'};
constexpr std::size_t kVersionOffset = kControlVersionOffset;
constexpr std::size_t kKindOffset = kControlKindOffset;
constexpr std::size_t kRowCountOffset = kControlRowCountOffset;
constexpr std::size_t kFrameNumberOffset = 8;
constexpr std::size_t kCrcOffset = kControlCrcOffset;
constexpr std::size_t kRowsOffset = kControlHeaderBytes;
constexpr std::size_t kRowBytes = kControlRowBytes;
constexpr std::size_t kPayloadLengthBytes = kControlPayloadLengthBytes;
constexpr std::size_t kLinkBytes = kLinkBytesPerPixel;
constexpr std::size_t kMaximumCount = std::numeric_limits<std::uint16_t>::max();

void append_u16(Bytes& bytes, std::uint16_t value) {
    bytes.push_back(static_cast<std::uint8_t>(value & 0xFFU));
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
}

void append_u32(Bytes& bytes, std::uint32_t value) {
    append_u16(bytes, static_cast<std::uint16_t>(value & 0xFFFFU));
    append_u16(bytes, static_cast<std::uint16_t>(value >> 16));
}

std::uint16_t u16_at(const Bytes& bytes, std::size_t offset) {
    return static_cast<std::uint16_t>(bytes[offset] | (std::uint32_t{bytes[offset + 1]} << 8));
}

std::uint32_t u32_at(const Bytes& bytes, std::size_t offset) {
    return u16_at(bytes, offset) | (std::uint32_t{u16_at(bytes, offset + 2)} << 16);
}

/// The CRC skips its own four bytes; `end` is one past the content.
std::uint32_t content_crc(const Bytes& bytes, std::size_t end) {
    uLong crc = crc32(0L, Z_NULL, 0);
    crc = crc32(crc, bytes.data(), static_cast<uInt>(kCrcOffset));
    crc = crc32(crc, bytes.data() + kRowsOffset, static_cast<uInt>(end - kRowsOffset));
    return static_cast<std::uint32_t>(crc);
}

void append_row(Bytes& bytes, const ViewportRow& row) {
    append_u16(bytes, row.dcomp);
    append_u16(bytes, row.sx);
    append_u16(bytes, row.sy);
    append_u16(bytes, row.sdx);
    append_u16(bytes, row.sdy);
    append_u16(bytes, static_cast<std::uint16_t>(row.dx));
    append_u16(bytes, static_cast<std::uint16_t>(row.dy));
    append_u16(bytes, row.dmultiple);
}

ViewportRow row_at(const Bytes& bytes, std::size_t offset) {
    ViewportRow row;
    row.dcomp = u16_at(bytes, offset);
    row.sx = u16_at(bytes, offset + 2);
    row.sy = u16_at(bytes, offset + 4);
    row.sdx = u16_at(bytes, offset + 6);
    row.sdy = u16_at(bytes, offset + 8);
    row.dx = static_cast<std::int16_t>(u16_at(bytes, offset + 10));
    row.dy = static_cast<std::int16_t>(u16_at(bytes, offset + 12));
    row.dmultiple = u16_at(bytes, offset + 14);
    return row;
}

void check_fits(const ControlScanline& content, int width_pixels) {
    const std::size_t needed = control_scanline_bytes(content);
    const std::size_t available = width_pixels > 0 ? static_cast<std::size_t>(width_pixels) * kLinkBytes : 0;
    if (needed > available) {
        throw ScanlineOverflow("the control scanline needs " + std::to_string(needed) + " bytes for " +
                               std::to_string(content.table.size()) + " table rows and a payload of " +
                               std::to_string(content.payload.size()) + " bytes, but has only " +
                               std::to_string(available));
    }
    if (content.table.size() > kMaximumCount || content.payload.size() > kMaximumCount) {
        throw ScanlineOverflow("the control scanline needs " + std::to_string(needed) + " bytes of the " +
                               std::to_string(available) + " there are, but cannot count its " +
                               std::to_string(content.table.size()) + " table rows or its payload of " +
                               std::to_string(content.payload.size()) + " bytes: at most 65535 of each");
    }
}

Bytes content_bytes(const ControlScanline& content) {
    Bytes bytes(kMagic.begin(), kMagic.end());
    bytes.reserve(control_scanline_bytes(content));
    bytes.push_back(kControlScanlineVersion);
    bytes.push_back(static_cast<std::uint8_t>(content.kind));
    append_u16(bytes, static_cast<std::uint16_t>(content.table.size()));
    append_u32(bytes, content.frame_number);
    append_u32(bytes, 0);  // room for the CRC
    for (const ViewportRow& row : content.table) append_row(bytes, row);
    append_u16(bytes, static_cast<std::uint16_t>(content.payload.size()));
    bytes.insert(bytes.end(), content.payload.begin(), content.payload.end());

    Bytes crc;
    append_u32(crc, content_crc(bytes, bytes.size()));
    for (std::size_t i = 0; i < crc.size(); ++i) bytes[kCrcOffset + i] = crc[i];
    return bytes;
}

Bytes bytes_of(const std::vector<std::uint32_t>& link_pixels) {
    Bytes bytes;
    bytes.reserve(link_pixels.size() * kLinkBytes);
    for (const std::uint32_t pixel : link_pixels) {
        bytes.push_back(static_cast<std::uint8_t>((pixel >> 16) & 0xFFU));
        bytes.push_back(static_cast<std::uint8_t>((pixel >> 8) & 0xFFU));
        bytes.push_back(static_cast<std::uint8_t>(pixel & 0xFFU));
    }
    return bytes;
}

/// Zeros after the bytes.
std::vector<std::uint32_t> pixels_of(Bytes bytes, int width_pixels) {
    bytes.resize(static_cast<std::size_t>(width_pixels) * kLinkBytes, 0);
    std::vector<std::uint32_t> link_pixels;
    link_pixels.reserve(static_cast<std::size_t>(width_pixels));
    for (std::size_t i = 0; i < bytes.size(); i += kLinkBytes) {
        link_pixels.push_back((std::uint32_t{bytes[i]} << 16) | (std::uint32_t{bytes[i + 1]} << 8) |
                              bytes[i + 2]);
    }
    return link_pixels;
}

bool has_magic(const Bytes& bytes) {
    if (bytes.size() < kMagic.size()) return false;
    for (std::size_t i = 0; i < kMagic.size(); ++i) {
        if (bytes[i] != kMagic[i]) return false;
    }
    return true;
}

/// One past the content's last byte, or 0 if row count or payload length exceed the scanline.
std::size_t content_end(const Bytes& bytes) {
    if (bytes.size() < kRowsOffset) return 0;
    const std::size_t length_offset = kRowsOffset + u16_at(bytes, kRowCountOffset) * kRowBytes;
    if (length_offset + kPayloadLengthBytes > bytes.size()) return 0;
    const std::size_t end = length_offset + kPayloadLengthBytes + u16_at(bytes, length_offset);
    return end <= bytes.size() ? end : 0;
}

ScanlineDefect scanline_defect(const Bytes& bytes) {
    if (!has_magic(bytes)) return ScanlineDefect::kMagic;
    if (bytes.size() <= kVersionOffset || bytes[kVersionOffset] != kControlScanlineVersion) {
        return ScanlineDefect::kVersion;
    }
    const std::size_t end = content_end(bytes);
    if (end == 0 || content_crc(bytes, end) != u32_at(bytes, kCrcOffset)) return ScanlineDefect::kCrc;
    const bool kind_known = bytes[kKindOffset] == static_cast<std::uint8_t>(FrameKind::kColour) ||
                            bytes[kKindOffset] == static_cast<std::uint8_t>(FrameKind::kDepth);
    return kind_known ? ScanlineDefect::kNone : ScanlineDefect::kKind;
}

ControlScanline parsed_content(const Bytes& bytes) {
    ControlScanline content;
    content.kind = static_cast<FrameKind>(bytes[kKindOffset]);
    content.frame_number = u32_at(bytes, kFrameNumberOffset);
    std::size_t offset = kRowsOffset;
    for (int rows = u16_at(bytes, kRowCountOffset); rows > 0; --rows, offset += kRowBytes) {
        content.table.push_back(row_at(bytes, offset));
    }
    const std::uint16_t payload_bytes = u16_at(bytes, offset);
    const auto payload_begin = bytes.begin() + static_cast<std::ptrdiff_t>(offset + kPayloadLengthBytes);
    content.payload.assign(payload_begin, payload_begin + payload_bytes);
    return content;
}

}  // namespace

std::size_t control_scanline_bytes(const ControlScanline& content) {
    return kRowsOffset + content.table.size() * kRowBytes + kPayloadLengthBytes + content.payload.size();
}

std::size_t payload_room_bytes(int width_pixels) {
    const std::size_t bytes = static_cast<std::size_t>(width_pixels) * kLinkBytes;
    return bytes - std::min(bytes, control_scanline_bytes({}));
}

std::vector<std::uint32_t> encode_control_scanline(const ControlScanline& content, int width_pixels) {
    check_fits(content, width_pixels);
    return pixels_of(content_bytes(content), width_pixels);
}

DecodedScanline decode_control_scanline(const std::vector<std::uint32_t>& link_pixels) {
    const Bytes bytes = bytes_of(link_pixels);
    DecodedScanline decoded;
    decoded.defect = scanline_defect(bytes);
    if (decoded.defect == ScanlineDefect::kNone) decoded.content = parsed_content(bytes);
    return decoded;
}

SentControls sent_controls(std::vector<std::uint32_t> colour, std::vector<std::uint32_t> depth) {
    const DecodedScanline first = decode_control_scanline(colour);
    const DecodedScanline second = decode_control_scanline(depth);
    const bool is_pair = first.defect == ScanlineDefect::kNone && second.defect == ScanlineDefect::kNone &&
                         first.content.kind == FrameKind::kColour &&
                         second.content.kind == FrameKind::kDepth &&
                         first.content.frame_number == second.content.frame_number;
    SentControls controls{std::move(colour), std::move(depth), {}, {}, {}};
    if (is_pair) controls.number = first.content.frame_number;
    if (first.defect == ScanlineDefect::kNone) controls.table = first.content.table;
    if (second.defect == ScanlineDefect::kNone) controls.payload = second.content.payload;
    return controls;
}

std::string hex_of_scanline(const std::vector<std::uint32_t>& link_pixels) {
    Bytes bytes = bytes_of(link_pixels);
    while (!bytes.empty() && bytes.back() == 0) bytes.pop_back();
    std::string digits;
    for (const std::uint8_t byte : bytes) digits += fmt::format("{:02x}", byte);
    return digits;
}

std::optional<std::vector<std::uint32_t>> scanline_of_hex(const std::string& digits, int width_pixels) {
    constexpr int kHexadecimal = 16;
    if (digits.size() % 2 != 0 || digits.size() / 2 > static_cast<std::size_t>(width_pixels) * kLinkBytes) {
        return std::nullopt;
    }
    Bytes bytes(digits.size() / 2);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const char* const begin = digits.data() + 2 * i;
        const auto [stop, error] = std::from_chars(begin, begin + 2, bytes[i], kHexadecimal);
        if (error != std::errc() || stop != begin + 2) return std::nullopt;
    }
    return pixels_of(std::move(bytes), width_pixels);
}

}  // namespace metabuffer
