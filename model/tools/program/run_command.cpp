#include "tools/program/run_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>

#include "host/child_process.h"
#include "host/errors.h"
#include "host/text.h"
#include "report/report.h"
#include "rtl/waveform_file.h"
#include "scenario/scenario_writer.h"
#include "tools/program/output_guard.h"
#include "tools/program/progress_line.h"
#include "tools/program/result_folder.h"

namespace metabuffer {
namespace {

constexpr const char* kPictures = "--pictures";
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

}  // namespace

RunCommand::RunCommand(CLI::App& program)
    : Command(program, "run", "Run a scenario; write its pictures and its report"), scenario_(command()) {
    command()
        .add_option("--level", level_,
                    "tlm: by transactions; rtl: clock by clock; functional: the pictures alone, no time "
                    "(default: tlm; for a waveform and for --check rtl)")
        ->check(CLI::IsMember(enum_names<RunLevel>()));
    command().add_option("--out", out_directory_, "Directory for the results (default: out/NAME)");
    add_trace_options();
    command().add_option(
        kPictures, pictures_,
        "Which pictures are written: all (default), last (those of the last frame), none, or frames counted "
        "from 0, such as 2 or 2-5; others, of an earlier run in the directory, are removed");
    command().add_flag("--no-images", no_images_,
                       "As --pictures none: counters only, and level tlm composites nothing");
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
        "cycles:A-B, first-busready-drop, first-starved-pixel, first-recovered-slot, or all (a schedule's "
        "default; a "
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
            ->allow_extra_args(false);  // the next word may be the scenario
    for (CLI::Option* option : {window, before, after, modules}) option->needs(trace);
    window_option_ = window;
    around_options_ = {before, after};
    modules_option_ = modules;
}

/// Like --version, the option ends the program as soon as the options are read, before missing ones are reported.
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

RunLevel RunCommand::level() const {
    if (!level_.empty()) return *from_name<RunLevel>(level_);
    const bool schedule = std::filesystem::path(trace_file_).extension() == kScheduleExtension;
    return rtl::is_waveform_name(trace_file_) || (check_ && !schedule) ? RunLevel::kRtl : RunLevel::kTlm;
}

void RunCommand::check_trace(RunLevel level) const {
    if (trace_file_.empty()) return;
    const std::string trace = "--trace " + trace_file_ + ": ";
    const std::string extension = std::filesystem::path(trace_file_).extension().string();
    const bool waveform = rtl::is_waveform_name(trace_file_);
    if (level == RunLevel::kFunctional) {
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
    if (waveform && level == RunLevel::kTlm) {
        throw InputError(trace + "level tlm has no signals; use --level rtl, or FILE.json for its schedule");
    }
    if (extension == kScheduleExtension && level == RunLevel::kRtl) {
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

bool RunCommand::wants_pictures() const {
    if (no_images_ && !pictures_.empty() && !names_no_picture(pictures_)) {
        throw InputError(std::string("--no-images: writes no picture, and ") + kPictures + " " +
                         text::quoted(pictures_) + " names some; use one of the two");
    }
    return !no_images_ && !names_no_picture(pictures_);
}

LevelRequest RunCommand::request() const {
    LevelRequest request{level(), wants_pictures(), check_, std::nullopt};
    check_request(request);
    check_trace(request.level);
    if (!trace_file_.empty()) {
        request.trace =
            LevelRequest::Trace{trace_file_, trace_window(), window_option_->count() > 0, trace_blocks_};
    }
    return request;
}

/// If an error ends the run, this prints the violations that were found before.
LevelOutcome RunCommand::run(const Scenario& scenario, const LevelRequest& request,
                             PictureSink& pictures) const {
    const ProgressLine progress(!quiet_);
    const RunFollower follower{
        [&pictures](int frame, int display, const ColourImage& picture) {
            pictures.take(frame, display, picture);
        },
        [&progress](std::int64_t cycles, double share) { progress.show_run(cycles, share); }};
    LevelOutcome outcome;
    try {
        run_level(scenario, request, follower, outcome);
    } catch (...) {
        std::cerr << violations_text(outcome, scenario_.file());
        throw;
    }
    return outcome;
}

ExitStatus RunCommand::execute() {
    // Checked before the scenario is read, which takes longer.
    const LevelRequest request = this->request();
    Scenario scenario = scenario_.load();
    if (needs_pixels(request)) read_images_ahead(scenario, helper_process_count());
    // The process that checks the pictures then finds the images in memory.
    if (request.check && request.level == RunLevel::kTlm) read_images(scenario);
    const PictureChoice choice = parse_picture_choice(
        kPictures, request.images ? (pictures_.empty() ? "all" : pictures_) : "none", scenario.frames);
    const std::vector<std::filesystem::path> inputs = inputs_of(scenario_.file(), scenario);
    if (!trace_file_.empty()) refuse_to_replace(inputs, "--trace", trace_file_);
    ResultFolder folder(out_directory_.empty() ? std::filesystem::path("out") / scenario.name
                                               : std::filesystem::path(out_directory_),
                        inputs);
    const std::filesystem::path& directory = folder.path();
    // Made before the run, which takes longer: it throws for a path that no scenario file can hold.
    const std::string effective = effective_scenario(scenario, directory);

    std::optional<StarvationAdvice> advice;
    if (!quiet_ && request.level != RunLevel::kFunctional) advice.emplace(scenario);
    PictureSink pictures(folder, scenario, choice);
    const LevelOutcome outcome = run(scenario, request, pictures);
    pictures.finish();
    folder.write(kReportFile, report_json(outcome.report));
    folder.write(kEffectiveScenarioFile, effective);
    folder.put_in_place();
    if (!quiet_) print_summary(outcome, advice, directory.string());
    if (!outcome.trace_note.empty()) std::cerr << outcome.trace_note << '\n';
    const Judgement judgement = judge(outcome, scenario_.file(), strict_);
    std::cerr << judgement.text;
    return judgement.status;
}

void RunCommand::print_summary(const LevelOutcome& outcome, const std::optional<StarvationAdvice>& advice,
                               const std::string& directory) const {
    std::cout << report_summary(outcome.report)
              << (advice ? advice->text(outcome.report, scenario_.file()) : "") << "results in " << directory
              << std::endl;
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

}  // namespace metabuffer
