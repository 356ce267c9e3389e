#include "tools/charts/column_title.h"

#include <algorithm>

#include "tools/exploration/figures.h"

namespace metabuffer::charts {

namespace {

std::string spaced(std::string name) {
    std::replace(name.begin(), name.end(), '_', ' ');
    return name;
}

}  // namespace

std::string column_title(const std::string& expression, const exploration::ResultsIdentity& identity) {
    if (expression == "smallest" && !identity.search_key.empty()) return "smallest " + identity.search_key;
    if (expression == "wall_seconds") return "wall time (s)";
    const std::optional<std::size_t> figure = exploration::figure_index(expression);
    if (!figure) return expression;
    const exploration::FigureKind& kind = exploration::figure_kinds()[*figure];
    const std::string name = spaced(kind.name);
    const std::string unit = kind.unit;
    const bool says_unit = name.find(unit) != std::string::npos || name.find(" per ") != std::string::npos;
    return says_unit ? name : name + " (" + unit + ")";
}

bool is_share(const std::string& expression) { return expression == "utilization"; }

}  // namespace metabuffer::charts
