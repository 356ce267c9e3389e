#include "tools/program/level_run.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <utility>

#include "build_info/build_info.h"
#include "functional/functional_compositor.h"
#include "host/errors.h"
#include "host/text.h"
#include "report/machine_report.h"
#include "rtl/run.h"
#include "rtl/waveform_file.h"
#include "scenario/fault_kinds.h"
#include "scenario/link_program.h"
#include "scenario/scenario_writer.h"
#include "tlm/run.h"
#include "tlm/schedule_trace.h"
#include "tools/program/machine_check.h"
#include "tools/program/missing_event.h"
#include "tools/program/picture_check.h"
#include "tools/program/watchdog_lines.h"
#include "tools/program/wrong_pixel_record.h"

namespace metabuffer {
namespace {

/// Says what made a waveform: the program, and the scenario with every setting, renderer, viewport and fault. A
/// scenario that no file can hold has its settings only; a text beyond a megabyte is cut.
std::string waveform_header(const Scenario& scenario, const std::filesystem::path& waveform) {
    constexpr std::size_t kMostBytes = std::size_t{1} << 20;
    std::string content;
    try {
        content = effective_scenario(scenario, std::filesystem::absolute(waveform).parent_path());
    } catch (const InputError&) {
        for (const auto& [key, value] : scenario_settings(scenario)) {
            content += key;
            content += ": ";
            content += value;
            content += '\n';
        }
    }
    if (content.size() > kMostBytes) {
        content.resize(content.rfind('\n', kMostBytes) + 1);
        content += "# and more\n";
    }
    return "metabuffer " + build_version() + "\nscenario " + scenario.name + '\n' + content;
}

std::string clocks_text(const CycleSpan& range) {
    return std::to_string(range.first) + " to " + std::to_string(range.last);
}

/// What a trace's window lies around, found by a run before the run itself; nothing if the window has no event, or if an
/// error or the watchdog ends the run before it. Throws InputError if the run comes to its end without it.
std::optional<WindowEvent> find_event(const Scenario& scenario, const TraceWindow& window) {
    if (window.fixed_cycles()) return std::nullopt;
    const WindowSearch search = level_tlm_knows_clocks(scenario) ? tlm::find_event(scenario, window)
                                                                 : rtl::find_event(scenario, window);
    if (!search.event && search.whole_run) {
        throw InputError("--trace-window " + window.text + ": " + missing_event_text(scenario, window));
    }
    return search.event;
}

/// What a written trace shows.
std::string shown_text(const Scenario& scenario, const CycleSpan& shown, const TraceWindow& window,
                       const std::optional<WindowEvent>& event) {
    return "core clocks " + clocks_text(shown) +
           (event ? ", " + event_text(window, *event, scenario) : std::string());
}

void show(const RunFollower& follower, const DisplayedFrame& displayed,
          const std::vector<std::size_t>& wrong_pixels) {
    if (follower.on_picture) follower.on_picture(displayed.frame, displayed.display, displayed.picture);
    if (follower.on_shown) follower.on_shown(displayed, wrong_pixels);
}

RunReport run_functional(const Scenario& scenario, const RunFollower& follower) {
    RunReport report;
    report.scenario = scenario.name;
    report.level = to_string(RunLevel::kFunctional);
    report.core_mhz = scenario.clocks.core_mhz;
    for (const Renderer& renderer : scenario.renderers) report.renderers.emplace_back().name = renderer.name;
    report.displays.resize(static_cast<std::size_t>(scenario.displays.count()));
    report.corrected_displays = scenario.displays.corrected();
    functional::Compositor compositor(scenario);
    std::vector<int> pairs;
    for (int frame = 0; functional::take_pairs_without_time(scenario, frame, pairs); ++frame) {
        const auto pair = static_cast<std::uint32_t>(frame);
        for (std::size_t r = 0; r < pairs.size(); ++r) {
            const Renderer& renderer = scenario.renderers[r];
            RendererCounters& counters = report.renderers[r];
            if (const auto number = renderer.number_of_pair(pair);
                !number || pairs[r] != static_cast<int>(*number)) {
                ++counters.repeated_frames;
                continue;
            }
            const RendererFrame& entry = renderer.frame_of_pair(pair);
            const ValidatedTable table = validate_table(entry.table, scenario.limits(renderer));
            counters.add_rejected_rows(pair, table);
            counters.rejected_slot_tables += frame_slots(scenario, renderer, entry, table).rejected ? 1 : 0;
        }
        compositor.begin_frame(functional::contributions_of(scenario, pairs));
        for (int display = 1; display <= scenario.displays.count(); ++display) {
            if (!follower.on_picture && !follower.on_shown) continue;
            const ColourImage picture = compositor.picture(display);
            show(follower, {frame, display, picture, pairs}, {});
        }
        for (DisplayCounters& display : report.displays) ++display.frames_shown;
    }
    report.clamped_depths = clamped_depths(scenario);
    return report;
}

void run_rtl(const Scenario& scenario, const LevelRequest& request, const RunFollower& follower,
             MachineCheck* check, LevelOutcome& outcome) {
    rtl::RunOptions options;
    if (check != nullptr) {
        options.on_built = [check](rtl::Metabuffer& machine) { check->attach(machine); };
    }
    if (request.trace) {
        options.trace = rtl::TraceRequest{request.trace->file, request.trace->window, request.trace->blocks,
                                          waveform_header(scenario, request.trace->file),
                                          find_event(scenario, request.trace->window)};
    }
    WrongPixelRecord wrong_pixels(scenario);
    if (request.images) {
        options.on_frame_shown = [&](const DisplayedFrame& displayed) {
            show(follower, displayed, wrong_pixels.take(displayed));
        };
    }
    options.on_progress = follower.on_progress;
    rtl::RunResult result = rtl::run(scenario, options);
    if (request.images) wrong_pixels.put_into(result.report);
    outcome.report = std::move(result.report);
    outcome.simulation_seconds = result.simulation_seconds;
    if (!result.trace_note.empty()) outcome.trace_note = "no waveform: " + result.trace_note;
    if (!result.trace_warning.empty()) outcome.trace_note = "waveform: " + result.trace_warning;
    if (result.traced) {
        outcome.trace_line =
            "waveform " + request.trace->file + ": " +
            shown_text(scenario, *result.traced, request.trace->window, options.trace->event);
    }
}

/// If a block's own error ends the run, `outcome` keeps what was found before.
void run_checked_rtl(const Scenario& scenario, const LevelRequest& request, const RunFollower& follower,
                     LevelOutcome& outcome) {
    MachineCheck check(scenario);
    const auto keep = [&check, &outcome] {
        outcome.report.check = check.record();
        outcome.check_trace_options = check.trace_options();
    };
    try {
        run_rtl(scenario, request, follower, &check, outcome);
        check.finish(outcome.report);
    } catch (...) {
        keep();
        throw;
    }
    keep();
    outcome.compared = check.compared();
}

void run_tlm(const Scenario& scenario, const LevelRequest& request, const RunFollower& follower,
             LevelOutcome& outcome) {
    std::optional<PictureCheck> check;
    if (request.check) check.emplace(scenario);
    std::optional<tlm::ScheduleTrace> trace;
    std::optional<CycleSpan> window;
    std::optional<WindowEvent> event;
    if (request.trace) {
        trace.emplace(request.trace->file, scenario);
        const TraceWindow& wanted = request.trace->window;
        event = find_event(scenario, wanted);
        window = event ? wanted.around(event->cycles()) : wanted.fixed_cycles();
        if (!window) trace.reset();
        if (window && wanted.kind != TraceWindow::Kind::kAll) trace->show_only(*window);
    }
    tlm::RunOptions options;
    options.observer = trace ? &*trace : nullptr;
    options.images = request.images;
    WrongPixelRecord wrong_pixels(scenario);
    options.on_frame_shown = [&](const DisplayedFrame& displayed) {
        if (check) check->take(displayed.frame, displayed.display, displayed.picture);
        show(follower, displayed, wrong_pixels.take(displayed));
    };
    options.on_progress = follower.on_progress;
    tlm::RunResult result = tlm::run(scenario, options);
    if (request.images) wrong_pixels.put_into(result.report);
    outcome.report = std::move(result.report);
    outcome.simulation_seconds = result.simulation_seconds;
    if (check) {
        check->finish(outcome.report);
        outcome.report.check = check->record();
        outcome.compared = check->compared();
    }
    if (!request.trace) return;
    const auto shown = trace ? trace->finish(outcome.report.core_cycles) : std::nullopt;
    if (!window) {
        outcome.trace_note = "no schedule: what the schedule should show does not happen in this run";
    } else if (window->first >= outcome.report.core_cycles) {
        outcome.trace_note = "no schedule: the window begins at core clock " + std::to_string(window->first) +
                             ", and the run ends at " + std::to_string(outcome.report.core_cycles - 1);
    } else if (!shown) {
        outcome.trace_note = "no schedule: nothing happens in core clocks " + clocks_text(*window);
    } else {
        outcome.trace_line =
            "schedule " + request.trace->file + ": " +
            (request.trace->names_window ? shown_text(scenario, *shown, request.trace->window, event) + ", "
                                         : std::string()) +
            "to be opened at https://ui.perfetto.dev";
    }
}

}  // namespace

bool level_tlm_knows_clocks(const Scenario& scenario) {
    constexpr bool kReplacesBlocks = METABUFFER_REPLACES_BLOCKS != 0;
    return !kReplacesBlocks &&
           std::none_of(scenario.faults.begin(), scenario.faults.end(),
                        [](const Fault& fault) { return fault_traits(fault.kind).only_at_level_rtl(); });
}

void check_request(const LevelRequest& request) {
    if (!request.images && request.level == RunLevel::kFunctional) {
        throw InputError(
            "--no-images, --pictures none: level functional makes nothing but pictures; use --level tlm or "
            "rtl");
    }
    if (request.check && request.level == RunLevel::kFunctional) {
        throw InputError(
            "--check: level functional is what the others are checked against; use --level rtl or tlm");
    }
    if (request.check && !request.images && request.level == RunLevel::kTlm) {
        throw InputError("--check: level tlm makes no pictures to check with --no-images; use --level rtl");
    }
}

bool needs_pixels(const LevelRequest& request) { return request.images || request.level != RunLevel::kTlm; }

void run_level(const Scenario& scenario, const LevelRequest& request, const RunFollower& follower,
               LevelOutcome& outcome) {
    switch (request.level) {
        case RunLevel::kFunctional:
            outcome.report = run_functional(scenario, follower);
            break;
        case RunLevel::kTlm:
            run_tlm(scenario, request, follower, outcome);
            break;
        case RunLevel::kRtl:
            if (request.check) {
                run_checked_rtl(scenario, request, follower, outcome);
            } else {
                run_rtl(scenario, request, follower, nullptr, outcome);
            }
            break;
    }
}

std::string violations_text(const LevelOutcome& outcome, const std::string& file) {
    const std::optional<CheckRecord>& record = outcome.report.check;
    if (!record || record->violations == 0) return {};
    std::string text = file + ": --check: the model has broken a rule\n";
    for (const std::string& violation : record->first_violations) text += "  " + violation + '\n';
    const auto more = record->violations - static_cast<std::int64_t>(record->first_violations.size());
    if (more > 0) text += "  and " + std::to_string(more) + " more\n";
    if (!outcome.check_trace_options.empty()) {
        text += "  the first one's waveform: " + outcome.check_trace_options + '\n';
    }
    return text;
}

Judgement judge(const LevelOutcome& outcome, const std::string& file, bool strict) {
    const RunReport& report = outcome.report;
    Judgement judgement{kExitDone, violations_text(outcome, file)};
    if (!judgement.text.empty()) judgement.status = kExitDifferent;
    judgement.text += watchdog_lines(file, report);
    if (!report.watchdog.empty() && judgement.status == kExitDone) judgement.status = kExitWatchdog;
    if (judgement.status != kExitDone) return judgement;
    // The trace that was asked for cannot be had of this run.
    if (outcome.trace_line.empty() && !outcome.trace_note.empty()) judgement.status = kExitBadInput;
    if (strict && (report.total_starved_pixels() > 0 || report.total_stalled_cycles() > 0 ||
                   report.total_rejected() > 0)) {
        return {kExitStrict, file + ": --strict: " + std::to_string(report.total_starved_pixels()) +
                                 " pixels starved, " + std::to_string(report.total_stalled_cycles()) +
                                 " clocks stalled, " + std::to_string(report.total_rejected()) +
                                 " frames, rows or slot tables rejected\n"};
    }
    return judgement;
}

}  // namespace metabuffer
