#include "tlm_run.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>

#include "random_scenario.h"
#include "report/report_difference.h"

namespace metabuffer::test {
namespace {

constexpr std::size_t kMostLines = 20;

void append(std::vector<std::string>& lines, const std::vector<std::string>& more) {
    lines.insert(lines.end(), more.begin(), more.end());
}

void append_picture_differences(std::vector<std::string>& lines, const MachineRun& rtl, const TlmRun& tlm,
                                const ComparedNames& names) {
    for (int frame = 0; frame < rtl.scenario().frames; ++frame) {
        for (int display = 1; display <= rtl.scenario().displays.count(); ++display) {
            const int times = tlm.pictures().times_shown(frame, display);
            if (times > (tlm.has_images() ? 1 : 0)) {
                lines.push_back("display_" + std::to_string(display) + " frame " + std::to_string(frame) +
                                ": shown " + std::to_string(times) + " times by " + names.right);
            }
            if (!tlm.has_images()) continue;
            const auto difference = picture_difference(display, frame, rtl.picture(frame, display),
                                                       tlm.pictures().picture(frame, display), names);
            if (difference) lines.push_back(*difference);
        }
    }
}

std::vector<std::string> event_differences(const WindowEvents& left, const WindowEvents& right,
                                           const ComparedNames& names) {
    std::vector<std::string> lines;
    for (const auto& [window, cycles] : left) {
        const std::string& other = right.at(window);
        if (cycles == other) continue;
        lines.push_back("--trace-window " + window + ": " + cycles + " (" + names.left + ") and " + other +
                        " (" + names.right + ")");
    }
    return lines;
}

}  // namespace

TlmRun::TlmRun(const std::string& name, Scenario scenario, bool images)
    : scenario_(std::move(scenario)), has_images_(images), shown_(scenario_) {
    tlm::Metabuffer::Options options;
    options.images = images;
    machine_ = std::make_unique<tlm::Metabuffer>(name.c_str(), scenario_, options);
    machine_->on_frame_shown([this](const DisplayedFrame& displayed) {
        shown_.take(displayed.frame, displayed.display, displayed.picture);
    });
    machine_->on_finished([this] {
        report_ = machine_->report();
        window_events_ = window_events_of(*machine_, scenario_.frames);
    });
}

LevelRuns::LevelRuns(const std::string& name, const Scenario& scenario)
    : rtl(std::make_unique<MachineRun>(name + "_rtl", scenario)),
      tlm(std::make_unique<TlmRun>(name + "_tlm", scenario)),
      counters_only(std::make_unique<TlmRun>(name + "_counters", scenario, false)) {}

bool run_to_end(const TlmRuns& runs) {
    return simulate_until([&runs] {
        return std::all_of(runs.begin(), runs.end(), [](const auto& run) { return run->finished(); });
    });
}

bool run_to_end(const std::vector<LevelRuns>& runs) {
    std::vector<rtl::Metabuffer*> machines;
    for (const LevelRuns& run : runs) machines.push_back(&run.rtl->machine());
    const bool ended = run_to_end(machines);
    for (const LevelRuns& run : runs) run.rtl->read_drained_report();
    return simulate_until([&runs] {
               return std::all_of(runs.begin(), runs.end(), [](const LevelRuns& run) {
                   return run.tlm->finished() && run.counters_only->finished();
               });
           }) &&
           ended;
}

std::vector<std::string> level_differences(const MachineRun& rtl, const TlmRun& tlm) {
    const ComparedNames names{"rtl", tlm.has_images() ? "tlm" : "tlm without images"};
    std::vector<std::string> lines;
    if (!rtl.finished()) lines.push_back(names.left + " does not come to its end");
    if (!tlm.finished()) lines.push_back(names.right + " does not come to its end");
    if (!lines.empty()) return lines;
    append(lines, compare_reports(report_json(rtl.report()), report_json(tlm.report()), names).differences);
    append(lines, event_differences(rtl.window_events(), tlm.window_events(), names));
    append_picture_differences(lines, rtl, tlm, names);
    return lines;
}

std::vector<std::string> level_differences(const LevelRuns& runs) {
    std::vector<std::string> lines = level_differences(*runs.rtl, *runs.tlm);
    append(lines, level_differences(*runs.rtl, *runs.counters_only));
    return lines;
}

void check_levels(const LevelRuns& runs) {
    INFO(describe(runs.rtl->scenario()));
    const std::vector<std::string> differences = level_differences(runs);
    INFO(first_lines(differences));
    CHECK(differences.empty());
}

std::string first_lines(const std::vector<std::string>& lines) {
    std::string text;
    for (std::size_t i = 0; i < std::min(lines.size(), kMostLines); ++i) text += lines[i] + "\n";
    if (lines.size() > kMostLines) text += "... and " + std::to_string(lines.size() - kMostLines) + " more\n";
    return text;
}

}  // namespace metabuffer::test
