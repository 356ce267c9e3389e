#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "formats/smoothing.h"

namespace metabuffer {

/// One row of the viewport table (section 5 of the paper): which rectangle of the renderer's image goes to
/// which composer, and where in that display's raster it lies.
struct ViewportRow {
    std::uint16_t dcomp = 0;  ///< display, counted from 1
    std::uint16_t sx = 0;     ///< source rectangle in image pixels; sy = 0 is the first image scanline
    std::uint16_t sy = 0;
    std::uint16_t sdx = 0;
    std::uint16_t sdy = 0;
    std::int16_t dx = 0;  ///< raster position of the source rectangle's top left; may be negative
    std::int16_t dy = 0;
    std::uint16_t dmultiple = 0;  ///< replication factor: a source pixel fills dmultiple x dmultiple pixels

    friend bool operator==(const ViewportRow& a, const ViewportRow& b) {
        return a.dcomp == b.dcomp && a.sx == b.sx && a.sy == b.sy && a.sdx == b.sdx && a.sdy == b.sdy &&
               a.dx == b.dx && a.dy == b.dy && a.dmultiple == b.dmultiple;
    }
    friend bool operator!=(const ViewportRow& a, const ViewportRow& b) { return !(a == b); }
};

using ViewportTable = std::vector<ViewportRow>;

constexpr int kMaximumMultiple = 255;

/// What a row is judged against.
struct ViewportLimits {
    int displays = 0;            ///< N
    int image_width_pixels = 0;  ///< the renderer's image, without the control scanline
    int image_height_pixels = 0;
    int raster_width_pixels = 0;  ///< one display's raster: supersample x display size
    int raster_height_pixels = 0;
    int buffer_pixels = 0;  ///< of one composer
    int ready_space_pixels = 0;
    Smoothing smoothing = Smoothing::kReplicate;  ///< of the composers
};

/// Why a row is dropped. The order is the order in which the rules are checked; the first that fails counts.
enum class RowDefect : std::uint8_t {
    kNone,
    kDisplay,      ///< dcomp is not 1..N
    kDuplicate,    ///< dcomp is taken by an earlier valid row of the same table
    kMultiple,     ///< dmultiple is not 1..255
    kSource,       ///< the source rectangle is empty or leaves the image
    kDestination,  ///< its first or last source pixel would not show; smoothed, its second or last but one
    kBuffer,       ///< the composer's buffer could never hold what the row needs
};
constexpr int kRowDefectCount = 7;

/// The report's key for a defect: "display", "duplicate", "multiple", "source", "destination", "buffer".
const char* row_defect_key(RowDefect defect);

/// A row that was dropped: its index in the table (from 0), and a sentence that says what would be right.
struct RejectedRow {
    int index = 0;
    RowDefect defect = RowDefect::kNone;
    std::string message;
};

struct ValidatedTable {
    ViewportTable rows;  ///< the valid rows in table order
    std::vector<RejectedRow> rejected;
};

/// The smallest buffer with which a row that is valid otherwise cannot wait for ever. Where a composer waits for a pixel, it
/// holds all but that one of the source rows in its window, and without the ready space besides it would not get the pixel.
/// A buffer of one pixel less can wait for ever (scripts/prove stalled).
std::int64_t least_buffer_pixels(const ViewportRow& row, Smoothing smoothing,
                                 std::int64_t ready_space_pixels);

/// Checks one row alone: every rule except the one about earlier rows.
RowDefect row_defect(const ViewportRow& row, const ViewportLimits& limits);

/// Judges the rows of a table as they come, one after the other.
class TableJudge {
  public:
    explicit TableJudge(const ViewportLimits& limits) : limits_(limits) {}

    /// A new table begins.
    void clear();
    void take(const ViewportRow& row);
    /// The rows so far.
    const ValidatedTable& result() const { return result_; }

  private:
    ViewportLimits limits_;
    ValidatedTable result_;
    std::set<std::uint16_t> taken_;  ///< displays that a valid row names
    int next_index_ = 0;
};

/// Splits a table into the valid rows and the dropped rows. Raises nothing.
ValidatedTable validate_table(const ViewportTable& table, const ViewportLimits& limits);

}  // namespace metabuffer
