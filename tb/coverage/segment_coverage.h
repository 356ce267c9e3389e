#pragma once

#include <array>
#include <cstdint>
#include <tuple>

#include "cover_group.h"
#include "scenario/scenario.h"
#include "shared_groups.h"

namespace metabuffer::coverage {

enum class Side : std::uint8_t { kLeft, kRight, kTop, kBottom };
constexpr std::array<Side, 4> kSides{Side::kLeft, Side::kRight, Side::kTop, Side::kBottom};

/// behind: the text after the side's name.
Axis<Side> sides(const std::string& behind);

struct ShareGoals : CoverGroup {
    explicit ShareGoals(Coverage& coverage) : CoverGroup(coverage, groups::kArbitration) {}
    Bin unequal = bin("slots in unequal shares");
    Bin rounded = bin("slots rounded beyond 256");
};

struct PolicyComposersGoals : CoverGroup {
    explicit PolicyComposersGoals(Coverage& coverage)
        : CoverGroup(coverage,
                     {"bus/policy-composers", "each arbitration with as many composers that have pixels"}) {}
    static constexpr int kMany = 3;
    Cross<Arbitration, int> composers{
        *this, every<Arbitration>(), {{1, "one"}, {2, "two"}, {kMany, "three or more"}}};
};

struct SegmentSizeGoals : CoverGroup {
    explicit SegmentSizeGoals(Coverage& coverage) : CoverGroup(coverage, groups::kBuffer) {}
    Bin smallest_legal = bin("the smallest with which a replicated row is valid");
    Bin smaller = bin("smaller than a segment");
    Bin exactly = bin("exactly a segment");
    Bin larger = bin("larger than a segment");
};

struct MultipleGoals : CoverGroup {
    explicit MultipleGoals(Coverage& coverage) : CoverGroup(coverage, groups::kReplication) {}
    Ranges multiple{*this,
                    {{1, "1"},
                     {2, "2"},
                     {3, "3"},
                     {4, "4"},
                     {5, "5 to 8"},
                     {9, "9 to 32"},
                     {33, "33 to 254"},
                     {kMaximumMultiple, "255"}}};
    Bin one_pixel_covers_raster = bin("one source pixel covers the raster");
};

/// Where each side of a segment can cut the blocks of its replicated pixels.
struct PhaseGoals : CoverGroup {
    explicit PhaseGoals(Coverage& coverage)
        : CoverGroup(coverage, {"composer/phase",
                                "how much of the outermost replicated pixels each side of the raster cuts"}) {
    }
    /// Up to this Dmultiple every way in which the raster can cut a replicated pixel is its own goal.
    static constexpr int kLargestMultiple = 4;
    using Phase = std::tuple<int, Side, int>;  ///< Dmultiple, side, raster lines cut
    static Axis<Phase> phases();
    Cross<Phase> cut{*this, phases()};
};

struct SmoothedSegmentGoals : CoverGroup {
    explicit SmoothedSegmentGoals(Coverage& coverage) : CoverGroup(coverage, groups::kSmoothing) {}
    Cross<Side> apron{*this, sides("source line beside the raster, mixed in")};
    Cross<Side> unused_apron{*this, sides("source line beside the raster that nothing needs")};
    Bin even = bin("even Dmultiple");
    Bin odd = bin("odd Dmultiple, with a raster line in the centre");
    Bin one_source_row = bin("a single source row");
    Bin one_source_column = bin("a single source column");
    Bin two_rows_at_top = bin("two source rows needed at the top");
    Bin least_buffer = bin("buffer of two source rows and the ready space");
};

struct SegmentEdgeGoals : CoverGroup {
    explicit SegmentEdgeGoals(Coverage& coverage)
        : CoverGroup(coverage, {"composer/segment-edges", "where segments lie on the raster"}) {}
    Cross<Side> inside{*this, sides("inside")};
    Cross<Side> touching{*this, sides("touching")};
    Cross<Side> cut{*this, sides("cut through a pixel")};
    Cross<Side> all_but_one_line_cut{*this, sides("all but one line of a pixel cut")};
    Bin whole_raster = bin("whole raster, pixel by pixel");
    Bin whole_raster_replicated = bin("whole raster, replicated");
    Bin cut_on_four_sides = bin("cut on all four sides");
    Bin one_pixel = bin("one raster pixel");
    Bin one_column = bin("one raster column");
    Bin one_row = bin("one raster row");
    Bin top_left_corner = bin("in the top left corner only");
    Bin bottom_right_corner = bin("in the bottom right corner only");
    Bin touches_no_side = bin("touches no side");
};

struct CutDisplayPixelGoals : CoverGroup {
    explicit CutDisplayPixelGoals(Coverage& coverage) : CoverGroup(coverage, groups::kSupersample) {}
    Bin by_segment = bin("segment cuts through a display pixel");
};

struct RejectedRowGoals : CoverGroup {
    explicit RejectedRowGoals(Coverage& coverage)
        : CoverGroup(coverage, {"table/rejected", "rows dropped, by defect and by what broke the rule"}) {}
    static Axis<RowDefect> defects();
    Cross<RowDefect> defect{*this, defects()};
    Bin display_0 = bin("display 0");
    Bin display_beyond = bin("display beyond the last");
    Bin multiple_0 = bin("Dmultiple 0");
    Bin multiple_beyond = bin("Dmultiple beyond 255");
    Bin sdx_0 = bin("Sdx 0");
    Bin sdy_0 = bin("Sdy 0");
    Bin source_leaves_in_x = bin("source leaves the image in x");
    Bin source_leaves_in_y = bin("source leaves the image in y");
    Bin first_left = bin("first pixel left of the raster");
    Bin first_right = bin("first pixel right of the raster");
    Bin first_above = bin("first pixel above the raster");
    Bin first_below = bin("first pixel below the raster");
    Bin last_right = bin("last pixel right of the raster");
    Bin last_below = bin("last pixel below the raster");
    Bin source_end_beyond_in_x = bin("source end beyond 16 bits in x");
    Bin source_end_beyond_in_y = bin("source end beyond 16 bits in y");
    Bin destination_end_beyond_in_x = bin("destination end beyond 16 bits in x");
    Bin destination_end_beyond_in_y = bin("destination end beyond 16 bits in y");
};

struct TableShapeGoals : CoverGroup {
    explicit TableShapeGoals(Coverage& coverage)
        : CoverGroup(coverage, {"table/shape", "tables as a whole"}) {}
    Bin no_row = bin("no row");
    Bin every_row_valid = bin("every row valid");
    Bin all_rejected = bin("all rows rejected");
    Bin several_rejected = bin("several rows rejected");
    Bin several_defects = bin("several defects in one table");
    Bin first_rejected = bin("first row rejected");
    Bin last_rejected = bin("last row rejected");
    Bin valid_behind_rejected = bin("valid row behind a rejected one of its display");
    Bin row_for_each_display = bin("a row for each display");
    Bin no_row_for_a_display = bin("no row for a display");
    Bin falling_order = bin("displays in falling order");
};

struct ViewportGoals : CoverGroup {
    explicit ViewportGoals(Coverage& coverage)
        : CoverGroup(coverage, {"viewport/wall", "where viewports lie on the wall"}) {}
    Cross<Side> pixels_outside{*this, sides("source pixels outside")};
    Bin one_display = bin("inside one display");
    Bin side_by_side = bin("on displays side by side");
    Bin above_each_other = bin("on displays above each other");
    Bin four_displays = bin("on four displays");
    Bin outside = bin("outside altogether");
    Bin straddling_pixel = bin("source pixel straddles two displays");
};

/// Goals of tables, their segments and the viewports that they are made of.
struct TableGoals : GoalSet {
    using GoalSet::GoalSet;
    ShareGoals shares{coverage};
    PolicyComposersGoals policy{coverage};
    SegmentSizeGoals size{coverage};
    MultipleGoals replication{coverage};
    PhaseGoals phase{coverage};
    SmoothedSegmentGoals smoothing{coverage};
    SegmentEdgeGoals edges{coverage};
    CutDisplayPixelGoals display_pixel{coverage};
    RejectedRowGoals rejected{coverage};
    TableShapeGoals shape{coverage};
    ViewportGoals viewport{coverage};
};

/// Counts what a table that was composited holds: its rows, where their segments lie, and what was rejected.
void cover_table(const TableGoals& goals, const Scenario& scenario, const Renderer& renderer,
                 const ViewportTable& table);

/// Counts where the viewport of a renderer's frame lies on the wall. The frame must have one.
void cover_viewport(const ViewportGoals& goals, const Scenario& scenario, const Renderer& renderer,
                    const RendererFrame& frame);

}  // namespace metabuffer::coverage
