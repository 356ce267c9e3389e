#include "segment_coverage.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <set>
#include <string>

#include "bin_names.h"
#include "datapath/segment.h"
#include "datapath/slot_table.h"
#include "scenario/limits.h"
#include "scenario/names.h"

namespace metabuffer::coverage {
namespace {

std::string multiple_name(int multiple) {
    constexpr int kSingle = 4;
    if (multiple <= kSingle || multiple == kMaximumMultiple) return std::to_string(multiple);
    if (multiple <= 8) return "5 to 8";
    return multiple <= 32 ? "9 to 32" : "33 to 254";
}

/// Raster lines between the segment's unclipped side and the raster's: negative if it is cut. In the order of kSides.
std::array<int, 4> distances(const ViewportRow& row, int raster_width, int raster_height) {
    return {row.dx, raster_width - (row.dx + row.sdx * row.dmultiple), row.dy,
            raster_height - (row.dy + row.sdy * row.dmultiple)};
}

void cover_sides(Coverage& coverage, const ViewportRow& row, const std::array<int, 4>& sides) {
    const char* group = "composer/segment-edges";
    const int multiple = row.dmultiple;
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const std::string side = kSides[i];
        const int distance = sides[i];
        coverage.hit_if(distance > 0, group, both(side, "inside"));
        coverage.hit_if(distance == 0, group, both(side, "touching"));
        coverage.hit_if(distance < 0, group, both(side, "cut through a pixel"));
        coverage.hit_if(distance < 0 && -distance == multiple - 1, group,
                        both(side, "all but one line of a pixel cut"));
        const bool phase = distance <= 0 && multiple > 1 && multiple <= kLargestPhasedMultiple;
        if (phase) coverage.hit("composer/phase", phase_name(multiple, side, -distance));
    }
}

void cover_segment(Coverage& coverage, const Scenario& scenario, const ViewportRow& row) {
    const int width = scenario.displays.raster_width_pixels();
    const int height = scenario.displays.raster_height_pixels();
    const Segment segment(row, width, height);
    const std::array<int, 4> sides = distances(row, width, height);
    const int multiple = row.dmultiple;
    coverage.hit("composer/replication", multiple_name(multiple));
    cover_sides(coverage, row, sides);
    const char* group = "composer/segment-edges";
    const int shown_width = segment.right() - segment.left();
    const int shown_height = segment.bottom() - segment.top();
    const bool whole = shown_width == width && shown_height == height;
    const auto cut = std::count_if(sides.begin(), sides.end(), [](int side) { return side < 0; });
    const auto inside = std::count_if(sides.begin(), sides.end(), [](int side) { return side > 0; });
    coverage.hit_if(whole && multiple == 1, group, "whole raster, pixel by pixel");
    coverage.hit_if(whole && multiple > 1, group, "whole raster, replicated");
    coverage.hit_if(whole && row.sdx * row.sdy == 1 && multiple > 1, "composer/replication",
                    "one source pixel covers the raster");
    coverage.hit_if(cut == 4, group, "cut on all four sides");
    coverage.hit_if(inside == 4, group, "touches no side");
    if (!whole) {
        coverage.hit_if(shown_width == 1 && shown_height == 1, group, "one raster pixel");
        coverage.hit_if(shown_width == 1 && shown_height > 1, group, "one raster column");
        coverage.hit_if(shown_width > 1 && shown_height == 1, group, "one raster row");
        coverage.hit_if(sides[0] <= 0 && sides[2] <= 0 && inside == 2, group, "in the top left corner only");
        coverage.hit_if(sides[1] <= 0 && sides[3] <= 0 && inside == 2, group,
                        "in the bottom right corner only");
    }
    const int s = scenario.displays.supersample;
    coverage.hit_if(s > 1 && (segment.left() % s != 0 || segment.top() % s != 0), "supersample",
                    "segment cuts through a display pixel");
    const char* buffer = "composer/buffer";
    const int capacity = scenario.composer.buffer_pixels;
    coverage.hit_if(capacity < segment.pixels(), buffer, "smaller than a segment");
    coverage.hit_if(capacity == segment.pixels(), buffer, "exactly a segment");
    coverage.hit_if(capacity > segment.pixels(), buffer, "larger than a segment");
    coverage.hit_if(multiple > 1 && capacity == row.sdx + scenario.composer.ready_space_pixels, buffer,
                    "no more than the widest replicated row and ready space");
}

/// What broke the rule of a row that was rejected for it.
void cover_defect(Coverage& coverage, const Scenario& scenario, const Renderer& renderer,
                  const ViewportRow& row, RowDefect defect) {
    const char* group = "table/rejected";
    coverage.hit(group, row_defect_key(defect));
    const int width = scenario.displays.raster_width_pixels();
    const int height = scenario.displays.raster_height_pixels();
    const int m = row.dmultiple;
    switch (defect) {
        case RowDefect::kDisplay:
            coverage.hit(group, row.dcomp == 0 ? "display 0" : "display beyond the last");
            break;
        case RowDefect::kMultiple:
            coverage.hit(group, m == 0 ? "Dmultiple 0" : "Dmultiple beyond 255");
            break;
        case RowDefect::kSource:
            coverage.hit_if(row.sdx == 0, group, "Sdx 0");
            coverage.hit_if(row.sdy == 0, group, "Sdy 0");
            coverage.hit_if(row.sx + row.sdx > renderer.image_width_pixels, group,
                            "source leaves the image in x");
            coverage.hit_if(row.sy + row.sdy > renderer.image_height_pixels, group,
                            "source leaves the image in y");
            coverage.hit_if(row.sx + row.sdx > limits::kUnsignedField.high, group,
                            "source end beyond 16 bits in x");
            coverage.hit_if(row.sy + row.sdy > limits::kUnsignedField.high, group,
                            "source end beyond 16 bits in y");
            break;
        case RowDefect::kDestination:
            coverage.hit_if(row.dx <= -m, group, "first pixel left of the raster");
            coverage.hit_if(row.dx >= width, group, "first pixel right of the raster");
            coverage.hit_if(row.dy <= -m, group, "first pixel above the raster");
            coverage.hit_if(row.dy >= height, group, "first pixel below the raster");
            coverage.hit_if(row.dx < width && row.dx + row.sdx * m >= width + m, group,
                            "last pixel right of the raster");
            coverage.hit_if(row.dy < height && row.dy + row.sdy * m >= height + m, group,
                            "last pixel below the raster");
            coverage.hit_if(row.dx + row.sdx * m > limits::kSignedField.high, group,
                            "destination end beyond 16 bits in x");
            coverage.hit_if(row.dy + row.sdy * m > limits::kSignedField.high, group,
                            "destination end beyond 16 bits in y");
            break;
        default:
            break;
    }
}

void cover_table_shape(Coverage& coverage, const Scenario& scenario, const ViewportTable& table,
                       const ValidatedTable& valid) {
    const char* group = "table/shape";
    coverage.hit_if(table.empty(), group, "no row");
    coverage.hit_if(!table.empty() && valid.rejected.empty(), group, "every row valid");
    coverage.hit_if(!table.empty() && valid.rows.empty(), group, "all rows rejected");
    coverage.hit_if(valid.rejected.size() > 1, group, "several rows rejected");
    std::set<RowDefect> defects;
    for (const RejectedRow& row : valid.rejected) {
        defects.insert(row.defect);
        coverage.hit_if(row.index == 0, group, "first row rejected");
        coverage.hit_if(row.index == static_cast<int>(table.size()) - 1, group, "last row rejected");
        const std::uint16_t display = table[static_cast<std::size_t>(row.index)].dcomp;
        coverage.hit_if(std::any_of(table.begin() + row.index + 1, table.end(),
                                    [&](const ViewportRow& later) {
                                        return later.dcomp == display &&
                                               std::find(valid.rows.begin(), valid.rows.end(), later) !=
                                                   valid.rows.end();
                                    }),
                        group, "valid row behind a rejected one of its display");
    }
    coverage.hit_if(defects.size() > 1, group, "several defects in one table");
    const auto displays = static_cast<std::size_t>(scenario.displays.count());
    coverage.hit_if(displays > 1 && valid.rows.size() == displays, group, "a row for each display");
    coverage.hit_if(!valid.rows.empty() && valid.rows.size() < displays, group, "no row for a display");
    coverage.hit_if(valid.rows.size() > 1 && std::is_sorted(valid.rows.rbegin(), valid.rows.rend(),
                                                            [](const ViewportRow& a, const ViewportRow& b) {
                                                                return a.dcomp < b.dcomp;
                                                            }),
                    group, "displays in falling order");
}

/// The shares Sdx / Dmultiple of a table's composers, and whether whole slots in those shares are too many.
void cover_shares(Coverage& coverage, const Scenario& scenario, const ViewportTable& rows) {
    const char* group = "bus/policy-composers";
    const std::string policy = to_string(scenario.bus.arbitration);
    if (rows.empty()) return;
    coverage.hit(group, both(policy, rows.size() == 1 ? "one" : rows.size() == 2 ? "two" : "three or more"));
    const bool shares = scenario.bus.arbitration == Arbitration::kIrsa ||
                        scenario.bus.arbitration == Arbitration::kSlotAllocation;
    if (!shares) return;
    std::int64_t scale = 1;
    for (const ViewportRow& row : rows) scale = std::lcm(scale, std::int64_t{row.dmultiple});
    std::int64_t divisor = 0;
    std::int64_t sum = 0;
    std::set<std::int64_t> weights;
    for (const ViewportRow& row : rows) {
        const std::int64_t weight = row.sdx * (scale / row.dmultiple);
        weights.insert(weight);
        divisor = std::gcd(divisor, weight);
        sum += weight;
    }
    coverage.hit_if(weights.size() > 1, "bus/arbitration", "slots in unequal shares");
    coverage.hit_if(sum / divisor > kSlotTableLimit, "bus/arbitration", "slots rounded beyond 256");
}

}  // namespace

void cover_table(Coverage& coverage, const Scenario& scenario, const Renderer& renderer,
                 const ViewportTable& table) {
    const ValidatedTable valid = validate_table(table, scenario.limits(renderer));
    for (const RejectedRow& row : valid.rejected) {
        cover_defect(coverage, scenario, renderer, table[static_cast<std::size_t>(row.index)], row.defect);
    }
    cover_table_shape(coverage, scenario, table, valid);
    cover_shares(coverage, scenario, valid.rows);
    for (const ViewportRow& row : valid.rows) cover_segment(coverage, scenario, row);
}

void cover_viewport(Coverage& coverage, const Scenario& scenario, const Renderer& renderer,
                    const RendererFrame& frame) {
    const char* group = "viewport/wall";
    const Viewport& viewport = *frame.viewport;
    const DisplayWall wall = scenario.displays.wall();
    const int right = viewport.x + renderer.image_width_pixels * viewport.multiple;
    const int bottom = viewport.y + renderer.image_height_pixels * viewport.multiple;
    const int wall_width = wall.columns * wall.raster_width_pixels;
    const int wall_height = wall.rows * wall.raster_height_pixels;
    if (frame.table.empty()) {
        coverage.hit(group, "outside altogether");
        return;
    }
    const std::array<int, 4> outside{-viewport.x, right - wall_width, -viewport.y, bottom - wall_height};
    for (std::size_t i = 0; i < outside.size(); ++i) {
        coverage.hit_if(outside[i] >= viewport.multiple, group, both(kSides[i], "source pixels outside"));
    }
    std::set<int> columns;
    std::set<int> rows;
    for (const ViewportRow& row : frame.table) {
        columns.insert((row.dcomp - 1) % wall.columns);
        rows.insert((row.dcomp - 1) / wall.columns);
    }
    coverage.hit_if(frame.table.size() == 1, group, "inside one display");
    coverage.hit_if(columns.size() > 1 && rows.size() == 1, group, "on displays side by side");
    coverage.hit_if(columns.size() == 1 && rows.size() > 1, group, "on displays above each other");
    coverage.hit_if(columns.size() > 1 && rows.size() > 1, group, "on four displays");
    for (const int column : columns) {
        const int edge = column * wall.raster_width_pixels;
        const bool inner = columns.count(column - 1) != 0;
        coverage.hit_if(inner && (edge - viewport.x) % viewport.multiple != 0, group,
                        "source pixel straddles two displays");
    }
}

}  // namespace metabuffer::coverage
