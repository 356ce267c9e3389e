// libFuzzer: whatever a link brings instead of a control scanline is decoded or rejected, never misread. Whatever table
// it holds is split into valid rows and dropped rows. scripts/fuzz runs it.

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "expectations.h"
#include "formats/control_scanline.h"
#include "formats/viewport_table.h"

namespace {

using namespace metabuffer;
using Bytes = std::vector<std::uint8_t>;

std::size_t u16_at(const Bytes& bytes, std::size_t offset) {
    return bytes[offset] | static_cast<std::size_t>(bytes[offset + 1]) << 8;
}

/// Makes magic, version and CRC of the bytes right: no mutation would get there by chance. Returns false if the counts
/// lead beyond the scanline.
bool made_plausible(Bytes& bytes) {
    constexpr std::uint8_t kMagic[] = {'M', 'B', 'U', 'F'};
    if (bytes.size() < kControlHeaderBytes) return false;
    std::copy(std::begin(kMagic), std::end(kMagic), bytes.begin());
    bytes[4] = kControlScanlineVersion;
    const std::size_t payload_length = kControlHeaderBytes + u16_at(bytes, 6) * kControlRowBytes;
    if (payload_length + kControlPayloadLengthBytes > bytes.size()) return false;
    const std::size_t end = payload_length + kControlPayloadLengthBytes + u16_at(bytes, payload_length);
    if (end > bytes.size()) return false;
    uLong crc = crc32(0, bytes.data(), kControlCrcOffset);
    crc = crc32(crc, bytes.data() + kControlHeaderBytes, static_cast<uInt>(end - kControlHeaderBytes));
    for (int i = 0; i < 4; ++i)
        bytes[static_cast<std::size_t>(kControlCrcOffset + i)] = static_cast<std::uint8_t>(crc >> (8 * i));
    // The rest of a scanline is zero; a decoder need not check it.
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(end), bytes.end(), std::uint8_t{0});
    return true;
}

std::vector<std::uint32_t> link_pixels_of(const Bytes& bytes) {
    std::vector<std::uint32_t> pixels;
    for (std::size_t i = 0; i + kLinkBytesPerPixel <= bytes.size(); i += kLinkBytesPerPixel) {
        pixels.push_back(static_cast<std::uint32_t>(bytes[i]) << 16 |
                         static_cast<std::uint32_t>(bytes[i + 1]) << 8 | bytes[i + 2]);
    }
    return pixels;
}

void check_table(const ViewportTable& table, const ViewportLimits& limits) {
    const ValidatedTable validated = validate_table(table, limits);
    EXPECT(validated.rows.size() + validated.rejected.size() == table.size());
    for (std::size_t i = 0; i < validated.rows.size(); ++i) {
        EXPECT(row_defect(validated.rows[i], limits) == RowDefect::kNone);
        for (std::size_t j = 0; j < i; ++j) EXPECT(validated.rows[i].dcomp != validated.rows[j].dcomp);
    }
    for (const RejectedRow& row : validated.rejected) {
        EXPECT(row.defect != RowDefect::kNone);
        EXPECT(!row.message.empty() && row.message.find('\n') == std::string::npos);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::size_t kLimitBytes = 4;
    if (size < kLimitBytes) return 0;
    ViewportLimits limits;
    limits.displays = data[0] % 9 + 1;
    limits.image_width_pixels = limits.image_height_pixels = data[1] * 8 + 1;
    limits.raster_width_pixels = limits.raster_height_pixels = data[2] * 8 + 1;
    limits.buffer_pixels = data[3] * 4 + 1;
    limits.ready_space_pixels = std::min(limits.buffer_pixels, 32);

    Bytes bytes(data + kLimitBytes, data + size);
    bytes.resize(bytes.size() / kLinkBytesPerPixel * kLinkBytesPerPixel);  // a link carries whole pixels
    const DecodedScanline raw = decode_control_scanline(link_pixels_of(bytes));
    if (raw.defect == ScanlineDefect::kNone) check_table(raw.content.table, limits);

    const bool plausible = made_plausible(bytes);
    const std::vector<std::uint32_t> pixels = link_pixels_of(bytes);
    const DecodedScanline decoded = decode_control_scanline(pixels);
    if (!plausible) {
        EXPECT(decoded.defect != ScanlineDefect::kNone);
        return 0;
    }
    if (decoded.defect != ScanlineDefect::kNone) {
        EXPECT(decoded.defect == ScanlineDefect::kKind);
        return 0;
    }
    check_table(decoded.content.table, limits);
    EXPECT(encode_control_scanline(decoded.content, static_cast<int>(pixels.size())) == pixels);
    return 0;
}
