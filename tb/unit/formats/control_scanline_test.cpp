#include "formats/control_scanline.h"

#include <catch2/catch.hpp>
#include <string>
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

TEST_CASE("control scanline: the reference CRC of this test is the IEEE one") {
    CHECK(bitwise_crc32({'1', '2', '3', '4', '5', '6', '7', '8', '9'}) == 0xCBF43926);
}

TEST_CASE("control scanline: every field is encoded at its own bytes, little-endian, R first") {
    CHECK(control_scanline_bytes(sample()) == kSampleBytes);
    CHECK(link_bytes(encode_control_scanline(sample(), kSampleWidth)) == sample_bytes());
    CHECK(encode_control_scanline(sample(), kSampleWidth)[0] == 0x4D4255);  // "MBU" as R, G, B
}

TEST_CASE("control scanline: hand-built bytes are decoded field by field, negative positions included") {
    const DecodedScanline decoded = decode_control_scanline(link_pixels(sample_bytes()));
    REQUIRE(decoded.defect == ScanlineDefect::kNone);
    check_same(decoded.content, sample());
    CHECK(decoded.content.table[0].dx == -2);
    CHECK(decoded.content.table[0].dy == -32768);
}

TEST_CASE("control scanline: the kind distinguishes colour and depth frames") {
    ControlScanline content = sample();
    for (const FrameKind kind : {FrameKind::kColour, FrameKind::kDepth}) {
        content.kind = kind;
        const auto pixels = encode_control_scanline(content, kSampleWidth);
        CHECK(link_bytes(pixels)[5] == (kind == FrameKind::kColour ? 0 : 1));
        CHECK(decode_control_scanline(pixels).content.kind == kind);
    }
}

TEST_CASE("control scanline: no rows and no payload still make a whole scanline") {
    const ControlScanline content;
    CHECK(control_scanline_bytes(content) == 18);
    const auto pixels = encode_control_scanline(content, 6);
    Bytes wanted = {'M', 'B', 'U', 'F', 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    seal(wanted, wanted.size());
    CHECK(link_bytes(pixels) == wanted);
    const DecodedScanline decoded = decode_control_scanline(pixels);
    REQUIRE(decoded.defect == ScanlineDefect::kNone);
    check_same(decoded.content, content);
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

TEST_CASE("control scanline: any wrong byte of the content is reported, by its first cause") {
    const Bytes good = sample_bytes();
    for (std::size_t position = 0; position < kSampleBytes; ++position) {
        const ScanlineDefect wanted = position < 4    ? ScanlineDefect::kMagic
                                      : position == 4 ? ScanlineDefect::kVersion
                                                      : ScanlineDefect::kCrc;
        for (int difference = 1; difference < 256; ++difference) {
            Bytes bad = good;
            bad[position] = static_cast<std::uint8_t>(bad[position] ^ difference);
            INFO("byte " << position << " xor " << difference);
            REQUIRE(defect_of(bad) == wanted);
        }
    }
}

TEST_CASE("control scanline: what lies behind the content is not judged") {
    for (std::size_t position = kSampleBytes; position < kSampleScanlineBytes; ++position) {
        Bytes bytes = sample_bytes();
        bytes[position] = 0xFF;
        const DecodedScanline decoded = decode_control_scanline(link_pixels(bytes));
        REQUIRE(decoded.defect == ScanlineDefect::kNone);
        check_same(decoded.content, sample());
    }
}

TEST_CASE("control scanline: the link has 24 bits and what stands above them is ignored") {
    auto pixels = link_pixels(sample_bytes());
    for (std::uint32_t& pixel : pixels) pixel |= 0xA5000000;
    const DecodedScanline decoded = decode_control_scanline(pixels);
    REQUIRE(decoded.defect == ScanlineDefect::kNone);
    check_same(decoded.content, sample());
}

TEST_CASE("control scanline: a wrong magic is reported even if the CRC is correct") {
    for (std::size_t position = 0; position < 4; ++position) {
        Bytes bytes = sample_bytes();
        bytes[position] ^= 0x20;
        seal(bytes, kSampleBytes);
        CHECK(defect_of(bytes) == ScanlineDefect::kMagic);
    }
}

TEST_CASE("control scanline: every version but 1 is unknown even if the CRC is correct") {
    for (int version = 0; version < 256; ++version) {
        Bytes bytes = sample_bytes();
        bytes[4] = static_cast<std::uint8_t>(version);
        seal(bytes, kSampleBytes);
        INFO("version " << version);
        CHECK(defect_of(bytes) == (version == 1 ? ScanlineDefect::kNone : ScanlineDefect::kVersion));
    }
}

TEST_CASE("control scanline: an unknown kind is reported for a scanline whose CRC is correct") {
    for (int kind = 2; kind < 256; ++kind) {
        Bytes bytes = sample_bytes();
        bytes[5] = static_cast<std::uint8_t>(kind);
        INFO("kind " << kind);
        CHECK(defect_of(bytes) == ScanlineDefect::kCrc);
        seal(bytes, kSampleBytes);
        CHECK(defect_of(bytes) == ScanlineDefect::kKind);
    }
}

TEST_CASE("control scanline: defects are reported in the order magic, version, CRC, kind") {
    Bytes bytes = sample_bytes();
    bytes[5] = 9;
    CHECK(defect_of(bytes) == ScanlineDefect::kCrc);
    bytes[4] = 9;
    CHECK(defect_of(bytes) == ScanlineDefect::kVersion);
    bytes[0] = 9;
    CHECK(defect_of(bytes) == ScanlineDefect::kMagic);
}

TEST_CASE("control scanline: a row count that goes beyond the scanline counts as a CRC error") {
    // 57 bytes hold two rows and the payload's length, not three.
    for (const int rows : {3, 4, 255, 256, 65535}) {
        Bytes bytes = sample_bytes();
        bytes[6] = static_cast<std::uint8_t>(rows % 256);
        bytes[7] = static_cast<std::uint8_t>(rows / 256);
        seal(bytes, bytes.size());  // a decoder that clamped the count to the scanline would accept it
        INFO(rows << " rows");
        CHECK(defect_of(bytes) == ScanlineDefect::kCrc);
    }
}

TEST_CASE("control scanline: rows that end with the scanline leave no room for the payload's length") {
    Bytes bytes(16 + 2 * 16, 0);
    const Bytes header = {'M', 'B', 'U', 'F', 1, 0, 2, 0};
    std::copy(header.begin(), header.end(), bytes.begin());
    seal(bytes, bytes.size());
    CHECK(defect_of(bytes) == ScanlineDefect::kCrc);
}

TEST_CASE("control scanline: a payload length that goes beyond the scanline counts as a CRC error") {
    // Payload lengths up to 57 - 50 = 7 stay inside.
    for (const int length : {7, 8, 255, 65535}) {
        Bytes bytes = sample_bytes();
        bytes[48] = static_cast<std::uint8_t>(length % 256);
        bytes[49] = static_cast<std::uint8_t>(length / 256);
        seal(bytes, bytes.size());
        INFO(length << " bytes");
        CHECK(defect_of(bytes) == (length == 7 ? ScanlineDefect::kNone : ScanlineDefect::kCrc));
    }
}

TEST_CASE("control scanline: a payload one byte beyond the scanline is refused whatever lies there") {
    Bytes bytes = sample_bytes();
    bytes[48] = 8;
    for (int beyond = 0; beyond < 256; ++beyond) {
        // One of these CRCs would be correct for a decoder that read on behind the scanline.
        Bytes longer = bytes;
        longer.push_back(static_cast<std::uint8_t>(beyond));
        seal(longer, longer.size());
        longer.pop_back();
        INFO("byte " << beyond);
        CHECK(defect_of(longer) == ScanlineDefect::kCrc);
    }
}

TEST_CASE("control scanline: a scanline too short for its own header is reported, not read past its end") {
    const Bytes good = sample_bytes();
    const auto start = [&good](std::ptrdiff_t bytes) { return Bytes(good.begin(), good.begin() + bytes); };
    CHECK(defect_of({}) == ScanlineDefect::kMagic);
    CHECK(defect_of(start(3)) == ScanlineDefect::kMagic);
    CHECK(defect_of(start(6)) == ScanlineDefect::kCrc);
    CHECK(defect_of(start(12)) == ScanlineDefect::kCrc);
    CHECK(defect_of(start(15)) == ScanlineDefect::kCrc);
    CHECK(defect_of(start(18)) == ScanlineDefect::kCrc);
    CHECK(defect_of(start(51)) == ScanlineDefect::kCrc);
    CHECK(defect_of(start(54)) == ScanlineDefect::kNone);
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

TEST_CASE("control scanline: content that just fits is sent and one byte more is the host's error") {
    // Five rows: 16 + 80 + 2 = 98 bytes, and one byte of payload fills 33 pixels.
    ControlScanline content;
    content.table.resize(5);
    content.payload = {1};
    REQUIRE(control_scanline_bytes(content) == 99);
    CHECK(decode_control_scanline(encode_control_scanline(content, 33)).defect == ScanlineDefect::kNone);
    CHECK_THROWS_AS(encode_control_scanline(content, 32), ScanlineOverflow);
    content.payload = {1, 2};
    CHECK_THROWS_AS(encode_control_scanline(content, 33), ScanlineOverflow);
    CHECK_THROWS_AS(encode_control_scanline(content, 0), ScanlineOverflow);
    CHECK_THROWS_AS(encode_control_scanline(content, -1), ScanlineOverflow);
}

TEST_CASE("control scanline: one row too many is named with the bytes needed and the bytes there are") {
    ControlScanline content;
    content.table.resize(13);  // 16 + 13 * 16 + 2 = 226 bytes; 75 pixels have 225
    CHECK_THROWS_WITH(encode_control_scanline(content, 75), Catch::Contains("226") && Catch::Contains("225"));
    content.table.resize(12);
    CHECK_NOTHROW(encode_control_scanline(content, 75));
}

TEST_CASE("control scanline: counts that their 16 bits cannot hold are the host's error") {
    const int wide = 500000;
    ControlScanline content;
    content.table.resize(65536);
    CHECK_THROWS_AS(encode_control_scanline(content, wide), ScanlineOverflow);
    content.table.resize(65535);
    CHECK(decode_control_scanline(encode_control_scanline(content, wide)).content.table.size() == 65535);
    content.table.clear();
    content.payload.resize(65536);
    CHECK_THROWS_AS(encode_control_scanline(content, wide), ScanlineOverflow);
    content.payload.resize(65535);
    CHECK(decode_control_scanline(encode_control_scanline(content, wide)).content.payload.size() == 65535);
}

TEST_CASE("control scanline: a payload and rows share what an image's width leaves of the line") {
    CHECK(payload_room_bytes(1) == 0);
    for (const int width : {8, 16, 100}) {
        const std::size_t room = payload_room_bytes(width);
        ControlScanline content;
        content.payload.resize(room);
        CHECK(encode_control_scanline(content, width).size() == static_cast<std::size_t>(width));
        content.payload.resize(room + 1);
        CHECK_THROWS_AS(encode_control_scanline(content, width), ScanlineOverflow);
    }
}

}  // namespace
}  // namespace metabuffer
