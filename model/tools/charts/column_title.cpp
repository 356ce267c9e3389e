#include "tools/charts/column_title.h"

#include <algorithm>

#include "tools/exploration/figures.h"

namespace metabuffer::charts {

namespace {

/// The only column that has a unit but is not a figure.
constexpr const char* kColumnOfSeconds = "wall_seconds";

std::string spaced(std::string name) {
    std::replace(name.begin(), name.end(), '_', ' ');
    return name;
}

}  // namespace

std::string column_title(const std::string& expression, const exploration::ResultsIdentity& identity) {
    if (expression == "smallest" && !identity.search_key.empty()) return "smallest " + identity.search_key;
    if (expression == kColumnOfSeconds) return "wall time (" + column_unit(expression) + ")";
    const std::optional<std::size_t> figure = exploration::figure_index(expression);
    if (!figure) return expression;
    const exploration::FigureKind& kind = exploration::figure_kinds()[*figure];
    const std::string name = spaced(kind.name);
    const std::string unit = column_unit(expression);
    const bool says_unit = name.find(unit) != std::string::npos || name.find(" per ") != std::string::npos;
    return says_unit ? name : name + " (" + unit + ")";
}

std::string column_unit(const std::string& column) {
    if (column == kColumnOfSeconds) return "s";
    const std::optional<std::size_t> figure = exploration::figure_index(column);
    return figure ? exploration::figure_kinds()[*figure].unit : "";
}

bool is_share(const std::string& expression) { return expression == "utilization"; }

}  // namespace metabuffer::charts
