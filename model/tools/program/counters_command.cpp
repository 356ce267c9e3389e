#include "tools/program/counters_command.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "report/counters.h"
#include "report/machine_cost.h"
#include "report/text_table.h"
#include "tlm/schedule_slices.h"
#include "tools/exploration/figures.h"

namespace metabuffer {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCountersFooter =
    "Counters are the keys of report.json, for each owner and in its totals. Figures are the columns of a\n"
    "sweep's results, for filters, goals and charts.\n"
    "Exit status: 0 done.";

template <typename Owner>
void list(TextTable& table) {
    for (const Counter<Owner>& counter : Counters<Owner>::kTable) {
        table.add({counter.name, Counters<Owner>::kOwners, counter.unit, counter.meaning});
    }
}

template <typename Owner>
void list(Json& json) {
    for (const Counter<Owner>& counter : Counters<Owner>::kTable) {
        json.push_back({{"name", counter.name},
                        {"owners", Counters<Owner>::kOwners},
                        {"unit", counter.unit},
                        {"total", counter.total == CounterTotal::kMost ? "most" : "sum"},
                        {"name_in_totals", counter.name_in_totals()},
                        {"meaning", counter.meaning}});
    }
}

template <typename List>
void list_all(List& to) {
    list<BusCounters>(to);
    list<RendererCounters>(to);
    list<ComposerCounters>(to);
    list<DisplayCounters>(to);
}

}  // namespace

CountersCommand::CountersCommand(CLI::App& program)
    : Command(program, "counters", "List what reports count and the figures of sweeps, with units") {
    command().add_flag("--json", json_, "As JSON");
    command().footer(kCountersFooter);
}

ExitStatus CountersCommand::execute() {
    if (json_) {
        Json counters = Json::array();
        list_all(counters);
        Json figures = Json::array();
        for (const exploration::FigureKind& kind : exploration::figure_kinds()) {
            figures.push_back({{"name", kind.name}, {"unit", kind.unit}, {"meaning", kind.meaning}});
        }
        Json costs = Json::array();
        for (const CostItem& item : cost_items()) {
            costs.push_back({{"name", item.name},
                             {"unit", item.unit},
                             {"meaning", item.meaning},
                             {"weight", item.weight}});
        }
        Json slices = Json::array();
        for (const tlm::SliceRow& row : tlm::kSliceTable) {
            Json arguments = Json::array();
            for (const std::string_view argument : row.arguments) {
                if (!argument.empty()) arguments.push_back(argument);
            }
            slices.push_back({{"name", row.name},
                              {"arguments", arguments},
                              {"colour", row.colour},
                              {"meaning", row.meaning}});
        }
        const Json all{{"counters", counters}, {"figures", figures}, {"costs", costs}, {"slices", slices}};
        std::cout << all.dump(2) << '\n';
        return kExitDone;
    }
    TextTable counters({0, 1, 2, 3});
    counters.add({"counter", "of all", "unit", "meaning"});
    list_all(counters);
    TextTable figures({0, 1, 2});
    figures.add({"figure", "unit", "meaning"});
    for (const exploration::FigureKind& kind : exploration::figure_kinds()) {
        figures.add({kind.name, kind.unit, kind.meaning});
    }
    std::cout << counters.text() << '\n' << figures.text();
    return kExitDone;
}

}  // namespace metabuffer
