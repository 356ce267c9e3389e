#include "segment_coverage.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <set>

#include "datapath/segment.h"
#include "datapath/slot_table.h"
#include "scenario/limits.h"

namespace metabuffer::coverage {
namespace {

/// Raster lines between the segment's unclipped side and the raster's: negative if it is cut. In the order of kSides.
std::array<int, 4> distances(const ViewportRow& row, int raster_width, int raster_height) {
    return {row.dx, raster_width - (row.dx + row.sdx * row.dmultiple), row.dy,
            raster_height - (row.dy + row.sdy * row.dmultiple)};
}

void cover_sides(const TableGoals& goals, const ViewportRow& row, const std::array<int, 4>& distances) {
    const SegmentEdgeGoals& edges = goals.edges;
    const int multiple = row.dmultiple;
    for (std::size_t i = 0; i < kSides.size(); ++i) {
        const Side side = kSides[i];
        const int distance = distances[i];
        edges.inside(side).hit_if(distance > 0);
        edges.touching(side).hit_if(distance == 0);
        edges.cut(side).hit_if(distance < 0);
        edges.all_but_one_line_cut(side).hit_if(distance < 0 && -distance == multiple - 1);
        const bool phase =
            distance <= 0 && multiple > 1 && multiple <= PhaseGoals::kLargestMultiple && -distance < multiple;
        if (phase) goals.phase.cut({multiple, side, -distance}).hit();
    }
}

/// sides: distances().
void cover_smoothing(const SmoothedSegmentGoals& goals, const Scenario& scenario, const ViewportRow& row,
                     const std::array<int, 4>& sides) {
    const int multiple = row.dmultiple;
    if (scenario.composer.smoothing != Smoothing::kBilinear || multiple == 1) return;
    for (std::size_t i = 0; i < kSides.size(); ++i) {
        const int beside = -sides[i] - multiple;  // raster lines of the line next to it that are cut
        if (beside < 0) continue;
        const bool mixed_in = beside < multiple / 2;
        goals.apron(kSides[i]).hit_if(mixed_in);
        goals.unused_apron(kSides[i]).hit_if(!mixed_in);
    }
    goals.even.hit_if(multiple % 2 == 0);
    goals.odd.hit_if(multiple % 2 == 1);
    goals.one_source_row.hit_if(row.sdy == 1);
    goals.one_source_column.hit_if(row.sdx == 1);
    const int above = row.dy < 0 ? -row.dy % multiple : 0;
    goals.two_rows_at_top.hit_if(row.dy < 0 && row.sdy > 1 && 2 * above + 1 != multiple);
    goals.least_buffer.hit_if(scenario.composer.buffer_pixels ==
                              2 * row.sdx + scenario.composer.ready_space_pixels);
}

void cover_segment(const TableGoals& goals, const Scenario& scenario, const ViewportRow& row) {
    const int width = scenario.displays.raster_width_pixels();
    const int height = scenario.displays.raster_height_pixels();
    const Segment segment(row, width, height, scenario.composer.smoothing);
    const std::array<int, 4> sides = distances(row, width, height);
    const int multiple = row.dmultiple;
    goals.replication.multiple(multiple).hit();
    cover_sides(goals, row, sides);
    cover_smoothing(goals.smoothing, scenario, row, sides);
    const SegmentEdgeGoals& edges = goals.edges;
    const int shown_width = segment.right() - segment.left();
    const int shown_height = segment.bottom() - segment.top();
    const bool whole = shown_width == width && shown_height == height;
    const auto cut = std::count_if(sides.begin(), sides.end(), [](int side) { return side < 0; });
    const auto inside = std::count_if(sides.begin(), sides.end(), [](int side) { return side > 0; });
    edges.whole_raster.hit_if(whole && multiple == 1);
    edges.whole_raster_replicated.hit_if(whole && multiple > 1);
    goals.replication.one_pixel_covers_raster.hit_if(whole && row.sdx * row.sdy == 1 && multiple > 1);
    edges.cut_on_four_sides.hit_if(cut == 4);
    edges.touches_no_side.hit_if(inside == 4);
    if (!whole) {
        edges.one_pixel.hit_if(shown_width == 1 && shown_height == 1);
        edges.one_column.hit_if(shown_width == 1 && shown_height > 1);
        edges.one_row.hit_if(shown_width > 1 && shown_height == 1);
        edges.top_left_corner.hit_if(sides[0] <= 0 && sides[2] <= 0 && inside == 2);
        edges.bottom_right_corner.hit_if(sides[1] <= 0 && sides[3] <= 0 && inside == 2);
    }
    const int s = scenario.displays.supersample;
    goals.display_pixel.by_segment.hit_if(s > 1 && (segment.left() % s != 0 || segment.top() % s != 0));
    const int capacity = scenario.composer.buffer_pixels;
    goals.size.smaller.hit_if(capacity < segment.pixels());
    goals.size.exactly.hit_if(capacity == segment.pixels());
    goals.size.larger.hit_if(capacity > segment.pixels());
    goals.size.smallest_legal.hit_if(multiple > 1 &&
                                     capacity == least_buffer_pixels(row, scenario.composer.smoothing,
                                                                     scenario.composer.ready_space_pixels));
}

/// Counts how a rejected row broke the rule.
void cover_defect(const RejectedRowGoals& goals, const Scenario& scenario, const Renderer& renderer,
                  const ViewportRow& row, RowDefect defect) {
    goals.defect(defect).hit();
    const int width = scenario.displays.raster_width_pixels();
    const int height = scenario.displays.raster_height_pixels();
    const int m = row.dmultiple;
    // Smoothed, one source line may lie beside the raster.
    const int besides = smoothing_reach(scenario.composer.smoothing, m) > 0 ? 2 : 1;
    const int least_x = -m * (row.sdx > 1 ? besides : 1);
    const int least_y = -m * (row.sdy > 1 ? besides : 1);
    switch (defect) {
        case RowDefect::kDisplay:
            (row.dcomp == 0 ? goals.display_0 : goals.display_beyond).hit();
            break;
        case RowDefect::kMultiple:
            (m == 0 ? goals.multiple_0 : goals.multiple_beyond).hit();
            break;
        case RowDefect::kSource:
            goals.sdx_0.hit_if(row.sdx == 0);
            goals.sdy_0.hit_if(row.sdy == 0);
            goals.source_leaves_in_x.hit_if(row.sx + row.sdx > renderer.image_width_pixels);
            goals.source_leaves_in_y.hit_if(row.sy + row.sdy > renderer.image_height_pixels);
            goals.source_end_beyond_in_x.hit_if(row.sx + row.sdx > limits::kUnsignedField.high);
            goals.source_end_beyond_in_y.hit_if(row.sy + row.sdy > limits::kUnsignedField.high);
            break;
        case RowDefect::kDestination:
            goals.first_left.hit_if(row.dx <= least_x);
            goals.first_right.hit_if(row.dx >= width);
            goals.first_above.hit_if(row.dy <= least_y);
            goals.first_below.hit_if(row.dy >= height);
            goals.last_right.hit_if(row.dx < width && row.dx + row.sdx * m >= width - least_x);
            goals.last_below.hit_if(row.dy < height && row.dy + row.sdy * m >= height - least_y);
            goals.destination_end_beyond_in_x.hit_if(row.dx + row.sdx * m > limits::kSignedField.high);
            goals.destination_end_beyond_in_y.hit_if(row.dy + row.sdy * m > limits::kSignedField.high);
            break;
        default:
            break;
    }
}

void cover_table_shape(const TableShapeGoals& goals, const Scenario& scenario, const ViewportTable& table,
                       const ValidatedTable& valid) {
    goals.no_row.hit_if(table.empty());
    goals.every_row_valid.hit_if(!table.empty() && valid.rejected.empty());
    goals.all_rejected.hit_if(!table.empty() && valid.rows.empty());
    goals.several_rejected.hit_if(valid.rejected.size() > 1);
    std::set<RowDefect> defects;
    for (const RejectedRow& row : valid.rejected) {
        defects.insert(row.defect);
        goals.first_rejected.hit_if(row.index == 0);
        goals.last_rejected.hit_if(row.index == static_cast<int>(table.size()) - 1);
        const std::uint16_t display = table[static_cast<std::size_t>(row.index)].dcomp;
        goals.valid_behind_rejected.hit_if(
            std::any_of(table.begin() + row.index + 1, table.end(), [&](const ViewportRow& later) {
                return later.dcomp == display &&
                       std::find(valid.rows.begin(), valid.rows.end(), later) != valid.rows.end();
            }));
    }
    goals.several_defects.hit_if(defects.size() > 1);
    const auto displays = static_cast<std::size_t>(scenario.displays.count());
    goals.row_for_each_display.hit_if(displays > 1 && valid.rows.size() == displays);
    goals.no_row_for_a_display.hit_if(!valid.rows.empty() && valid.rows.size() < displays);
    goals.falling_order.hit_if(
        valid.rows.size() > 1 &&
        std::is_sorted(valid.rows.rbegin(), valid.rows.rend(),
                       [](const ViewportRow& a, const ViewportRow& b) { return a.dcomp < b.dcomp; }));
}

/// The shares Sdx / Dmultiple of a table's composers, and whether whole slots in those shares are too many.
void cover_shares(const TableGoals& goals, const Scenario& scenario, const ViewportTable& rows) {
    if (rows.empty()) return;
    const int composers = std::min(static_cast<int>(rows.size()), PolicyComposersGoals::kMany);
    goals.policy.composers(scenario.bus.arbitration, composers).hit();
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
    goals.shares.unequal.hit_if(weights.size() > 1);
    goals.shares.rounded.hit_if(sum / divisor > kSlotTableLimit);
}

}  // namespace

Axis<Side> sides(const std::string& behind) {
    return {{Side::kLeft, "left, " + behind},
            {Side::kRight, "right, " + behind},
            {Side::kTop, "top, " + behind},
            {Side::kBottom, "bottom, " + behind}};
}

Axis<PhaseGoals::Phase> PhaseGoals::phases() {
    Axis<Phase> axis;
    for (int multiple = 2; multiple <= kLargestMultiple; ++multiple) {
        for (int cut = 0; cut < multiple; ++cut) {
            for (const auto& [side, name] : sides(std::to_string(cut) + " cut")) {
                axis.emplace_back(Phase{multiple, side, cut}, "x" + std::to_string(multiple) + ", " + name);
            }
        }
    }
    return axis;
}

Axis<RowDefect> RejectedRowGoals::defects() {
    Axis<RowDefect> axis;
    for (int i = 1; i < kRowDefectCount; ++i) {
        const auto defect = static_cast<RowDefect>(i);
        axis.emplace_back(defect, row_defect_key(defect));
    }
    return axis;
}

void cover_table(const TableGoals& goals, const Scenario& scenario, const Renderer& renderer,
                 const ViewportTable& table) {
    const ValidatedTable valid = validate_table(table, scenario.limits(renderer));
    for (const RejectedRow& row : valid.rejected) {
        cover_defect(goals.rejected, scenario, renderer, table[static_cast<std::size_t>(row.index)],
                     row.defect);
    }
    cover_table_shape(goals.shape, scenario, table, valid);
    cover_shares(goals, scenario, valid.rows);
    for (const ViewportRow& row : valid.rows) cover_segment(goals, scenario, row);
}

void cover_viewport(const ViewportGoals& goals, const Scenario& scenario, const Renderer& renderer,
                    const RendererFrame& frame) {
    const Viewport& viewport = *frame.viewport;
    const DisplayWall wall = scenario.displays.wall();
    const int right = viewport.x + renderer.image_width_pixels * viewport.multiple;
    const int bottom = viewport.y + renderer.image_height_pixels * viewport.multiple;
    const int wall_width = wall.columns * wall.raster_width_pixels;
    const int wall_height = wall.rows * wall.raster_height_pixels;
    if (frame.table.empty()) {
        goals.outside.hit();
        return;
    }
    const std::array<int, 4> outside{-viewport.x, right - wall_width, -viewport.y, bottom - wall_height};
    for (std::size_t i = 0; i < outside.size(); ++i) {
        goals.pixels_outside(kSides[i]).hit_if(outside[i] >= viewport.multiple);
    }
    std::set<int> columns;
    std::set<int> rows;
    for (const ViewportRow& row : frame.table) {
        columns.insert((row.dcomp - 1) % wall.columns);
        rows.insert((row.dcomp - 1) / wall.columns);
    }
    goals.one_display.hit_if(frame.table.size() == 1);
    goals.side_by_side.hit_if(columns.size() > 1 && rows.size() == 1);
    goals.above_each_other.hit_if(columns.size() == 1 && rows.size() > 1);
    goals.four_displays.hit_if(columns.size() > 1 && rows.size() > 1);
    for (const int column : columns) {
        const int edge = column * wall.raster_width_pixels;
        const bool inner = columns.count(column - 1) != 0;
        goals.straddling_pixel.hit_if(inner && (edge - viewport.x) % viewport.multiple != 0);
    }
}

}  // namespace metabuffer::coverage
