#include "scenario/scenario_keys.h"

#include <array>
#include <map>
#include <string>

#include "scenario/fault_keys.h"

namespace metabuffer {
namespace {

template <std::size_t Count>
WholeNumbers only(const std::array<int, Count>& values) {
    return {{values.front(), values.back()}, {values.begin(), values.end()}};
}

}  // namespace

const Schema& scenario_schema() {
    constexpr KeyShape kScalar = KeyShape::kScalar;
    constexpr KeyShape kMap = KeyShape::kMap;
    constexpr KeyShape kList = KeyShape::kList;
    static const Schema schema{
        "the scenario is empty; use at least the keys displays and renderers",
        {
            {"", kMap, "a map"},
            {"name", kScalar, "the scenario's name"},
            {"displays", kMap, "a map"},
            {"displays.columns", kScalar, "displays side by side"},
            {"displays.rows", kScalar, "displays one above the other"},
            {"displays.width", kScalar, "pixels of one display"},
            {"displays.height", kScalar, "pixels of one display"},
            {"displays.supersample", kScalar, "raster pixels per display pixel and axis"},
            {"displays.background", kList, "a list of three whole numbers 0 to 255, [R, G, B]"},
            {"displays.background[]", kScalar, "one of R, G, B"},
            {"composition", kScalar, "how a composer merges two pixels"},
            {"depth_format", kScalar, "the layout of a depth frame's pixel"},
            {"depth_range", kList, "a list of two numbers, [near, far]"},
            {"depth_range[]", kScalar, "near or far"},
            {"clocks", kMap, "a map"},
            {"clocks.core_mhz", kScalar, "MHz"},
            {"clocks.dvi_in_mhz", kScalar, "MHz"},
            {"clocks.dvi_out_mhz", kScalar, "MHz"},
            {"memory", kMap, "a map"},
            {"memory.page_words", kScalar, "words of an open page"},
            {"memory.page_miss_cycles", kScalar, "cycles to open a page"},
            {"memory.words_per_cycle", kScalar, "words per cycle of the open page"},
            {"bus", kMap, "a map"},
            {"bus.width_bits", kScalar, "bits"},
            {"bus.burst_pixels", kScalar, "most pixels of a burst"},
            {"bus.arbitration", kScalar, "who is next on the bus"},
            {"composer", kMap, "a map"},
            {"composer.buffer_pixels", kScalar, "pixels of the buffer"},
            {"composer.ready_space_pixels", kScalar, "free pixels at which a slot is taken"},
            {"composer.on_starvation", kScalar, "what happens when a pixel is late"},
            {"pacing", kScalar, "who waits for whom"},
            {"link_timeout_pairs", kScalar, "pair times"},
            {"watchdog_cycles", kScalar, "cycles, 0 for a value derived from the scenario"},
            {"frames", kScalar, "composited frames"},
            {"renderers", kList, "a list of renderers"},
            {"renderers[]", kMap, "a map"},
            {"renderers[].name", kScalar, "the renderer's name"},
            {"renderers[].copies", kScalar, "how many renderers of these frames"},
            {"renderers[].frames", kList, "a list of frames, each with an image and a viewport or a table"},
            {"renderers[].frames[]", kMap, "a map"},
            {"renderers[].frames[].image", kScalar, "a file name"},
            {"renderers[].frames[].depth", kScalar, "a file name"},
            {"renderers[].frames[].viewport", kMap, "a map"},
            {"renderers[].frames[].viewport.x", kScalar, "raster pixels"},
            {"renderers[].frames[].viewport.y", kScalar, "raster pixels"},
            {"renderers[].frames[].viewport.multiple", kScalar, "raster pixels per source pixel and axis"},
            {"renderers[].frames[].table", kList,
             "a list of rows, each [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]"},
            {"renderers[].frames[].table[]", kList,
             "a row of eight whole numbers, [Dcomp, Sx, Sy, Sdx, Sdy, Dx, Dy, Dmultiple]"},
            {"renderers[].frames[].table[][]", kScalar, "a field of a row"},
            {"faults", kList, "a list of faults"},
            {"faults[]", kMap, "a map"},
            {"faults[].renderer", kScalar, "a renderer's name"},
            {"faults[].pair", kScalar, "the pair's number, from 0"},
            {"faults[].kind", kScalar, "what goes wrong"},
            {"faults[].frame", kScalar, "which frame of the pair"},
            {"faults[].delay_pairs", kScalar, "pair times"},
            {"faults[].lines", kScalar, "scanlines"},
            {"faults[].byte", kScalar, "a byte of the control scanline, from 0"},
            {"faults[].bits", kScalar, "the bits to flip"},
            {"faults[].x", kScalar, "image pixels"},
            {"faults[].y", kScalar, "image pixels"},
            {"faults[].ppm", kScalar, "millionths that the clock is fast"},
            {"faults[].display", kScalar, "a display, from 1"},
            {"faults[].from_cycle", kScalar, "core cycle"},
            {"faults[].cycles", kScalar, "core cycles"},
            {"faults[].beats", kScalar, "beats"},
            {"faults[].of", kScalar, "which beats"},
            {"faults[].percent", kScalar, "per cent of the clocks"},
            {"faults[].seed", kScalar, "any whole number"},
        }};
    return schema;
}

std::optional<WholeNumbers> whole_numbers_of(std::string_view pattern) {
    static const std::map<std::string_view, WholeNumbers> numbers{
        {"displays.columns", {limits::kGridDisplays, {}}},
        {"displays.rows", {limits::kGridDisplays, {}}},
        {"displays.width", {limits::kDisplayPixels, {}}},
        {"displays.height", {limits::kDisplayPixels, {}}},
        {"displays.supersample", only(limits::kSupersamples)},
        {"displays.background[]", {limits::kChannel, {}}},
        {"memory.page_words", {limits::kPageWords, {}}},
        {"memory.page_miss_cycles", {limits::kPageMissCycles, {}}},
        {"memory.words_per_cycle", {limits::kWordsPerCycle, {}}},
        {"bus.width_bits", only(limits::kBusWidthsBits)},
        {"bus.burst_pixels", {limits::kBurstPixels, {}}},
        {"composer.buffer_pixels", {limits::kBufferPixels, {}}},
        {"composer.ready_space_pixels", {limits::kReadySpacePixels, {}}},
        {"link_timeout_pairs", {limits::kLinkTimeoutPairs, {}}},
        {"watchdog_cycles", {limits::kWatchdogCycles, {}}},
        {"frames", {limits::kFrames, {}}},
        {"renderers[].copies", {limits::kRendererCopies, {}}},
        {"renderers[].frames[].viewport.x", {limits::kViewportPosition, {}}},
        {"renderers[].frames[].viewport.y", {limits::kViewportPosition, {}}},
        {"renderers[].frames[].viewport.multiple", {limits::kViewportMultiple, {}}},
    };
    const std::string fault_list = "faults[].";
    if (pattern.substr(0, fault_list.size()) == fault_list) {
        const FaultKey* const key = find_fault_key(pattern.substr(fault_list.size()));
        if (key == nullptr || key->shape != FaultKey::Shape::kWholeNumber) return std::nullopt;
        return WholeNumbers{key->range, {}};
    }
    const auto found = numbers.find(pattern);
    return found == numbers.end() ? std::nullopt : std::optional<WholeNumbers>(found->second);
}

}  // namespace metabuffer
