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
    const std::size_t idle_bus_bits = figure_index(kIdleBusBits).value();
    if (idle_bus_bits < point.figures.size()) {
        const auto* const bits = std::get_if<std::int64_t>(&point.figures[idle_bus_bits]);
        if (bits != nullptr && *bits > 0) ++with_idle_bus_bits_;
    }
    if (point.status == RunStatus::kDone) return;
    ++failed_;
    failures_.emplace(number, point);
    if (failures_.size() > kKeptFailures) failures_.erase(std::prev(failures_.end()));
}

bool Outcomes::all_invalid() const {
    return counts_.empty() || (counts_.size() == 1 && counts_.count(RunStatus::kInvalid) == 1);
}

}  // namespace metabuffer::exploration
