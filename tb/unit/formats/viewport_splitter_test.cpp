#include "formats/viewport_splitter.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "support/random_seed.h"

namespace metabuffer {
namespace {

using Position = std::pair<int, int>;          ///< x and y, of a source pixel or in the global space
using Picture = std::map<Position, Position>;  ///< global raster position to the source pixel shown there

struct ImageSize {
    int width;
    int height;
};

/// Display that shows a global raster position, counted from 1, or 0 outside the wall.
int display_at(const DisplayWall& wall, Position global) {
    int display = 0;
    for (int row = 0; row < wall.rows; ++row) {
        for (int column = 0; column < wall.columns; ++column) {
            ++display;
            const int x = global.first - column * wall.raster_width_pixels;
            const int y = global.second - row * wall.raster_height_pixels;
            if (x >= 0 && x < wall.raster_width_pixels && y >= 0 && y < wall.raster_height_pixels) {
                return display;
            }
        }
    }
    return 0;
}

/// The viewport painted on the global space, and which source pixels each display shows at least in part.
struct Painted {
    Picture picture;
    std::map<int, std::set<Position>> touching;
};

Painted paint_viewport(const Viewport& viewport, ImageSize image, const DisplayWall& wall) {
    Painted result;
    const int m = viewport.multiple;
    for (int j = 0; j < image.height; ++j) {
        for (int i = 0; i < image.width; ++i) {
            for (int v = 0; v < m; ++v) {
                for (int u = 0; u < m; ++u) {
                    const Position global{viewport.x + i * m + u, viewport.y + j * m + v};
                    const int display = display_at(wall, global);
                    if (display == 0) continue;
                    result.picture[global] = {i, j};
                    result.touching[display].insert({i, j});
                }
            }
        }
    }
    return result;
}

/// The rows painted each on its own display's raster, clipped there, and laid side by side.
Painted paint_table(const ViewportTable& table, const DisplayWall& wall) {
    Painted result;
    for (const ViewportRow& row : table) {
        const int left = (row.dcomp - 1) % wall.columns * wall.raster_width_pixels;
        const int top = (row.dcomp - 1) / wall.columns * wall.raster_height_pixels;
        for (int j = 0; j < row.sdy; ++j) {
            for (int i = 0; i < row.sdx; ++i) {
                const Position source{row.sx + i, row.sy + j};
                result.touching[row.dcomp].insert(source);
                for (int v = 0; v < row.dmultiple; ++v) {
                    for (int u = 0; u < row.dmultiple; ++u) {
                        const int x = row.dx + i * row.dmultiple + u;
                        const int y = row.dy + j * row.dmultiple + v;
                        const bool on_raster =
                            x >= 0 && x < wall.raster_width_pixels && y >= 0 && y < wall.raster_height_pixels;
                        if (on_raster) result.picture[{left + x, top + y}] = source;
                    }
                }
            }
        }
    }
    return result;
}

void check_against_painting(const Viewport& viewport, ImageSize image, const DisplayWall& wall) {
    INFO("viewport " << viewport.x << ", " << viewport.y << " x" << viewport.multiple << ", image "
                     << image.width << " x " << image.height << ", wall " << wall.columns << " x "
                     << wall.rows << " of " << wall.raster_width_pixels << " x "
                     << wall.raster_height_pixels);
    const ViewportTable table = split_viewport(viewport, image.width, image.height, wall);
    const Painted wanted = paint_viewport(viewport, image, wall);
    const Painted got = paint_table(table, wall);
    REQUIRE((got.touching == wanted.touching));
    REQUIRE((got.picture == wanted.picture));

    int previous = 0;
    for (const ViewportRow& row : table) {
        REQUIRE(row.dcomp > previous);  // display order, each display once
        REQUIRE(row.dmultiple == viewport.multiple);
        previous = row.dcomp;
    }
    const int large_buffer = 1 << 24;
    const ViewportLimits limits{wall.columns * wall.rows,
                                image.width,
                                image.height,
                                wall.raster_width_pixels,
                                wall.raster_height_pixels,
                                large_buffer,
                                32};
    const ValidatedTable validated = validate_table(table, limits);
    REQUIRE(validated.rejected.empty());
    REQUIRE((validated.rows == table));
}

/// With smoothing each row has a source line more on every side on which the image goes on, and the displays show the
/// same source pixels in the same positions.
void check_aprons(const Viewport& viewport, ImageSize image, const DisplayWall& wall) {
    INFO("viewport " << viewport.x << ", " << viewport.y << " x" << viewport.multiple << ", image "
                     << image.width << " x " << image.height);
    const ViewportTable plain = split_viewport(viewport, image.width, image.height, wall);
    const ViewportTable smoothed =
        split_viewport(viewport, image.width, image.height, wall, Smoothing::kBilinear);
    REQUIRE(smoothed.size() == plain.size());
    REQUIRE((paint_table(smoothed, wall).picture == paint_viewport(viewport, image, wall).picture));
    for (std::size_t i = 0; i < plain.size(); ++i) {
        const ViewportRow& without = plain[i];
        const ViewportRow& with = smoothed[i];
        const int apron = viewport.multiple > 1 ? 1 : 0;
        REQUIRE(with.dcomp == without.dcomp);
        REQUIRE(with.sx == std::max(0, without.sx - apron));
        REQUIRE(with.sy == std::max(0, without.sy - apron));
        REQUIRE(with.sx + with.sdx == std::min(image.width, without.sx + without.sdx + apron));
        REQUIRE(with.sy + with.sdy == std::min(image.height, without.sy + without.sdy + apron));
        REQUIRE(with.dx - with.sx * viewport.multiple == without.dx - without.sx * viewport.multiple);
        REQUIRE(with.dy - with.sy * viewport.multiple == without.dy - without.sy * viewport.multiple);
    }
    ViewportLimits limits{wall.columns * wall.rows,  image.width, image.height, wall.raster_width_pixels,
                          wall.raster_height_pixels, 1 << 24,     32,           Smoothing::kBilinear};
    REQUIRE(validate_table(smoothed, limits).rejected.empty());
}

TEST_CASE("viewport splitter: gives a smoothed image an apron wherever it goes on") {
    const std::uint64_t seed = test::random_seed(20261120);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 2000; ++trial) {
        const DisplayWall wall{random.between(1, 3), random.between(1, 3), random.between(1, 9),
                               random.between(1, 9)};
        const ImageSize image{random.between(1, 8), random.between(1, 8)};
        Viewport viewport;
        viewport.multiple = random.between(1, 6);
        viewport.x =
            random.between(-image.width * viewport.multiple, wall.columns * wall.raster_width_pixels);
        viewport.y = random.between(-image.height * viewport.multiple, wall.rows * wall.raster_height_pixels);
        check_aprons(viewport, image, wall);
    }
}

TEST_CASE("viewport splitter: the paper's tables, and source pixels that straddle displays or do not show") {
    struct Case {
        Viewport viewport;
        ImageSize image;
        DisplayWall wall;
        ViewportTable table;
    };
    const std::vector<Case> cases{
        {{25, 25, 1},
         {100, 100},
         {2, 2, 100, 100},
         {{1, 0, 0, 75, 75, 25, 25, 1},
          {2, 75, 0, 25, 75, 0, 25, 1},
          {3, 0, 75, 75, 25, 25, 0, 1},
          {4, 75, 75, 25, 25, 0, 0, 1}}},
        // Its case three: four displays share a doubled image.
        {{0, 0, 2},
         {100, 100},
         {2, 2, 100, 100},
         {{1, 0, 0, 50, 50, 0, 0, 2},
          {2, 50, 0, 50, 50, 0, 0, 2},
          {3, 0, 50, 50, 50, 0, 0, 2},
          {4, 50, 50, 50, 50, 0, 0, 2}}},
        // Tripled from 8, the pixels cover 8..10 and 11..13 of two rasters of 10.
        {{8, 0, 3}, {2, 1}, {2, 1, 10, 10}, {{1, 0, 0, 1, 1, 8, 0, 3}, {2, 0, 0, 2, 1, -2, 0, 3}}},
        // One source pixel larger than the whole wall goes to every display.
        {{-4, -5, 50},
         {1, 1},
         {2, 2, 10, 10},
         {{1, 0, 0, 1, 1, -4, -5, 50},
          {2, 0, 0, 1, 1, -14, -5, 50},
          {3, 0, 0, 1, 1, -4, -15, 50},
          {4, 0, 0, 1, 1, -14, -15, 50}}},
        // From -7 by 3: the first two columns end at -2, the third covers -1..1 and shows in part.
        {{-7, -4, 3}, {20, 3}, {1, 1, 10, 10}, {{1, 2, 1, 4, 2, -1, -1, 3}}},
    };
    for (const Case& one : cases) {
        INFO(one.viewport.x << ", " << one.viewport.y << " x" << one.viewport.multiple);
        CHECK((split_viewport(one.viewport, one.image.width, one.image.height, one.wall) == one.table));
    }
    // Its case four: a doubled image over nine displays.
    const ViewportTable table = split_viewport({60, 60, 2}, 100, 100, {3, 3, 100, 100});
    REQUIRE(table.size() == 9);
    CHECK((table[0] == ViewportRow{1, 0, 0, 20, 20, 60, 60, 2}));
    CHECK((table[4] == ViewportRow{5, 20, 20, 50, 50, 0, 0, 2}));
    CHECK((table[8] == ViewportRow{9, 70, 70, 30, 30, 0, 0, 2}));
}

TEST_CASE("viewport splitter: agrees with painting for every position of a small image around a small wall") {
    const DisplayWall wall{2, 2, 4, 3};
    for (int multiple = 1; multiple <= 6; ++multiple) {
        for (int x = -2 * multiple - 1; x <= 9; ++x) {
            for (int y = -2 * multiple - 1; y <= 7; ++y) {
                check_against_painting({x, y, multiple}, {2, 2}, wall);
            }
        }
    }
}

TEST_CASE("viewport splitter: agrees with painting for random walls, images, positions and multiples") {
    const auto seed = test::random_seed(113);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    for (int trial = 0; trial < 300; ++trial) {
        const DisplayWall wall{random.between(1, 4), random.between(1, 4), random.between(1, 16),
                               random.between(1, 16)};
        const int multiple = random.one_in(8) ? random.between(1, 255) : random.between(1, 7);
        const int longest = multiple > 7 ? 3 : 14;
        const ImageSize image{random.between(1, longest), random.between(1, longest)};
        const Viewport viewport{
            random.between(-image.width * multiple - 2, wall.columns * wall.raster_width_pixels + 2),
            random.between(-image.height * multiple - 2, wall.rows * wall.raster_height_pixels + 2),
            multiple};
        check_against_painting(viewport, image, wall);
    }
}

TEST_CASE("viewport splitter: what 1 to 255 or 16 bits cannot hold is the host's error") {
    const DisplayWall wall{2, 2, 10, 10};
    for (const int multiple : {0, -1, 256, 2147483647}) {
        INFO("multiple " << multiple);
        CHECK_THROWS_AS(split_viewport({0, 0, multiple}, 4, 4, wall), std::invalid_argument);
        CHECK_THROWS_AS(split_viewport({9999, 0, multiple}, 4, 4, wall), std::invalid_argument);
    }
    CHECK_NOTHROW(split_viewport({0, 0, 1}, 4, 4, wall));
    CHECK_NOTHROW(split_viewport({0, 0, 255}, 4, 4, wall));
    const DisplayWall wide{1, 1, 140000, 10};
    CHECK(split_viewport({32767, 0, 1}, 4, 4, wide).at(0).dx == 32767);
    CHECK_THROWS_WITH(split_viewport({32768, 0, 1}, 4, 4, wide), Catch::Contains("Dx = 32768"));
    CHECK(split_viewport({0, 0, 1}, 65535, 4, wide).at(0).sdx == 65535);
    CHECK_THROWS_WITH(split_viewport({0, 0, 1}, 65536, 4, wide), Catch::Contains("Sdx = 65536"));
    CHECK(split_viewport({-65535, 0, 1}, 65540, 4, wide).at(0).sx == 65535);
    CHECK_THROWS_WITH(split_viewport({-65536, 0, 1}, 65540, 4, wide), Catch::Contains("Sx = 65536"));

    const DisplayWall high{1, 1, 10, 140000};
    CHECK_THROWS_WITH(split_viewport({0, 32768, 1}, 4, 4, high), Catch::Contains("Dy = 32768"));
    CHECK_THROWS_WITH(split_viewport({0, 0, 1}, 4, 65536, high), Catch::Contains("Sdy = 65536"));
    CHECK_THROWS_WITH(split_viewport({0, -65536, 1}, 4, 65540, high), Catch::Contains("Sy = 65536"));

    const DisplayWall many{65537, 1, 10, 10};
    CHECK(split_viewport({655340, 0, 1}, 4, 4, many).at(0).dcomp == 65535);
    CHECK_THROWS_WITH(split_viewport({655350, 0, 1}, 4, 4, many), Catch::Contains("Dcomp = 65536"));
}

TEST_CASE("viewport splitter: extreme positions overflow nothing") {
    constexpr int kMost = 2147483647;
    const DisplayWall wall{64, 2, 16384, 16384};
    CHECK(split_viewport({kMost, kMost, 255}, 4096, 4096, wall).empty());
    CHECK(split_viewport({-kMost - 1, -kMost - 1, 255}, 4096, 4096, wall).empty());
    // The wall lies deep inside an image as large as can be named.
    CHECK_THROWS_WITH(split_viewport({-kMost - 1, 0, 255}, kMost, 1, wall), Catch::Contains("Sx = 8421504"));
}

}  // namespace
}  // namespace metabuffer
