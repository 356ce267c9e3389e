#include "formats/viewport_table.h"

#include <algorithm>

namespace metabuffer {
namespace {

/// One axis of a row against its image and raster, so that each rule is written once for x and y. Fields, invalid
/// multiples too, have at most 16 bits: 64 bits hold every product.
struct Axis {
    const char* name;          ///< "x" or "y", as in Sx, Sdx, Dx
    const char* line;          ///< what a line across this axis is called
    const char* before;        ///< where a position below 0 lies
    const char* behind;        ///< where a position beyond the raster lies
    const char* extent;        ///< what the image's size is counted in
    std::int64_t source;       ///< Sx
    std::int64_t count;        ///< Sdx
    std::int64_t destination;  ///< Dx
    std::int64_t multiple;     ///< Dmultiple
    std::int64_t image;        ///< image size
    std::int64_t raster;       ///< raster size
    std::int64_t beside;  ///< by how much the outermost source lines may lie beside the raster: none or one

    std::int64_t source_end() const { return source + count; }
    std::int64_t destination_end() const { return destination + count * multiple; }
    bool source_fits() const { return count >= 1 && source_end() <= image; }
    /// A smoothed segment may have a line more on each side, which others are mixed with.
    std::int64_t slack() const { return count > 1 ? beside * multiple : 0; }
    bool first_shows() const { return destination > -multiple - slack() && destination < raster; }
    bool last_shows() const { return destination_end() < raster + multiple + slack(); }
};

std::int64_t lines_beside(const ViewportRow& row, const ViewportLimits& limits) {
    return smoothing_reach(limits.smoothing, row.dmultiple) > 0 ? 1 : 0;
}

Axis horizontal(const ViewportRow& row, const ViewportLimits& limits) {
    return {"x",
            "column",
            "left of",
            "right of",
            "pixels",
            row.sx,
            row.sdx,
            row.dx,
            row.dmultiple,
            limits.image_width_pixels,
            limits.raster_width_pixels,
            lines_beside(row, limits)};
}

Axis vertical(const ViewportRow& row, const ViewportLimits& limits) {
    return {"y",
            "row",
            "above",
            "below",
            "scanlines",
            row.sy,
            row.sdy,
            row.dy,
            row.dmultiple,
            limits.image_height_pixels,
            limits.raster_height_pixels,
            lines_beside(row, limits)};
}

std::string display_message(const ViewportRow& row, const ViewportLimits& limits) {
    return "Dcomp " + std::to_string(row.dcomp) + " is not a display: 1 to " +
           std::to_string(limits.displays);
}

std::string duplicate_message(const ViewportRow& row) {
    return "Dcomp " + std::to_string(row.dcomp) +
           " is taken by an earlier row of the table: one row for each display";
}

std::string multiple_message(const ViewportRow& row) {
    return "Dmultiple " + std::to_string(row.dmultiple) + " is outside 1 to " +
           std::to_string(kMaximumMultiple);
}

std::string source_message(const Axis& axis) {
    const std::string name = axis.name;
    if (axis.count < 1) return "Sd" + name + " 0 makes the segment empty: at least 1";
    return "S" + name + " + Sd" + name + " = " + std::to_string(axis.source_end()) + " leaves the image of " +
           std::to_string(axis.image) + " " + axis.extent;
}

std::string destination_message(const Axis& axis) {
    const std::string name = axis.name;
    const std::string source_line = std::string("source ") + axis.line + " lies ";
    const std::string position = " the raster: D" + name;
    const bool second = axis.slack() > 0;
    if (axis.destination <= -axis.multiple - axis.slack()) {
        return (second ? "its second " : "its first ") + source_line + axis.before + position + " = " +
               std::to_string(axis.destination) + " must stay above " +
               std::to_string(-axis.multiple - axis.slack());
    }
    if (axis.destination >= axis.raster) {
        return "its first " + source_line + axis.behind + position + " = " +
               std::to_string(axis.destination) + " must stay below " + std::to_string(axis.raster);
    }
    return (second ? "its last but one " : "its last ") + source_line + axis.behind + position + " + Sd" +
           name + "*m = " + std::to_string(axis.destination_end()) + " must stay below " +
           std::to_string(axis.raster + axis.multiple + axis.slack());
}

std::string buffer_message(const ViewportRow& row, const ViewportLimits& limits) {
    const int rows = window_rows(limits.smoothing, row.dmultiple);
    const std::string window = rows == 1 ? "Sdx - 1 + " : std::to_string(rows) + "*Sdx - 1 + ";
    return "the composer's buffer of " + std::to_string(limits.buffer_pixels) +
           " pixels could never hold what the row needs: at least " + (rows == 0 ? "" : window) +
           "ready_space_pixels = " +
           std::to_string(least_buffer_pixels(row, limits.smoothing, limits.ready_space_pixels));
}

std::string message(const ViewportRow& row, const ViewportLimits& limits, RowDefect defect) {
    const Axis x = horizontal(row, limits);
    const Axis y = vertical(row, limits);
    switch (defect) {
        case RowDefect::kNone:
            break;
        case RowDefect::kDisplay:
            return display_message(row, limits);
        case RowDefect::kDuplicate:
            return duplicate_message(row);
        case RowDefect::kMultiple:
            return multiple_message(row);
        case RowDefect::kSource:
            return source_message(x.source_fits() ? y : x);
        case RowDefect::kDestination:
            return destination_message(x.first_shows() && x.last_shows() ? y : x);
        case RowDefect::kBuffer:
            return buffer_message(row, limits);
    }
    return {};
}

bool names_display(const ViewportRow& row, const ViewportLimits& limits) {
    return row.dcomp >= 1 && row.dcomp <= limits.displays;
}

}  // namespace

std::int64_t least_buffer_pixels(const ViewportRow& row, Smoothing smoothing,
                                 std::int64_t ready_space_pixels) {
    const std::int64_t window_pixels = std::int64_t{window_rows(smoothing, row.dmultiple)} * row.sdx;
    return std::max<std::int64_t>(window_pixels - 1, 0) + ready_space_pixels;
}

const char* row_defect_key(RowDefect defect) {
    switch (defect) {
        case RowDefect::kNone:
            return "none";
        case RowDefect::kDisplay:
            return "display";
        case RowDefect::kDuplicate:
            return "duplicate";
        case RowDefect::kMultiple:
            return "multiple";
        case RowDefect::kSource:
            return "source";
        case RowDefect::kDestination:
            return "destination";
        case RowDefect::kBuffer:
            return "buffer";
    }
    return "unknown";
}

RowDefect row_defect(const ViewportRow& row, const ViewportLimits& limits) {
    const Axis x = horizontal(row, limits);
    const Axis y = vertical(row, limits);
    if (!names_display(row, limits)) return RowDefect::kDisplay;
    if (row.dmultiple < 1 || row.dmultiple > kMaximumMultiple) return RowDefect::kMultiple;
    if (!x.source_fits() || !y.source_fits()) return RowDefect::kSource;
    if (!x.first_shows() || !x.last_shows() || !y.first_shows() || !y.last_shows()) {
        return RowDefect::kDestination;
    }
    if (limits.buffer_pixels < least_buffer_pixels(row, limits.smoothing, limits.ready_space_pixels))
        return RowDefect::kBuffer;
    return RowDefect::kNone;
}

void TableJudge::clear() {
    result_ = ValidatedTable{};
    taken_.clear();
    next_index_ = 0;
}

void TableJudge::take(const ViewportRow& row) {
    const bool duplicate = taken_.count(row.dcomp) != 0;
    const RowDefect defect = duplicate ? RowDefect::kDuplicate : row_defect(row, limits_);
    if (defect == RowDefect::kNone) {
        taken_.insert(row.dcomp);
        result_.rows.push_back(row);
    } else {
        result_.rejected.push_back({next_index_, defect, message(row, limits_, defect)});
    }
    ++next_index_;
}

ValidatedTable validate_table(const ViewportTable& table, const ViewportLimits& limits) {
    TableJudge judge(limits);
    for (const ViewportRow& row : table) {
        judge.take(row);
    }
    return judge.result();
}

}  // namespace metabuffer
