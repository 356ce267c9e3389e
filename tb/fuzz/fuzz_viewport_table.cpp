// libFuzzer: arbitrary rows against arbitrary limits. This file works out for itself which rows are valid and why the
// others are not. It paints the pixels of valid rows one by one to check where they lie. It checks the tables of the
// host's side for each pixel of the wall. scripts/fuzz runs it.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "byte_reader.h"
#include "datapath/composer_buffer.h"
#include "datapath/segment.h"
#include "expectations.h"
#include "formats/viewport_splitter.h"
#include "formats/viewport_table.h"
#include "support/painted_segment.h"

namespace {

using namespace metabuffer;
using metabuffer::fuzz::ByteReader;
using metabuffer::test::PaintedSegment;

constexpr int kLargestPaintedRaster =
    32;  ///< pixels a side; beyond, painting takes long and shows nothing new
constexpr std::size_t kMostRows = 40;

// ---- which rows are valid ----

/// Some of the `multiple` raster lines from `first` on lie on the raster. Counted one by one, not computed.
bool shows(std::int64_t first, std::int64_t multiple, std::int64_t raster) {
    for (std::int64_t line = first; line < first + multiple; ++line) {
        if (line >= 0 && line < raster) return true;
    }
    return false;
}

/// Where the row is smoothed, the outermost line at either end may lie beside the raster: the next one is mixed with it.
bool ends_show(std::int64_t destination, std::int64_t count, std::int64_t multiple, std::int64_t raster,
               bool smoothed) {
    const std::int64_t last = destination + (count - 1) * multiple;
    const bool has_apron = smoothed && count > 1;
    return (shows(destination, multiple, raster) ||
            (has_apron && shows(destination + multiple, multiple, raster))) &&
           (shows(last, multiple, raster) || (has_apron && shows(last - multiple, multiple, raster)));
}

bool lies_within(std::int64_t source, std::int64_t count, std::int64_t image) {
    return count >= 1 && source + count <= image;
}

RowDefect expected_defect(const ViewportRow& row, const ViewportLimits& limits,
                          const ViewportTable& standing) {
    for (const ViewportRow& earlier : standing) {
        if (earlier.dcomp == row.dcomp) return RowDefect::kDuplicate;
    }
    if (row.dcomp == 0 || row.dcomp > limits.displays) return RowDefect::kDisplay;
    if (row.dmultiple == 0 || row.dmultiple >= 256) return RowDefect::kMultiple;
    if (!lies_within(row.sx, row.sdx, limits.image_width_pixels) ||
        !lies_within(row.sy, row.sdy, limits.image_height_pixels)) {
        return RowDefect::kSource;
    }
    const bool smoothed = limits.smoothing == Smoothing::kBilinear && row.dmultiple > 1;
    if (!ends_show(row.dx, row.sdx, row.dmultiple, limits.raster_width_pixels, smoothed) ||
        !ends_show(row.dy, row.sdy, row.dmultiple, limits.raster_height_pixels, smoothed)) {
        return RowDefect::kDestination;
    }
    // What is repeated, or mixed with the next row, stays in the buffer. The next slot must find room in the rest.
    const int kept = row.dmultiple == 1 ? 0 : (smoothed ? 2 : 1) * row.sdx - 1;
    return kept + limits.ready_space_pixels > limits.buffer_pixels ? RowDefect::kBuffer : RowDefect::kNone;
}

/// Returns the valid rows.
ViewportTable check_validation(const ViewportTable& table, const ViewportLimits& limits) {
    const ValidatedTable validated = validate_table(table, limits);
    ViewportTable standing;
    std::size_t rejected = 0;
    for (std::size_t i = 0; i < table.size(); ++i) {
        const RowDefect defect = expected_defect(table[i], limits, standing);
        if (defect == RowDefect::kNone) {
            standing.push_back(table[i]);
            EXPECT(row_defect(table[i], limits) == RowDefect::kNone);
            continue;
        }
        EXPECT(rejected < validated.rejected.size());
        const RejectedRow& row = validated.rejected[rejected++];
        EXPECT(row.index == static_cast<int>(i));
        EXPECT(row.defect == defect);
        EXPECT(!row.message.empty() && row.message.find('\n') == std::string::npos);
        EXPECT(defect == RowDefect::kDuplicate || row_defect(table[i], limits) == defect);
    }
    EXPECT(rejected == validated.rejected.size());
    EXPECT(validated.rows == standing);
    return standing;
}

// ---- where their pixels lie ----

void check_uses(const Segment& segment, const PaintedSegment& painted, test::Size raster) {
    const std::int64_t positions = std::int64_t{raster.width} * raster.height;
    std::vector<std::int64_t> releases(static_cast<std::size_t>(positions), 0);  // at each position
    std::int64_t released = 0;
    EXPECT(segment.pixels() == static_cast<std::int64_t>(painted.first.size()));
    for (std::size_t k = 0; k < painted.first.size(); ++k) {
        // Every pixel of a valid row shows somewhere, unless it is beside the raster. A source row above the raster that
        // nothing is mixed with is released by the frame's start.
        EXPECT(painted.last[k] != PaintedSegment::kNone || segment.smooths());
        EXPECT(segment.first_use(static_cast<std::int64_t>(k)) ==
               (painted.first[k] == PaintedSegment::kNever ? segment.never() : painted.first[k]));
        EXPECT(segment.last_use(static_cast<std::int64_t>(k)) == painted.last[k]);
        if (painted.last[k] == PaintedSegment::kNone) {
            ++released;
        } else {
            ++releases[static_cast<std::size_t>(painted.last[k])];
        }
    }
    EXPECT(segment.skipped_pixels() == released);
    for (std::int64_t position = 0; position < positions; ++position) {
        EXPECT(segment.released_before(position) == released);
        released += releases[static_cast<std::size_t>(position)];
    }
    EXPECT(segment.released_before(positions) == segment.pixels());
}

void check_walk(const Segment& segment, const PaintedSegment& painted, test::Size raster) {
    SegmentWalker walker(segment, true, raster.width, raster.height);
    std::int64_t released = segment.skipped_pixels();
    for (int y = 0; y < raster.height; ++y) {
        for (int x = 0; x < raster.width; ++x) {
            const std::int64_t position = std::int64_t{y} * raster.width + x;
            const std::int64_t pixel = painted.owner(position);
            const bool covered = pixel != PaintedSegment::kNone;
            EXPECT(!walker.done() && walker.x() == x && walker.y() == y);
            EXPECT(segment.covers(x, y) == covered);
            EXPECT(walker.covered() == covered);
            if (covered) {
                EXPECT(segment.pixel_at(x, y) == pixel);
                EXPECT(walker.pixel() == pixel);
                EXPECT(walker.step().newest() == painted.newest[static_cast<std::size_t>(position)]);
                released = std::max(released, walker.released() + 1);
                EXPECT(released == segment.released_before(position + 1));
                const BlendWindow<std::int64_t> window = walker.step().window();
                const BlendWindow<std::int64_t> divided = segment.window_at(x, y);
                EXPECT(window.own == divided.own && window.beside == divided.beside &&
                       window.across == divided.across && window.diagonal == divided.diagonal);
            }
            walker.advance();
        }
    }
    EXPECT(walker.done());
}

void check_segment(const ViewportRow& row, test::Size raster, Smoothing smoothing) {
    const Segment segment(row, raster.width, raster.height, smoothing);
    const PaintedSegment painted(row, raster, smoothing);
    check_uses(segment, painted, raster);
    check_walk(segment, painted, raster);
}

// ---- the host's side ----

constexpr std::int64_t kNothing = -1;

/// The image pixel that the wall shows at a position; kNothing if it shows none.
std::int64_t image_pixel_at(const Viewport& viewport, const ViewportLimits& limits, std::int64_t x,
                            std::int64_t y) {
    if (x < viewport.x || y < viewport.y) return kNothing;
    const std::int64_t column = (x - viewport.x) / viewport.multiple;
    const std::int64_t row = (y - viewport.y) / viewport.multiple;
    if (column >= limits.image_width_pixels || row >= limits.image_height_pixels) return kNothing;
    return row * limits.image_width_pixels + column;
}

std::int64_t table_pixel_at(const ViewportTable& table, const ViewportLimits& limits, int display, int x,
                            int y) {
    for (const ViewportRow& row : table) {
        if (row.dcomp != display) continue;
        const Segment segment(row, limits.raster_width_pixels, limits.raster_height_pixels);
        if (!segment.covers(x, y)) return kNothing;
        const std::int64_t pixel = segment.pixel_at(x, y);
        return (row.sy + pixel / row.sdx) * limits.image_width_pixels + row.sx + pixel % row.sdx;
    }
    return kNothing;
}

void check_splitter(const Viewport& viewport, const DisplayWall& wall, ViewportLimits limits) {
    limits.displays = wall.columns * wall.rows;
    // The host knows nothing of buffers.
    limits.ready_space_pixels = 1;
    limits.buffer_pixels = 2 * limits.image_width_pixels + limits.ready_space_pixels;
    const bool multiple_is_right = viewport.multiple >= 1 && viewport.multiple <= 255;
    ViewportTable table;
    try {
        table = split_viewport(viewport, limits.image_width_pixels, limits.image_height_pixels, wall,
                               limits.smoothing);
    } catch (const std::invalid_argument& error) {
        // With an image and a wall of this size every number fits its field.
        EXPECT(!multiple_is_right);
        metabuffer::fuzz::expect_one_clear_line(error);
        return;
    }
    EXPECT(multiple_is_right);
    EXPECT(check_validation(table, limits) == table);
    for (int display = 0; display < limits.displays; ++display) {
        const std::int64_t left = std::int64_t{display % wall.columns} * wall.raster_width_pixels;
        const std::int64_t top = std::int64_t{display / wall.columns} * wall.raster_height_pixels;
        for (int y = 0; y < wall.raster_height_pixels; ++y) {
            for (int x = 0; x < wall.raster_width_pixels; ++x) {
                EXPECT(table_pixel_at(table, limits, display + 1, x, y) ==
                       image_pixel_at(viewport, limits, left + x, top + y));
            }
        }
    }
}

/// A small size, which can be painted, or any size.
int size_of(ByteReader& bytes, bool small) {
    return 1 + (small ? bytes.u8() % kLargestPaintedRaster : bytes.u16());
}

ViewportRow row_of(ByteReader& bytes) {
    ViewportRow row;
    row.dcomp = bytes.u16();
    row.sx = bytes.u16();
    row.sy = bytes.u16();
    row.sdx = bytes.u16();
    row.sdy = bytes.u16();
    row.dx = bytes.i16();
    row.dy = bytes.i16();
    row.dmultiple = bytes.u16();
    return row;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr unsigned kSmall = 1;
    constexpr unsigned kSplit = 2;
    constexpr unsigned kSmoothed = 4;
    ByteReader bytes(data, size);
    const unsigned choices = bytes.u8();
    const bool small = (choices & kSmall) != 0;
    ViewportLimits limits;
    if ((choices & kSmoothed) != 0) limits.smoothing = Smoothing::kBilinear;
    limits.displays = small ? bytes.u8() % 9 + 1 : bytes.u16();
    limits.image_width_pixels = size_of(bytes, small);
    limits.image_height_pixels = size_of(bytes, small);
    limits.raster_width_pixels = size_of(bytes, small);
    limits.raster_height_pixels = size_of(bytes, small);
    limits.buffer_pixels = bytes.u16() + 1;
    limits.ready_space_pixels = bytes.u16() + 1;

    if (small && (choices & kSplit) != 0) {
        const DisplayWall wall{bytes.u8() % 3 + 1, bytes.u8() % 3 + 1, limits.raster_width_pixels,
                               limits.raster_height_pixels};
        const int x = bytes.i16();
        const int y = bytes.i16();
        check_splitter({x, y, bytes.u16()}, wall, limits);
        return 0;
    }
    ViewportTable table;
    while (!bytes.empty() && table.size() < kMostRows) table.push_back(row_of(bytes));
    for (const ViewportRow& row : check_validation(table, limits)) {
        if (small)
            check_segment(row, {limits.raster_width_pixels, limits.raster_height_pixels}, limits.smoothing);
    }
    return 0;
}
