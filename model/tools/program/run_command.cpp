#include "tools/program/run_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "build_info/build_info.h"
#include "functional/functional_compositor.h"
#include "host/errors.h"
#include "host/text.h"
#include "report/report.h"
#include "rtl/run.h"
#include "rtl/waveform_file.h"
#include "scenario/fault_kinds.h"
#include "scenario/link_program.h"
#include "scenario/scenario_writer.h"
#include "tlm/run.h"
#include "tlm/schedule_trace.h"
#include "tools/program/machine_check.h"
#include "tools/program/output_guard.h"
#include "tools/program/picture_check.h"
#include "tools/program/progress_line.h"
#include "tools/program/result_folder.h"
#include "tools/program/watchdog_lines.h"
#include "tools/program/wrong_pixel_record.h"

namespace metabuffer {
namespace {

constexpr const char* kRtl = "rtl";
constexpr const char* kTlm = "tlm";
constexpr const char* kFunctional = "functional";
constexpr const char* kScheduleExtension = ".json";

constexpr const char* kRunFooter =
    "Levels tlm and rtl give the same pictures and counters; rtl goes clock by clock, has every signal and "
    "takes\n"
    "longer. metabuffer compare runs both.\n"
    "Examples:\n"
    "  metabuffer run scenarios/paper-figure.yaml\n"
    "  metabuffer run scenarios/paper-figure.yaml --set bus.width_bits=64 --trace out/schedule.json\n"
    "  metabuffer run scenarios/paper-figure-starved.yaml --trace out/trace.vcd \\\n"
    "      --trace-window first-starved-pixel --trace-modules 'composer_*,input_framebuffer_3'\n"
    "  metabuffer run scenarios/paper-figure-starved.yaml --trace out/starved.json \\\n"
    "      --trace-window first-starved-pixel\n"
    "Exit status: 0 done; 1 the model failed; 2 bad input; 3 --strict and something starved or was\n"
    "rejected; 4 the watchdog: nothing moved any more; 5 --check and the model broke a rule.";

/// What made a waveform: program, scenario and every key that is a single value.
std::string waveform_header(const Scenario& scenario) {
    std::string header = "metabuffer " + build_version() + "\nscenario " + scenario.name + "\n";
    for (const auto& [key, value] : scenario_settings(scenario)) {
        header += key;
        header += " = ";
        header += value;
        header += '\n';
    }
    return header;
}

std::string clocks_text(const CycleSpan& range) {
    return std::to_string(range.first) + " to " + std::to_string(range.last);
}

/// Level tlm, which is faster, knows the clock of every event of level rtl. Not so if a fault or a block of somebody else's
/// is in the machine, which level rtl alone has.
bool level_tlm_knows_clocks(const Scenario& scenario) {
    constexpr bool kReplacesBlocks = METABUFFER_REPLACES_BLOCKS != 0;
    return !kReplacesBlocks &&
           std::none_of(scenario.faults.begin(), scenario.faults.end(),
                        [](const Fault& fault) { return fault_traits(fault.kind).only_at_level_rtl(); });
}

RunReport run_functional(const Scenario& scenario, PictureSink& pictures) {
    RunReport report;
    report.scenario = scenario.name;
    report.level = kFunctional;
    report.core_mhz = scenario.clocks.core_mhz;
    const std::vector<std::vector<int>> pairs = functional::pairs_without_time(scenario);
    for (std::size_t r = 0; r < scenario.renderers.size(); ++r) {
        const Renderer& renderer = scenario.renderers[r];
        RendererCounters& counters = report.renderers.emplace_back();
        counters.name = renderer.name;
        for (int frame = 0; frame < scenario.frames; ++frame) {
            if (pairs[static_cast<std::size_t>(frame)][r] != frame) {
                ++counters.repeated_frames;
                continue;
            }
            const auto pair = static_cast<std::uint32_t>(frame);
            const RendererFrame& entry = renderer.frame_of_pair(pair);
            const ValidatedTable table = validate_table(entry.table, scenario.limits(renderer));
            counters.add_rejected_rows(pair, table);
            counters.rejected_slot_tables += frame_slots(scenario, renderer, entry, table).rejected ? 1 : 0;
        }
    }
    report.displays.resize(static_cast<std::size_t>(scenario.displays.count()));
    functional::Compositor compositor(scenario);
    for (int frame = 0; frame < scenario.frames; ++frame) {
        compositor.begin_frame(
            functional::contributions_of(scenario, pairs[static_cast<std::size_t>(frame)]));
        for (int display = 1; display <= scenario.displays.count(); ++display) {
            pictures.take(frame, display, compositor.picture(display));
            ++report.displays[static_cast<std::size_t>(display) - 1].frames_shown;
        }
    }
    return report;
}

}  // namespace

/// What a run leaves, at any level.
struct RunCommand::Outcome {
    RunReport report;
    double simulation_seconds = 0.0;  ///< 0: the level has no time
    std::string trace_line;           ///< what the trace shows, empty if there is none
    std::string trace_note;  ///< why there is none although one was asked for, or what is wrong with it
    std::string compared;    ///< what a check has compared, empty without one
    std::string check_trace_options;  ///< what shows a check's first violation, empty if there is none
};

RunCommand::RunCommand(CLI::App& program)
    : Command(program, "run", "Run a scenario; write its pictures and its report"), scenario_(command()) {
    command()
        .add_option("--level", level_,
                    "tlm: by transactions; rtl: clock by clock; functional: the pictures alone, no time "
                    "(default: tlm; for a waveform and for --check rtl)")
        ->check(CLI::IsMember({kTlm, kRtl, kFunctional}));
    command().add_option("--out", out_directory_, "Directory for the results (default: out/NAME)");
    add_trace_options();
    command().add_flag(
        "--no-images", no_images_,
        "Counters only: no pictures, and those of an earlier run in the directory are removed");
    command().add_flag(
        "--check", check_,
        "Check every wire against the machine's rules and every pixel against level functional (level rtl), "
        "or the pictures alone (level tlm); exit with 5 if a rule is broken");
    command().add_flag("--strict", strict_,
                       "Exit with 3 if a pixel starved or a frame, row or slot table was rejected");
    command().add_flag("--quiet", quiet_, "Print no summary and no progress");
    add_request_option();
    command().footer(kRunFooter);
}

void RunCommand::add_trace_options() {
    CLI::Option* const trace =
        command().add_option("--trace", trace_file_,
                             "Write a trace: FILE.vcd or FILE.fst, a waveform (level rtl), or FILE.json, "
                             "what each bus and display does when, "
                             "for ui.perfetto.dev (level tlm)");
    constexpr std::int64_t kLargestCycles = 1'000'000'000'000;
    CLI::Option* const window = command().add_option(
        "--trace-window", trace_window_,
        "What a trace shows: startframe:K (a waveform's default, with K = 0), frames:A-B, "
        "cycles:A-B, first-busready-drop, first-starved-pixel, or all (a schedule's default; a "
        "waveform of a whole frame takes gigabytes)");
    CLI::Option* const before =
        command()
            .add_option("--trace-before", trace_before_cycles_, "Core clocks before the event (default 200)")
            ->check(CLI::Range(std::int64_t{0}, kLargestCycles));
    CLI::Option* const after =
        command()
            .add_option("--trace-after", trace_after_cycles_, "Core clocks after it (default 2000)")
            ->check(CLI::Range(std::int64_t{0}, kLargestCycles));
    CLI::Option* const modules =
        command()
            .add_option("--trace-modules", trace_blocks_,
                        "Of a waveform, only these blocks: comma-separated shell patterns such as "
                        "'composer_1_*,swap_lock'")
            ->delimiter(',')
            ->allow_extra_args(false);  // what follows may be the scenario
    for (CLI::Option* option : {window, before, after, modules}) option->needs(trace);
    window_option_ = window;
    around_options_ = {before, after};
    modules_option_ = modules;
}

/// Like --version, it ends the program as soon as the options are read, before any is found to be missing.
void RunCommand::add_request_option() {
    constexpr const char* kHidden = "";
    const auto print = [this] {
        const std::string request = "scenario=" + scenario_.file() + "\nlevel=" + level_ +
                                    "\nout=" + out_directory_ + "\ntrace=" + trace_file_ +
                                    "\nquiet=" + (quiet_ ? "yes" : "no");
        throw CLI::CallForVersion(request, CLI::ExitCodes::Success);
    };
    command()
        .add_flag_callback("--print-request", print, "Print what the command line names, and run nothing")
        ->group(kHidden);
}

std::string RunCommand::level() const {
    if (!level_.empty()) return level_;
    const bool schedule = std::filesystem::path(trace_file_).extension() == kScheduleExtension;
    return rtl::is_waveform_name(trace_file_) || (check_ && !schedule) ? kRtl : kTlm;
}

void RunCommand::check_combination(const std::string& level) const {
    if (no_images_ && level == kFunctional) {
        throw InputError("--no-images: level functional makes nothing but pictures; use --level tlm or rtl");
    }
    if (check_ && level == kFunctional) {
        throw InputError(
            "--check: level functional is what the others are checked against; use --level rtl or tlm");
    }
    if (check_ && no_images_ && level == kTlm) {
        throw InputError("--check: level tlm makes no pictures to check with --no-images; use --level rtl");
    }
    if (trace_file_.empty()) return;
    const std::string trace = "--trace " + trace_file_ + ": ";
    const std::string extension = std::filesystem::path(trace_file_).extension().string();
    const bool waveform = rtl::is_waveform_name(trace_file_);
    if (level == kFunctional) {
        throw InputError(
            trace +
            "level functional has no time to show; use --level rtl for a waveform or --level tlm "
            "for a schedule");
    }
    if (!waveform && extension != kScheduleExtension) {
        throw InputError(trace +
                         "is no kind of trace; use a name that ends in .vcd or .fst for a waveform (level "
                         "rtl) or in .json for a schedule (level tlm)");
    }
    if (waveform && level == kTlm) {
        throw InputError(trace + "level tlm has no signals; use --level rtl, or FILE.json for its schedule");
    }
    if (extension == kScheduleExtension && level == kRtl) {
        throw InputError(trace + "level rtl writes no schedule; use --level tlm, or FILE.vcd for a waveform");
    }
    if (!waveform) check_schedule_options();
}

void RunCommand::check_schedule_options() const {
    if (modules_option_->count() > 0) {
        throw InputError(modules_option_->get_name() +
                         ": goes with a waveform, FILE.vcd; a schedule shows every bus, buffer and display");
    }
    for (const CLI::Option* option : around_options_) {
        if (option->count() == 0 || window_option_->count() > 0) continue;
        throw InputError(option->get_name() + ": a schedule without " + window_option_->get_name() +
                         " shows the whole run; say around what, for example " + window_option_->get_name() +
                         " startframe:0");
    }
}

TraceWindow RunCommand::trace_window() const {
    const char* const without = rtl::is_waveform_name(trace_file_) ? "startframe:0" : "all";
    TraceWindow window = parse_trace_window(window_option_->count() > 0 ? trace_window_ : without);
    window.before_cycles = trace_before_cycles_.value_or(window.before_cycles);
    window.after_cycles = trace_after_cycles_.value_or(window.after_cycles);
    return window;
}

/// What was found before a block's own error ended the run is told too.
RunCommand::Outcome RunCommand::run_checked_rtl(const Scenario& scenario, PictureSink& pictures) const {
    MachineCheck check(scenario);
    try {
        Outcome outcome = run_rtl(scenario, pictures, &check);
        check.finish(outcome.report);
        outcome.report.check = check.record();
        outcome.compared = check.compared();
        outcome.check_trace_options = check.trace_options();
        return outcome;
    } catch (...) {
        if (check.record().violations > 0) print_violations(check.record(), check.trace_options());
        throw;
    }
}

RunCommand::Outcome RunCommand::run_rtl(const Scenario& scenario, PictureSink& pictures,
                                        MachineCheck* check) const {
    rtl::RunOptions options;
    if (check != nullptr) {
        options.on_built = [check](rtl::Metabuffer& machine) { check->attach(machine); };
    }
    if (!trace_file_.empty()) {
        options.trace =
            rtl::TraceRequest{trace_file_, trace_window(), trace_blocks_, waveform_header(scenario), {}};
        if (level_tlm_knows_clocks(scenario)) options.trace->find_window = tlm::find_window;
    }
    const ProgressLine progress(!quiet_);
    WrongPixelRecord wrong_pixels(scenario);
    if (!no_images_) {
        options.on_frame_shown = [&](const DisplayedFrame& displayed) {
            pictures.take(displayed.frame, displayed.display, displayed.picture);
            wrong_pixels.take(displayed);
        };
    }
    options.on_progress = [&](std::int64_t cycles, double share) { progress.show_run(cycles, share); };
    rtl::RunResult result = rtl::run(scenario, options);
    if (!no_images_) wrong_pixels.put_into(result.report);
    Outcome outcome;
    outcome.report = std::move(result.report);
    outcome.simulation_seconds = result.simulation_seconds;
    if (!result.trace_note.empty()) outcome.trace_note = "no waveform: " + result.trace_note;
    if (!result.trace_warning.empty()) outcome.trace_note = "waveform: " + result.trace_warning;
    if (result.traced) {
        outcome.trace_line = "waveform " + trace_file_ + ": core clocks " + clocks_text(*result.traced);
    }
    return outcome;
}

RunCommand::Outcome RunCommand::run_tlm(const Scenario& scenario, PictureSink& pictures) const {
    std::optional<tlm::ScheduleTrace> trace;
    std::optional<CycleSpan> window;
    if (!trace_file_.empty()) {
        trace.emplace(trace_file_, scenario);
        const TraceWindow wanted = trace_window();
        window = wanted.fixed_cycles();
        if (!window) window = tlm::find_window(scenario, wanted);
        if (!window) trace.reset();
        if (window && wanted.kind != TraceWindow::Kind::kAll) trace->show_only(*window);
    }
    tlm::RunOptions options;
    options.observer = trace ? &*trace : nullptr;
    options.images = !no_images_;
    const ProgressLine progress(!quiet_);
    std::optional<PictureCheck> check;
    if (check_) check.emplace(scenario);
    WrongPixelRecord wrong_pixels(scenario);
    options.on_frame_shown = [&](const DisplayedFrame& displayed) {
        pictures.take(displayed.frame, displayed.display, displayed.picture);
        if (check) check->take(displayed.frame, displayed.display, displayed.picture);
        wrong_pixels.take(displayed);
    };
    options.on_progress = [&](std::int64_t cycles, double share) { progress.show_run(cycles, share); };
    tlm::RunResult result = tlm::run(scenario, options);
    if (!no_images_) wrong_pixels.put_into(result.report);
    Outcome outcome;
    outcome.report = std::move(result.report);
    outcome.simulation_seconds = result.simulation_seconds;
    if (check) {
        check->finish(outcome.report);
        outcome.report.check = check->record();
        outcome.compared = check->compared();
    }
    if (trace_file_.empty()) return outcome;
    const auto shown = trace ? trace->finish(outcome.report.core_cycles) : std::nullopt;
    if (!window) {
        outcome.trace_note = "no schedule: what the schedule should show does not happen in this run";
    } else if (window->first >= outcome.report.core_cycles) {
        outcome.trace_note = "no schedule: the run ended before the window began";
    } else if (!shown) {
        outcome.trace_note = "no schedule: nothing happens in core clocks " + clocks_text(*window);
    } else {
        outcome.trace_line =
            "schedule " + trace_file_ + ": " +
            (window_option_->count() > 0 ? "core clocks " + clocks_text(*shown) + ", " : std::string()) +
            "to be opened at https://ui.perfetto.dev";
    }
    return outcome;
}

ExitStatus RunCommand::execute() {
    const std::string level = this->level();
    check_combination(level);
    // Before the scenario is read, which takes longer.
    if (!trace_file_.empty()) trace_window();
    const Scenario scenario = scenario_.load();
    const std::vector<std::filesystem::path> inputs = inputs_of(scenario_.file(), scenario);
    if (!trace_file_.empty()) refuse_to_replace(inputs, "--trace", trace_file_);
    ResultFolder folder(out_directory_.empty() ? std::filesystem::path("out") / scenario.name
                                               : std::filesystem::path(out_directory_),
                        inputs);
    const std::filesystem::path& directory = folder.path();
    // Before the run, which takes longer: it may hold a path that no scenario file can.
    const std::string effective = effective_scenario(scenario, directory);

    PictureSink pictures(folder, scenario);
    Outcome outcome;
    if (level == kFunctional) {
        outcome.report = run_functional(scenario, pictures);
    } else {
        outcome = level == kTlm ? run_tlm(scenario, pictures)
                  : check_      ? run_checked_rtl(scenario, pictures)
                                : run_rtl(scenario, pictures, nullptr);
    }
    if (!no_images_) pictures.finish();
    folder.write(kReportFile, report_json(outcome.report));
    folder.write(kEffectiveScenarioFile, effective);
    folder.put_in_place();
    if (!quiet_) print_summary(outcome, directory.string());
    if (!outcome.trace_note.empty()) std::cerr << outcome.trace_note << '\n';
    return judge(outcome);
}

void RunCommand::print_summary(const Outcome& outcome, const std::string& directory) const {
    std::cout << report_summary(outcome.report) << "results in " << directory << std::endl;
    if (outcome.simulation_seconds > 0.0) {
        const double composer_clocks = static_cast<double>(outcome.report.composers.size()) *
                                       static_cast<double>(outcome.report.core_cycles);
        std::printf("simulated in %.4f s: %.1f million composer clocks a second\n",
                    outcome.simulation_seconds, composer_clocks / outcome.simulation_seconds / 1e6);
        std::fflush(stdout);
    }
    if (!outcome.trace_line.empty()) std::cout << outcome.trace_line << '\n';
    if (outcome.report.check) {
        const std::int64_t violations = outcome.report.check->violations;
        std::cout << "checked: " << outcome.compared << ": "
                  << (violations == 0 ? std::string("no violation") : text::counted(violations, "violation"))
                  << '\n';
    }
}

void RunCommand::print_violations(const CheckRecord& record, const std::string& trace_options) const {
    std::cerr << scenario_.file() << ": --check: the model has broken a rule\n";
    for (const std::string& violation : record.first_violations) std::cerr << "  " << violation << '\n';
    const auto more = record.violations - static_cast<std::int64_t>(record.first_violations.size());
    if (more > 0) std::cerr << "  and " << more << " more\n";
    if (!trace_options.empty()) std::cerr << "  the first one's waveform: " << trace_options << '\n';
}

ExitStatus RunCommand::judge(const Outcome& outcome) const {
    const RunReport& report = outcome.report;
    const bool wrong = report.check && report.check->violations > 0;
    if (wrong) print_violations(*report.check, outcome.check_trace_options);
    const bool watchdog = print_watchdog(scenario_.file(), report);
    if (wrong) return kExitDifferent;
    if (watchdog) return kExitWatchdog;
    if (strict_ && (report.total_starved_pixels() > 0 || report.total_stalled_cycles() > 0 ||
                    report.total_rejected() > 0)) {
        std::cerr << scenario_.file() << ": --strict: " << report.total_starved_pixels()
                  << " pixels starved, " << report.total_stalled_cycles() << " clocks stalled, "
                  << report.total_rejected() << " frames, rows or slot tables rejected\n";
        return kExitStrict;
    }
    return kExitDone;
}

}  // namespace metabuffer
