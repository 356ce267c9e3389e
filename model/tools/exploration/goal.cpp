#include "tools/exploration/goal.h"

#include <optional>

#include "host/errors.h"
#include "host/text.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/sweep_plan.h"

namespace metabuffer::exploration {

std::function<Value(const std::string&)> values_in(const RunRecord& run) {
    return [&run](const std::string& name) -> Value {
        const std::optional<std::size_t> figure = figure_index(name);
        if (figure && *figure < run.figures.size()) return run.figures[*figure];
        const Setting* const setting = find_setting(run.settings, name);
        return setting == nullptr ? Value() : value_of_setting(setting->value);
    };
}

Goal::Goal(const std::string& text, const std::vector<std::string>& names, const std::string& where)
    : whole_(text, names, where) {
    try {
        for (const std::string& part : conjuncts(text)) parts_.emplace_back(part, names, "");
    } catch (const InputError&) {
        parts_.clear();  // an `and` of `between`: the goal is one part
        parts_.emplace_back(text, names, "");
    }
}

bool Goal::is_met_by(const RunRecord& run) const {
    return run.status == RunStatus::kDone && whole_.holds(values_in(run));
}

std::string Goal::missed_by(const RunRecord& run) const {
    if (!run.reason.empty()) return run.reason;
    const auto holds = [&run](const Expression& part) {
        try {
            return part.holds(values_in(run));
        } catch (const InputError&) {  // a text, which is neither true nor false where it stands alone
            return false;
        }
    };
    std::vector<std::string> figures;
    for (const Expression& part : parts_) {
        if (holds(part)) continue;
        for (const std::string& name : part.names()) {
            const std::optional<std::size_t> figure = figure_index(name);
            if (!figure || *figure >= run.figures.size()) continue;
            const std::string missing = name == kWhole ? missing_from_whole(run.figures) : "";
            figures.push_back(missing.empty() ? name + " " + text_of(run.figures[*figure]) : missing);
        }
    }
    return text::listed(figures);
}

}  // namespace metabuffer::exploration
