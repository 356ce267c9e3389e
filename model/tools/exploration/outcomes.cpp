#include "tools/exploration/outcomes.h"

#include <iterator>
#include <variant>

#include "tools/exploration/figures.h"

namespace metabuffer::exploration {

void Outcomes::add(std::size_t number, const PointRecord& point) {
    ++counts_[point.status];
    if (!point.monotonic.value_or(true)) ++not_monotonic_;
    const std::size_t bottleneck = figure_index("bottleneck").value();
    if (bottleneck < point.figures.size()) {
        const auto* const name = std::get_if<std::string>(&point.figures[bottleneck]);
        if (name != nullptr) ++bottlenecks_[*name];
    }
    if (count_in(point.figures, kIdleBusBits) > 0) ++with_idle_bus_bits_;
    if (!point.figures.empty()) ++with_figures_;
    if (count_in(point.figures, kWhole) > 0) ++whole_;
    if (point.status == RunStatus::kDone) return;
    ++failed_;
    failures_.emplace(number, point);
    if (failures_.size() > kKeptFailures) failures_.erase(std::prev(failures_.end()));
}

bool Outcomes::all_invalid() const {
    return counts_.empty() || (counts_.size() == 1 && counts_.count(RunStatus::kInvalid) == 1);
}

}  // namespace metabuffer::exploration
