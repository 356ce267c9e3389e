#include "goals.h"

#include <map>
#include <stdexcept>
#include <utility>

#include "bin_names.h"
#include "report/report.h"
#include "rtl/handshake.h"
#include "scenario/limits.h"
#include "scenario/names.h"

namespace metabuffer::coverage {
namespace {

using Names = std::vector<std::string>;

/// Every name of one list with every name of the other.
Names cross(const Names& left, const Names& right) {
    Names names;
    for (const std::string& a : left) {
        for (const std::string& b : right) names.push_back(a + ", " + b);
    }
    return names;
}

Names joined(Names names, const Names& more) {
    names.insert(names.end(), more.begin(), more.end());
    return names;
}

Names widths() {
    Names names;
    for (const int bits : limits::kBusWidthsBits) names.push_back(width_name(bits));
    return names;
}

Names defects() {
    Names names;
    for (int defect = 1; defect < kRowDefectCount; ++defect) {
        names.emplace_back(row_defect_key(static_cast<RowDefect>(defect)));
    }
    return names;
}

Names causes() {
    Names names;
    for (int cause = 0; cause < kRejectCauseCount; ++cause) {
        names.emplace_back(reject_cause_key(static_cast<RejectCause>(cause)));
    }
    return names;
}

Names numbers(int first, int last, const std::string& what) {
    Names names;
    for (int number = first; number <= last; ++number) names.push_back(std::to_string(number) + what);
    return names;
}

/// Where each side of a segment can cut the blocks of its replicated pixels.
Names phases() {
    Names names;
    for (int multiple = 2; multiple <= kLargestPhasedMultiple; ++multiple) {
        for (const char* side : kSides) {
            for (int cut = 0; cut < multiple; ++cut) names.push_back(phase_name(multiple, side, cut));
        }
    }
    return names;
}

std::vector<GoalGroup> bus_groups() {
    const Names policies = enum_names<Arbitration>();
    return {
        {"bus/policy-width-ratio",
         "frames for which composers competed for a bus: arbitration, width, display clock, starvation",
         cross(cross(cross(policies, widths()), Names(kClockRatios.begin(), kClockRatios.end())),
               enum_names<StarvationMode>())},
        {"bus/policy-composers", "each arbitration with as many composers that have pixels",
         cross(policies, {"one", "two", "three or more"})},
        {"bus/arbitration", "what each arbitration can answer",
         joined(cross(policies, {"poll", "the same composer twice running"}),
                {"irsa, slots recovered", "round-robin, slots recovered", "slot-allocation, slot lost",
                 "slots in unequal shares", "slots rounded beyond 256"})},
        {"bus/beat", "pixels in a beat, and what limits them",
         joined(numbers(1, limits::kWordsPerCycle.high, " at a time"),
                {"4 clocks a pixel", "2 clocks a pixel", "bus limits", "memory limits", "bus equals memory",
                 "beat not full at the burst's end", "beat not full at a page's end"})},
        {"bus/burst",
         "how a burst runs and ends",
         {"whole", "cut by BUSREADY", "shorter at the segment's end", "of one pixel", "of one beat",
          "of several beats", "over a source row's end", "over a page's end", "page miss before it",
          "page miss in mid burst", "page open before it", "right behind another",
          "carries the whole segment", "pixels of several source rows in a beat"}},
        {"bus/busready-drop", "where in a burst a composer takes BUSREADY back",
         joined({"behind the first beat", "in the middle", "when one beat more would end it",
                 "behind the last beat: no further slot", "behind a burst of one beat: no further slot",
                 "rest fits a beat: burst goes on, no further slot", "two bursts of a composer running",
                 "two composers running", "on a bus of several clocks a pixel", "segment is replicated",
                 "frame is composited", "frame is only prefetched"},
                policies)},
        {"bus/table",
         "tables on the bus",
         {"empty", "of one row", "of several rows", "row of several clocks", "row of one clock",
          "waits for TABLEREADY", "goes at once", "changes from the frame before", "the same as before",
          "rows in another order than displays"}},
        {"memory/words", "words that the memory reads in a clock",
         numbers(1, limits::kWordsPerCycle.high, "")},
        {"memory/page",
         "pages of the frame memory",
         {"miss costs nothing", "miss costs 1 clock", "miss costs more", "of one word",
          "smaller than a beat could be", "smaller than a burst", "larger than a burst",
          "larger than the image", "burst in three pages or more"}},
    };
}

std::vector<GoalGroup> composer_groups() {
    const Names sides(kSides.begin(), kSides.end());
    const Names relations{"local nearer", "local farther", "tie"};
    const Names alphas{"A 0", "A 255", "A between"};
    return {
        {"composer/buffer",
         "states of the buffer",
         {"empty when a pixel is needed", "empty while its segment is composited", "full", "exactly one free",
          "pixel in and pixel out in a clock", "write address wraps", "read address wraps",
          "row of a window lies across the wrap", "two frames' pixels at once", "smallest legal size",
          "one pixel beyond a burst", "no more than the widest replicated row and ready space",
          "smaller than a segment", "exactly a segment", "larger than a segment",
          "ready space is in-flight only", "ready space is more than a burst"}},
        {"composer/late",
         "pixels that come too late",
         {"behind their last use", "of a frame that is over", "behind a replicated pixel's last repetition"}},
        {"composer/replication",
         "Dmultiple of segments that are composited",
         {"1", "2", "3", "4", "5 to 8", "9 to 32", "33 to 254", "255", "source row read again",
          "one source pixel covers the raster", "repetitions of a pixel starve, later ones do not"}},
        {"composer/phase", "how much of the outermost replicated pixels each side of the raster cuts",
         phases()},
        {"composer/segment-edges", "where segments lie on the raster",
         joined(
             cross(sides, {"inside", "touching", "cut through a pixel", "all but one line of a pixel cut"}),
             {"whole raster, pixel by pixel", "whole raster, replicated", "cut on all four sides",
              "one raster pixel", "one raster column", "one raster row", "in the top left corner only",
              "in the bottom right corner only", "touches no side"})},
        {"viewport/wall", "where viewports lie on the wall",
         joined(cross(sides, {"source pixels outside"}),
                {"inside one display", "on displays side by side", "on displays above each other",
                 "on four displays", "outside altogether", "source pixel straddles two displays"})},
        {"compose/z", "local and upstream pixel, in each composition",
         cross(enum_names<Composition>(), relations)},
        {"compose/alpha", "A of the local pixel, in each composition",
         cross(enum_names<Composition>(), alphas)},
        {"compose/front", "over: which pixel is in front, with which A",
         joined(cross({"local in front", "upstream in front"}, alphas), {"channel saturates"})},
        {"compose/depth-format", "local and upstream pixel, in each depth format",
         cross(enum_names<DepthFormat>(), relations)},
        {"compose/depth",
         "extreme depths and what is upstream",
         {"local at Z 0", "local far", "tie at Z 0", "tie far with the background",
          "tie between two renderers", "differ in the lowest bit", "upstream is background",
          "upstream is another renderer's", "three renderers at one raster pixel"}},
        {"starvation/mode", "what starves does, under each arbitration",
         joined(cross(enum_names<Arbitration>(), {"starved in glitch", "stalled in stall"}),
                {"glitch without starving", "stall without stalling"})},
        {"starvation/place",
         "where pixels starve (glitch)",
         {"last of a segment", "in between", "last raster pixel", "whole raster row of a segment",
          "repetition of a replicated pixel", "in the top composer", "in the bottom composer",
          "two composers of a column at one raster pixel", "in the first frame", "in a later frame"}},
        {"stall",
         "how a column stands still (stall)",
         {"for the last raster pixel", "for the last of a segment", "for one clock", "for 2 to 8 clocks",
          "for more than 8 clocks", "two composers at once", "top composer", "bottom composer",
          "composer in between", "bus sends nothing", "bus opens a page", "bus sends to another composer",
          "again after one clock", "STARTFRAME stands still", "one column while another runs",
          "all columns at once", "next frame's table comes"}},
    };
}

std::vector<GoalGroup> frame_groups() {
    return {
        {"pipeready",
         "when a composer raises PIPEREADY",
         {"waited for below", "waited for the prefetch", "both in the same clock",
          "segment wholly in the buffer", "buffer takes no further slot", "segment empty", "table comes last",
          "single composer in the column", "columns at the same clock", "columns at different clocks"}},
        {"frames/sequence",
         "how frames follow each other",
         {"all prefetched before PIPEREADY from below",
          "back to back: STARTFRAME at the earliest clock behind a frame", "three frames back to back",
          "columns start at the same clock", "columns start apart", "columns end apart",
          "table comes while compositing", "pixels of the next frame come while compositing",
          "next frame wholly prefetched while compositing", "next frame prefetched in part while compositing",
          "segment where none was", "no segment where one was", "segment moved",
          "no renderer covers a display", "one frame", "two frames", "three frames or more",
          "raster of one pixel", "frame shorter than the column"}},
        {"table/rejected", "rows dropped, by defect and by what broke the rule",
         joined(defects(), {"display 0", "display beyond the last", "Dmultiple 0", "Dmultiple beyond 255",
                            "Sdx 0", "Sdy 0", "source leaves the image in x", "source leaves the image in y",
                            "first pixel left of the raster", "first pixel right of the raster",
                            "first pixel above the raster", "first pixel below the raster",
                            "last pixel right of the raster", "last pixel below the raster",
                            "source end beyond 16 bits in x", "source end beyond 16 bits in y",
                            "destination end beyond 16 bits in x", "destination end beyond 16 bits in y"})},
        {"table/shape",
         "tables as a whole",
         {"no row", "every row valid", "all rows rejected", "several rows rejected",
          "several defects in one table", "first row rejected", "last row rejected",
          "valid row behind a rejected one of its display", "a row for each display", "no row for a display",
          "displays in falling order"}},
        {"link/rejected", "frames and pairs rejected, by cause and fault",
         joined(cross(causes(), {"colour frame", "depth frame"}),
                {"first pair", "later pair", "last pair", "good pair behind it", "two pairs running",
                 "two renderers in a frame", "in lockstep", "free-running"})},
        {"link/pacing",
         "what the link answers",
         {"lockstep, fresh", "lockstep, again at the timeout", "lockstep, again as the pair is lost",
          "lockstep, again as a later pair is there", "lockstep, pair too late dropped",
          "lockstep, bus waits for the link", "lockstep, link waits for the bus",
          "lockstep, nothing before the first pair", "free-running, fresh", "free-running, again",
          "free-running, overwritten pair dropped", "free-running, waits for the pair under way",
          "free-running, nothing before the first pair", "free-running, drops and repeats in one run"}},
        {"link/timing", "pixel clocks beside the core clock",
         joined(cross({"DVI in slower", "DVI in equal", "DVI in faster"},
                      {"DVI out slower", "DVI out equal", "DVI out faster"}),
                {"DVI in no whole multiple", "DVI out no whole multiple", "DVI in whole multiple",
                 "DVI out whole multiple", "three different clocks", "DVI in and out share a clock"})},
        {"display/swap",
         "how displays take over a frame",
         {"single display", "waits for the slowest column", "all columns done at one clock",
          "first column last", "last column last", "SWAPLOCK comes during a displayed frame",
          "a DVI frame for each frame", "frame displayed twice", "frame displayed three times or more",
          "black before the first", "several DVI frames before the first", "kept as pixels were lost",
          "swapped after one that was kept"}},
        {"supersample",
         "averaging",
         {"1", "2", "4", "2, exact", "2, down", "2, half up", "2, up", "4, exact", "4, down", "4, half up",
          "4, up", "with z", "with z-alpha-key", "with over", "segment cuts through a display pixel"}},
    };
}

std::vector<GoalGroup> machine_groups() {
    return {
        {"machine/shape",
         "renderers and displays",
         {"1 renderer", "2 renderers", "3 renderers", "4 renderers", "5 renderers or more", "1 display",
          "displays in a row", "displays in a column", "displays in a grid", "display of one pixel",
          "display one pixel wide", "display one pixel high", "raster higher than wide",
          "raster wider than high", "renderers of different image sizes", "renderer that no display shows",
          "image changes between pairs", "frames beyond a renderer's list"}},
        {"machine/modes", "modes that meet",
         joined(joined(cross(enum_names<Pacing>(), enum_names<StarvationMode>()),
                       cross(enum_names<Composition>(), enum_names<DepthFormat>())),
                cross(enum_names<Pacing>(), enum_names<Arbitration>()))},
        {"watchdog",
         "the watchdog",
         {"silent in a whole run", "interval derived", "interval given", "ends a run",
          "names an input framebuffer", "names a composer", "names an output framebuffer",
          "trips before the first frame is shown", "trips after a frame was shown"}},
        {"faults/kind", "faults injected, in a run that came to its end or to the watchdog",
         enum_names<FaultKind>()},
        {"faults/handshake", "handshakes that a fault holds low though they are raised, or, STALL, high",
         enum_names<rtl::Handshake>()},
        {"faults/place",
         "where faults strike",
         {"first pair", "last pair", "pair in between", "two faults in a run", "two renderers at once",
          "in lockstep", "free-running", "in glitch", "in stall", "pixels lost on a bus",
          "table lost on a bus", "frame kept off the displays", "good frame shown behind a faulty one",
          "silence shorter than the timeout", "silence longer than the timeout", "clock drifts fast",
          "clock drifts slow"}},
        {"faults/lost-beat", "beats lost on the way to a composer", enum_names<LostBeats>()},
        {"faults/lost-table",
         "what of a table is lost first, and what tells the composer",
         {"start, told by a row", "start, told by pixels", "start, told by the next frame's start",
          "rows, told by a row", "rows, told by pixels", "rows, told by the next frame's start",
          "several frames"}},
    };
}

std::vector<GoalGroup> all_groups() {
    std::vector<GoalGroup> groups = bus_groups();
    for (auto& more : {composer_groups(), frame_groups(), machine_groups()}) {
        groups.insert(groups.end(), more.begin(), more.end());
    }
    return groups;
}

/// Place of each goal by group and bin.
using GoalIndex = std::map<std::string, std::map<std::string, std::size_t, std::less<>>, std::less<>>;

GoalIndex make_index() {
    GoalIndex index;
    std::size_t place = 0;
    for (const GoalGroup& group : goal_groups()) {
        auto& bins = index[group.name];
        for (const std::string& bin : group.bins) {
            if (!bins.emplace(bin, place++).second) {
                throw std::logic_error("goal \"" + group.name + ": " + bin + "\" is there twice");
            }
        }
    }
    return index;
}

/// None is written as goal_count().
std::size_t find_goal(std::string_view group, std::string_view bin) {
    static const GoalIndex index = make_index();
    const auto bins = index.find(group);
    if (bins == index.end()) return goal_count();
    const auto place = bins->second.find(bin);
    return place == bins->second.end() ? goal_count() : place->second;
}

}  // namespace

const std::vector<GoalGroup>& goal_groups() {
    static const std::vector<GoalGroup> groups = all_groups();
    return groups;
}

std::size_t goal_count() {
    static const std::size_t count = [] {
        std::size_t sum = 0;
        for (const GoalGroup& group : goal_groups()) sum += group.bins.size();
        return sum;
    }();
    return count;
}

bool is_goal(std::string_view group, std::string_view bin) { return find_goal(group, bin) < goal_count(); }

std::size_t goal_index(std::string_view group, std::string_view bin) {
    const std::size_t goal = find_goal(group, bin);
    if (goal == goal_count()) {
        throw std::logic_error("there is no goal \"" + std::string(group) + ": " + std::string(bin) + "\"");
    }
    return goal;
}

}  // namespace metabuffer::coverage
