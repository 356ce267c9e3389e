#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "application/metabuffer_host.h"
#include "datapath/slot_table.h"
#include "formats/control_scanline.h"
#include "formats/depth_format.h"
#include "formats/slot_payload.h"
#include "formats/viewport_splitter.h"
#include "support/random_seed.h"

// The C library of applications against the machine's own formats, which share no line with it.
namespace metabuffer {
namespace {

using test::Random;

metabuffer_row c_row(const ViewportRow& row) {
    return {row.dcomp, row.sx, row.sy, row.sdx, row.sdy, row.dx, row.dy, row.dmultiple};
}

ViewportRow cpp_row(const metabuffer_row& row) {
    return {row.dcomp, row.sx, row.sy, row.sdx, row.sdy, row.dx, row.dy, row.dmultiple};
}

ViewportTable cpp_table(const metabuffer_row* rows, std::size_t count) {
    ViewportTable table;
    for (std::size_t i = 0; i < count; ++i) table.push_back(cpp_row(rows[i]));
    return table;
}

std::vector<metabuffer_row> c_rows(const ViewportTable& table) {
    std::vector<metabuffer_row> rows;
    for (const ViewportRow& row : table) rows.push_back(c_row(row));
    return rows;
}

TEST_CASE("the C library splits a viewport as the machine's host does") {
    const std::uint64_t seed = test::random_seed(1);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    int refused = 0;
    int shown = 0;
    for (int n = 0; n < 20'000; ++n) {
        const DisplayWall wall{random.between(1, 5),
                               random.between(1, 4),
                               random.between(1, 700),
                               random.between(1, 500),
                               random.one_in(2) ? 0 : random.between(0, 50),
                               random.one_in(2) ? 0 : random.between(0, 50)};
        const bool smooths = random.one_in(2);
        const int reach = random.one_in(8) ? 100'000 : 1500;
        const Viewport viewport{random.between(-reach, reach), random.between(-reach, reach),
                                random.one_in(50) ? random.between(-1, 300) : random.between(1, 255)};
        const int width = random.between(1, 800);
        const int height = random.between(1, 600);
        std::optional<ViewportTable> expected;
        try {
            expected = split_viewport(viewport, width, height, wall,
                                      smooths ? Smoothing::kBilinear : Smoothing::kReplicate);
        } catch (const std::invalid_argument&) {
        }
        const metabuffer_viewport at{viewport.x, viewport.y, viewport.multiple};
        const metabuffer_wall on{
            wall.columns,      wall.rows,         wall.raster_width_pixels, wall.raster_height_pixels,
            wall.gap_x_pixels, wall.gap_y_pixels, smooths ? 1 : 0};
        std::array<metabuffer_row, 20> rows{};
        std::size_t count = 0;
        const metabuffer_status status =
            metabuffer_split_viewport(&at, width, height, &on, rows.data(), rows.size(), &count);
        REQUIRE((status == METABUFFER_OK) == expected.has_value());
        if (!expected) {
            const bool bad_multiple = viewport.multiple < 1 || viewport.multiple > kMaximumMultiple;
            REQUIRE(status == (bad_multiple ? METABUFFER_BAD_MULTIPLE : METABUFFER_BAD_POSITION));
            ++refused;
            continue;
        }
        REQUIRE(cpp_table(rows.data(), count) == *expected);
        shown += count > 0 ? 1 : 0;
        if (count > 0) {
            std::size_t needed = 0;
            REQUIRE(metabuffer_split_viewport(&at, width, height, &on, rows.data(), count - 1, &needed) ==
                    METABUFFER_NO_ROOM);
            REQUIRE(needed == count);
        }
    }
    CHECK(refused > 30);
    CHECK(shown > 5000);
}

ViewportTable random_table(Random& random, int most_rows) {
    ViewportTable table(static_cast<std::size_t>(random.between(0, most_rows)));
    for (ViewportRow& row : table) {
        const auto field = [&random] { return static_cast<std::uint16_t>(random.bits()); };
        row = {field(),
               field(),
               field(),
               field(),
               field(),
               static_cast<std::int16_t>(field()),
               static_cast<std::int16_t>(field()),
               field()};
    }
    return table;
}

std::vector<std::uint8_t> random_bytes(Random& random, int most) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(random.between(0, most)));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    return bytes;
}

metabuffer_status status_of(ScanlineDefect defect) {
    switch (defect) {
        case ScanlineDefect::kNone:
            return METABUFFER_OK;
        case ScanlineDefect::kMagic:
            return METABUFFER_BAD_MAGIC;
        case ScanlineDefect::kVersion:
            return METABUFFER_BAD_VERSION;
        case ScanlineDefect::kCrc:
            return METABUFFER_BAD_CRC;
        case ScanlineDefect::kKind:
            return METABUFFER_BAD_KIND;
    }
    return METABUFFER_STATUS_COUNT;
}

/// Reads the scanline by the C library and by the machine's decoder.
void check_reading(const std::vector<std::uint32_t>& scanline) {
    const DecodedScanline expected = decode_control_scanline(scanline);
    std::array<metabuffer_row, 64> rows{};
    std::array<std::uint8_t, 256> payload{};
    metabuffer_control control{};
    REQUIRE(metabuffer_read_control(scanline.data(), scanline.size(), nullptr, nullptr, 0, nullptr, 0) ==
            status_of(expected.defect));
    REQUIRE(metabuffer_read_control(scanline.data(), scanline.size(), &control, rows.data(), rows.size(),
                                    payload.data(), payload.size()) == status_of(expected.defect));
    if (expected.defect != ScanlineDefect::kNone) return;
    REQUIRE(control.kind == static_cast<std::uint8_t>(expected.content.kind));
    REQUIRE(control.frame_number == expected.content.frame_number);
    REQUIRE(cpp_table(control.rows, control.row_count) == expected.content.table);
    REQUIRE(std::vector<std::uint8_t>(payload.begin(),
                                      payload.begin() + static_cast<std::ptrdiff_t>(control.payload_bytes)) ==
            expected.content.payload);
}

TEST_CASE("the C library writes and reads control scanlines as the machine does") {
    const std::uint64_t seed = test::random_seed(2);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    int too_long = 0;
    std::array<int, 5> defects{};
    for (int n = 0; n < 20'000; ++n) {
        ControlScanline content;
        content.kind = random.one_in(2) ? FrameKind::kColour : FrameKind::kDepth;
        content.frame_number = static_cast<std::uint32_t>(random.bits());
        content.table = random_table(random, 8);
        content.payload = random_bytes(random, 60);
        const int width = random.between(1, 120);
        std::optional<std::vector<std::uint32_t>> expected;
        try {
            expected = encode_control_scanline(content, width);
        } catch (const ScanlineOverflow&) {
            ++too_long;
        }
        const std::vector<metabuffer_row> rows = c_rows(content.table);
        const metabuffer_control control{static_cast<std::uint8_t>(content.kind),
                                         content.frame_number,
                                         rows.data(),
                                         rows.size(),
                                         content.payload.data(),
                                         content.payload.size()};
        std::vector<std::uint32_t> scanline(static_cast<std::size_t>(width), 0xFFFF'FFFF);
        REQUIRE(metabuffer_write_control(&control, scanline.data(), scanline.size()) ==
                (expected ? METABUFFER_OK : METABUFFER_NO_ROOM));
        if (!expected) continue;
        REQUIRE(scanline == *expected);
        // A byte or two, mostly of the content, become others.
        for (int change = random.between(0, 2); change > 0; --change) {
            const int byte = random.between(0, random.one_in(2) ? 16 : 3 * width - 1);
            scanline[static_cast<std::size_t>(byte / 3 % width)] ^=
                static_cast<std::uint32_t>(random.between(1, 255)) << (8 * (byte % 3));
        }
        check_reading(scanline);
        ++defects[static_cast<std::size_t>(decode_control_scanline(scanline).defect)];
    }
    CHECK(too_long > 1000);
    for (const ScanlineDefect defect :
         {ScanlineDefect::kNone, ScanlineDefect::kMagic, ScanlineDefect::kVersion, ScanlineDefect::kCrc}) {
        CHECK(defects[static_cast<std::size_t>(defect)] > 200);
    }
    for (const std::size_t width : {1U, 2U, 5U, 6U})
        check_reading(std::vector<std::uint32_t>(width, 0x4D4255));
    ControlScanline other_kind;
    other_kind.kind = static_cast<FrameKind>(2);
    check_reading(encode_control_scanline(other_kind, 20));
}

TEST_CASE("the C library makes, writes and reads slot tables as the machine's host does") {
    const std::uint64_t seed = test::random_seed(3);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    int rounded = 0;
    for (int n = 0; n < 3000; ++n) {
        ViewportTable table(static_cast<std::size_t>(random.between(0, random.one_in(10) ? 300 : 12)));
        for (ViewportRow& row : table) {
            row.sdx = static_cast<std::uint16_t>(random.between(1, random.one_in(3) ? 65535 : 640));
            row.dmultiple = static_cast<std::uint16_t>(random.between(1, random.one_in(3) ? 255 : 4));
        }
        const int limit = random.one_in(2) ? kSlotTableLimit : random.between(1, kSlotTableLimit);
        const std::vector<int> expected = slot_table(table, limit);
        const std::vector<metabuffer_row> rows = c_rows(table);
        std::vector<std::uint16_t> slots(table.size() + static_cast<std::size_t>(limit));
        std::size_t count = 0;
        REQUIRE(metabuffer_make_slots(rows.data(), rows.size(), static_cast<std::size_t>(limit), slots.data(),
                                      slots.size(), &count) == METABUFFER_OK);
        REQUIRE(std::vector<int>(slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(count)) ==
                expected);
        rounded += count > static_cast<std::size_t>(limit) ? 1 : 0;
        if (table.empty()) continue;

        const std::vector<std::uint8_t> payload = encode_slots(expected, table.size());
        std::array<std::uint8_t, 2000> written{};
        std::size_t bytes = 0;
        REQUIRE(metabuffer_write_slots(slots.data(), count, table.size(), written.data(), written.size(),
                                       &bytes) == METABUFFER_OK);
        REQUIRE(std::vector<std::uint8_t>(written.begin(),
                                          written.begin() + static_cast<std::ptrdiff_t>(bytes)) == payload);
        REQUIRE(metabuffer_slots_in_payload(bytes, table.size()) == slots_in_payload(bytes, table.size()));
        if (random.one_in(4)) written[static_cast<std::size_t>(random.between(0, 3))] ^= 1;
        const auto decoded =
            decode_slots({written.begin(), written.begin() + static_cast<std::ptrdiff_t>(bytes)});
        std::vector<std::uint16_t> read(65536);
        REQUIRE(metabuffer_read_slots(written.data(), bytes, read.data(), read.size(), &count) ==
                (decoded ? METABUFFER_OK : METABUFFER_BAD_SLOTS));
        if (decoded) {
            REQUIRE(std::vector<int>(read.begin(), read.begin() + static_cast<std::ptrdiff_t>(count)) ==
                    *decoded);
        }
    }
    CHECK(rounded > 100);
}

/// value / full of far, to nearest, in numbers that hold every product.
std::uint32_t share(std::uint64_t value, std::uint64_t full, std::uint64_t far) {
    return static_cast<std::uint32_t>(std::llroundl(static_cast<long double>(value) * far / full));
}

TEST_CASE("the C library packs depths of every type into both depth formats") {
    const std::uint64_t seed = test::random_seed(4);
    INFO("METABUFFER_SEED=" << seed);
    Random random(seed);
    constexpr std::size_t kCount = 64;
    for (int n = 0; n < 500; ++n) {
        const DepthFormat format = random.one_in(2) ? DepthFormat::kA8Z16 : DepthFormat::kZ24;
        const DepthLayout& layout = layout_of(format);
        const std::uint32_t far = far_z(format);
        const bool reversed = random.one_in(2);
        const auto type = static_cast<metabuffer_depth_type>(random.between(0, 3));
        std::array<float, kCount> floats{};
        std::array<std::uint16_t, kCount> halves{};
        std::array<std::uint32_t, kCount> words{};
        std::array<std::uint8_t, 4 * kCount> alpha{};
        std::array<std::uint32_t, kCount> expected{};
        const void* depths = words.data();
        for (std::size_t i = 0; i < kCount; ++i) {
            const std::uint64_t bits =
                random.one_in(4) ? (random.one_in(2) ? 0 : ~std::uint64_t{0}) : random.bits();
            alpha[4 * i] = static_cast<std::uint8_t>(random.bits());
            std::uint32_t z = 0;
            bool is_number = true;
            switch (type) {
                case METABUFFER_DEPTH_FLOAT: {
                    constexpr std::array<float, 6> kSpecial{0.0F,
                                                            1.0F,
                                                            -0.5F,
                                                            1.5F,
                                                            std::numeric_limits<float>::infinity(),
                                                            std::numeric_limits<float>::quiet_NaN()};
                    floats[i] = random.one_in(3) ? test::one_of(random, kSpecial)
                                                 : static_cast<float>(bits % 1000003) / 1000003.0F;
                    is_number = !std::isnan(floats[i]);
                    const double clamped = is_number ? std::min(1.0, std::max(0.0, double{floats[i]})) : 1.0;
                    z = static_cast<std::uint32_t>(std::llround(clamped * far));
                    depths = floats.data();
                    break;
                }
                case METABUFFER_DEPTH_UINT16:
                    halves[i] = static_cast<std::uint16_t>(bits);
                    z = share(halves[i], 0xFFFF, far);
                    depths = halves.data();
                    break;
                case METABUFFER_DEPTH_UINT24:
                    words[i] = static_cast<std::uint32_t>(bits);
                    z = share(words[i] & 0xFFFFFFU, 0xFFFFFF, far);
                    break;
                case METABUFFER_DEPTH_UINT32:
                    words[i] = static_cast<std::uint32_t>(bits);
                    z = share(words[i], 0xFFFFFFFF, far);
                    break;
            }
            if (reversed && is_number) z = far - z;
            expected[i] =
                (z << layout.z_shift) | ((alpha[4 * i] & layout.alpha_mask()) << layout.alpha_shift);
        }
        std::array<std::uint32_t, kCount> packed{};
        REQUIRE(metabuffer_pack_depth(format == DepthFormat::kZ24 ? METABUFFER_Z24 : METABUFFER_A8Z16, type,
                                      depths, kCount, reversed ? 1 : 0, alpha.data(), 4,
                                      packed.data()) == METABUFFER_OK);
        REQUIRE(packed == expected);
    }
}

TEST_CASE("every status of the C library has a sentence of its own") {
    std::set<std::string> sentences;
    for (int status = 0; status <= METABUFFER_STATUS_COUNT; ++status) {
        sentences.insert(metabuffer_status_text(static_cast<metabuffer_status>(status)));
    }
    CHECK(sentences.size() == METABUFFER_STATUS_COUNT + 1);
}

}  // namespace
}  // namespace metabuffer
