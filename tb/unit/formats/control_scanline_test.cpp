#include "formats/control_scanline.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/random_seed.h"

namespace metabuffer {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// CRC-32 as the standard defines it, one bit after the other.
std::uint32_t bitwise_crc32(const Bytes& bytes) {
    std::uint32_t remainder = 0xFFFFFFFF;
    for (const std::uint8_t byte : bytes) {
        for (int bit = 0; bit < 8; ++bit) {
            const bool feedback = ((remainder ^ (std::uint32_t{byte} >> bit)) & 1U) != 0;
            remainder >>= 1;
            if (feedback) remainder ^= 0xEDB88320;
        }
    }
    return ~remainder;
}

/// Bytes to link pixels, R first in the highest byte.
std::vector<std::uint32_t> link_pixels(const Bytes& bytes) {
    REQUIRE(bytes.size() % 3 == 0);
    std::vector<std::uint32_t> pixels;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        pixels.push_back(bytes[i] * 0x10000U + bytes[i + 1] * 0x100U + bytes[i + 2]);
    }
    return pixels;
}

Bytes link_bytes(const std::vector<std::uint32_t>& pixels) {
    Bytes bytes;
    for (const std::uint32_t pixel : pixels) {
        REQUIRE(pixel <= 0xFFFFFF);
        bytes.push_back(static_cast<std::uint8_t>(pixel / 0x10000));
        bytes.push_back(static_cast<std::uint8_t>(pixel / 0x100 % 0x100));
        bytes.push_back(static_cast<std::uint8_t>(pixel % 0x100));
    }
    return bytes;
}

/// Sets bytes 12 to 15 to the CRC of bytes 0 to 11 and of those from 16 to the content's end.
void seal(Bytes& bytes, std::size_t content_bytes) {
    Bytes covered(bytes.begin(), bytes.begin() + 12);
    covered.insert(covered.end(), bytes.begin() + 16,
                   bytes.begin() + static_cast<std::ptrdiff_t>(content_bytes));
    std::uint32_t crc = bitwise_crc32(covered);
    for (std::size_t i = 12; i < 16; ++i, crc /= 256) bytes[i] = static_cast<std::uint8_t>(crc % 256);
}

/// Two rows and a payload of three bytes: 53 bytes of content in a scanline of 19 pixels.
constexpr std::size_t kSampleBytes = 16 + 2 * 16 + 2 + 3;
constexpr int kSampleWidth = 19;
constexpr std::size_t kSampleScanlineBytes = 57;

ControlScanline sample() {
    ControlScanline content;
    content.kind = FrameKind::kDepth;
    content.frame_number = 0xA1B2C3D4;
    content.table = {{0x0102, 0x0304, 0x0506, 0x0708, 0x090A, -2, -32768, 0x0B0C},
                     {2, 75, 0, 25, 75, 32767, 256, 255}};
    content.payload = {0xDE, 0xAD, 0x99};
    return content;
}

Bytes sample_bytes() {
    Bytes bytes = {'M',  'B',  'U',  'F',  1,    1,    2,    0,         // header
                   0xD4, 0xC3, 0xB2, 0xA1, 0,    0,    0,    0,         // number, CRC
                   0x02, 0x01, 0x04, 0x03, 0x06, 0x05, 0x08, 0x07,      // row 0
                   0x0A, 0x09, 0xFE, 0xFF, 0x00, 0x80, 0x0C, 0x0B,      //
                   2,    0,    75,   0,    0,    0,    25,   0,         // row 1
                   75,   0,    0xFF, 0x7F, 0x00, 0x01, 0xFF, 0,         //
                   3,    0,    0xDE, 0xAD, 0x99, 0,    0,    0,    0};  // payload, rest
    REQUIRE(bytes.size() == kSampleScanlineBytes);
    seal(bytes, kSampleBytes);
    return bytes;
}

void check_same(const ControlScanline& left, const ControlScanline& right) {
    CHECK(left.kind == right.kind);
    CHECK(left.frame_number == right.frame_number);
    CHECK((left.table == right.table));
    CHECK(left.payload == right.payload);
}

ControlScanline random_content(test::Random& random, int most_rows, int most_payload) {
    const auto u16 = [&random] { return static_cast<std::uint16_t>(random.between(0, 65535)); };
    const auto s16 = [&random] { return static_cast<std::int16_t>(random.between(-32768, 32767)); };
    ControlScanline content;
    content.kind = random.one_in(2) ? FrameKind::kColour : FrameKind::kDepth;
    content.frame_number = static_cast<std::uint32_t>(random.bits());
    for (int rows = random.between(0, most_rows); rows > 0; --rows) {
        content.table.push_back({u16(), u16(), u16(), u16(), u16(), s16(), s16(), u16()});
    }
    for (int bytes = random.between(0, most_payload); bytes > 0; --bytes) {
        content.payload.push_back(static_cast<std::uint8_t>(random.between(0, 255)));
    }
    return content;
}

ScanlineDefect defect_of(const Bytes& bytes) { return decode_control_scanline(link_pixels(bytes)).defect; }

/// Where the content ends by its own counts; nothing if that is beyond the scanline.
std::optional<std::size_t> content_end(const Bytes& bytes) {
    if (bytes.size() < 18) return std::nullopt;
    const std::size_t payload = 16 + 16 * (bytes[6] + 256U * bytes[7]);
    if (bytes.size() < payload + 2) return std::nullopt;
    const std::size_t end = payload + 2 + bytes[payload] + 256U * bytes[payload + 1];
    return end <= bytes.size() ? std::optional(end) : std::nullopt;
}

/// The first rule of docs/design.md that these bytes break.
ScanlineDefect judged(const Bytes& bytes) {
    const Bytes magic = {'M', 'B', 'U', 'F'};
    if (bytes.size() < 4 || !std::equal(magic.begin(), magic.end(), bytes.begin()))
        return ScanlineDefect::kMagic;
    if (bytes[4] != 1) return ScanlineDefect::kVersion;
    const std::optional<std::size_t> end = content_end(bytes);
    if (!end) return ScanlineDefect::kCrc;
    Bytes sealed = bytes;
    seal(sealed, *end);
    if (sealed != bytes) return ScanlineDefect::kCrc;
    return bytes[5] < 2 ? ScanlineDefect::kNone : ScanlineDefect::kKind;
}

TEST_CASE("control scanline: every field has its own bytes, little-endian, R first, at both ends of a link") {
    // The reference CRC of this test is the IEEE one.
    CHECK(bitwise_crc32({'1', '2', '3', '4', '5', '6', '7', '8', '9'}) == 0xCBF43926);
    ControlScanline content = sample();
    CHECK(control_scanline_bytes(content) == kSampleBytes);
    CHECK(link_bytes(encode_control_scanline(content, kSampleWidth)) == sample_bytes());
    auto pixels = link_pixels(sample_bytes());
    CHECK(pixels[0] == 0x4D4255);  // "MBU" as R, G, B
    for (std::uint32_t& pixel : pixels)
        pixel |= 0xA5000000;  // what stands above the link's 24 bits is ignored
    const DecodedScanline decoded = decode_control_scanline(pixels);
    CHECK(decoded.defect == ScanlineDefect::kNone);
    check_same(decoded.content, sample());

    content.kind = FrameKind::kColour;
    CHECK(link_bytes(encode_control_scanline(content, kSampleWidth))[5] == 0);
    content = ControlScanline();
    CHECK(control_scanline_bytes(content) == 18);
    Bytes wanted = {'M', 'B', 'U', 'F', 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    seal(wanted, wanted.size());
    CHECK(link_bytes(encode_control_scanline(content, 6)) == wanted);
    check_same(decode_control_scanline(link_pixels(wanted)).content, content);
}

TEST_CASE("control scanline: random content survives the link, zero behind it") {
    const auto seed = test::random_seed(110);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 500; ++trial) {
        const ControlScanline content = random_content(random, 20, 100);
        const std::size_t bytes = 16 + content.table.size() * 16 + 2 + content.payload.size();
        const int least_width = static_cast<int>((bytes + 2) / 3);
        const int width = least_width + (random.one_in(2) ? 0 : random.between(0, 50));
        INFO("trial " << trial << ", width " << width);
        REQUIRE(control_scanline_bytes(content) == bytes);
        const auto pixels = encode_control_scanline(content, width);
        REQUIRE(pixels.size() == static_cast<std::size_t>(width));
        const Bytes sent = link_bytes(pixels);
        for (std::size_t i = bytes; i < sent.size(); ++i) REQUIRE(sent[i] == 0);
        const DecodedScanline decoded = decode_control_scanline(pixels);
        REQUIRE(decoded.defect == ScanlineDefect::kNone);
        check_same(decoded.content, content);
    }
}

TEST_CASE("control scanline: whatever single byte is wrong, the first rule that it breaks is reported") {
    int seen[5] = {};
    for (const bool sealed : {false, true}) {
        for (std::size_t position = 0; position < kSampleScanlineBytes; ++position) {
            for (int difference = 1; difference < 256; ++difference) {
                Bytes bytes = sample_bytes();
                bytes[position] = static_cast<std::uint8_t>(bytes[position] ^ difference);
                // Where a count is too large: as for a decoder that cut it to what there is.
                if (sealed) seal(bytes, content_end(bytes).value_or(bytes.size()));
                INFO("byte " << position << " xor " << difference << ", sealed: " << sealed);
                const DecodedScanline decoded = decode_control_scanline(link_pixels(bytes));
                REQUIRE(decoded.defect == judged(bytes));
                ++seen[static_cast<int>(decoded.defect)];
                // Behind the content nothing is judged.
                if (position >= kSampleBytes) check_same(decoded.content, sample());
            }
        }
    }
    for (const int count : seen) CHECK(count > 200);
}

TEST_CASE("control scanline: several wrong bytes, counts up to the end, and too short a scanline") {
    Bytes bytes = sample_bytes();
    for (const auto& [position, wanted] :
         {std::pair{5, ScanlineDefect::kCrc}, {4, ScanlineDefect::kVersion}, {0, ScanlineDefect::kMagic}}) {
        bytes[static_cast<std::size_t>(position)] = 9;
        CHECK(defect_of(bytes) == wanted);
    }
    const Bytes good = sample_bytes();
    for (std::ptrdiff_t length = 0; length <= static_cast<std::ptrdiff_t>(good.size()); length += 3) {
        bytes = Bytes(good.begin(), good.begin() + length);
        INFO(length << " bytes");
        CHECK(defect_of(bytes) == judged(bytes));
    }
    // Rows that end with the scanline leave no room for the payload's length.
    bytes.assign(16 + 2 * 16, 0);
    const Bytes header = {'M', 'B', 'U', 'F', 1, 0, 2, 0};
    std::copy(header.begin(), header.end(), bytes.begin());
    seal(bytes, bytes.size());
    CHECK(defect_of(bytes) == ScanlineDefect::kCrc);
    // One of these CRCs would be right for a decoder that read a byte beyond the scanline.
    for (int beyond = 0; beyond < 256; ++beyond) {
        bytes = good;
        bytes[48] = 8;
        bytes.push_back(static_cast<std::uint8_t>(beyond));
        seal(bytes, bytes.size());
        bytes.pop_back();
        CHECK(defect_of(bytes) == ScanlineDefect::kCrc);
    }
}

TEST_CASE("control scanline: random link data is never accepted as a control scanline") {
    const auto seed = test::random_seed(111);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    const Bytes good = sample_bytes();
    for (int trial = 0; trial < 20000; ++trial) {
        Bytes bytes(static_cast<std::size_t>(3 * random.between(0, 30)));
        for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.between(0, 255));
        // Most have the right magic and version, to reach the code that reads counts and lengths. Small counts stay
        // inside.
        for (std::size_t i = 0; i < bytes.size() && i < 5; ++i) bytes[i] = good[i];
        if (bytes.size() > 7) bytes[6] = static_cast<std::uint8_t>(random.between(0, 5));
        if (bytes.size() > 7 && !random.one_in(4)) bytes[7] = 0;
        REQUIRE(defect_of(bytes) != ScanlineDefect::kNone);
    }
}

TEST_CASE("control scanline: content that just fits is sent, and more than that is the host's error") {
    struct Case {
        std::size_t rows, payload;
        int width;
        const char* error;  ///< nothing: it fits
    };
    const int wide = 500'000;
    // Five rows: 16 + 80 + 2 = 98 bytes, and one byte of payload fills 33 pixels; 16 + 13 * 16 + 2 = 226.
    for (const Case& one :
         {Case{5, 1, 33, nullptr}, Case{5, 1, 32, ""}, Case{5, 2, 33, ""}, Case{5, 2, 0, ""},
          Case{5, 2, -1, ""}, Case{12, 0, 75, nullptr}, Case{13, 0, 75, "226 225"}, Case{65536, 0, wide, ""},
          Case{65535, 0, wide, nullptr}, Case{0, 65536, wide, ""}, Case{0, 65535, wide, nullptr}}) {
        INFO(one.rows << " rows, " << one.payload << " bytes, " << one.width << " pixels");
        ControlScanline content;
        content.table.resize(one.rows);
        content.payload.resize(one.payload);
        if (one.error == nullptr) {
            check_same(decode_control_scanline(encode_control_scanline(content, one.width)).content, content);
            continue;
        }
        CHECK_THROWS_AS(encode_control_scanline(content, one.width), ScanlineOverflow);
        // The bytes that are needed and those that there are.
        std::istringstream words(one.error);
        for (std::string word; words >> word;) {
            CHECK_THROWS_WITH(encode_control_scanline(content, one.width), Catch::Contains(word));
        }
    }
    CHECK(payload_room_bytes(1) == 0);
    for (const int width : {8, 16, 100}) {
        ControlScanline content;
        content.payload.resize(payload_room_bytes(width));
        CHECK(encode_control_scanline(content, width).size() == static_cast<std::size_t>(width));
        content.payload.emplace_back();
        CHECK_THROWS_AS(encode_control_scanline(content, width), ScanlineOverflow);
    }
}

}  // namespace
}  // namespace metabuffer
