#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "report/report.h"
#include "scenario/scenario.h"
#include "tools/exploration/value.h"

namespace metabuffer::exploration {

/// One figure of a run. Filters, goals, tables and charts use its name.
struct FigureKind {
    const char* name;     ///< "starved_pixels": a column of the results
    const char* unit;     ///< "pixels", "clocks", "frames/s", "bits", "" for a ratio
    std::string meaning;  ///< one line for --help and documentation
};

/// The machine's cost in one number. A sweep may define it in another way.
constexpr const char* kCost = "cost";
/// Whether the pictures show all that renderers had to send: what an architect wants of a machine.
constexpr const char* kWhole = "whole";
/// The only figure for which a run has to make pictures.
constexpr const char* kWrongPixels = "wrong_pixels";
/// Above 0 in points whose buses are wider than memory fills: a narrower bus does the same.
constexpr const char* kIdleBusBits = "idle_bus_bits";

/// Every figure, in the order of the results' columns: what a run is asked for and its rates, the totals of every
/// counter (report/counters.h), and the cost of the machine.
const std::vector<FigureKind>& figure_kinds();

/// A figure that is a whole number, by its name; 0 if the run has none.
std::int64_t count_in(const std::vector<Value>& figures, const char* name);

/// What keeps a run's pictures from being whole: "starved_pixels 7, rejected_rows 1". Empty if nothing does.
std::string missing_from_whole(const std::vector<Value>& figures);

/// The index of the figure of that name in that order; empty if there is no such figure.
std::optional<std::size_t> figure_index(const std::string& name);

/// The figures of a run, in that order. A figure that the run does not have is nothing.
std::vector<Value> figures_of(const RunReport& report, const Scenario& scenario);

}  // namespace metabuffer::exploration
