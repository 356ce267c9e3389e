#include "program/run_command.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <iostream>
#include <regex>

#include "functional/functional_compositor.h"
#include "report/picture_writer.h"
#include "report/report.h"
#include "rtl/run.h"
#include "scenario/scenario_loader.h"

namespace metabuffer {
namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  metabuffer run scenarios/paper-figure.yaml\n"
    "  metabuffer run scenarios/paper-figure.yaml --set bus.width_bits=64 --trace out/trace.vcd\n"
    "  metabuffer run scenarios/paper-figure-starved.yaml --trace out/trace.vcd \\\n"
    "      --trace-window first-starved-pixel --trace-modules 'composer_*,input_framebuffer_3'\n"
    "Exit status: 0 done; 1 the model failed; 2 bad input; 3 --strict and something starved or was\n"
    "rejected; 4 the watchdog: nothing moved any more.";

/// The folder of the results. What had to be made of it goes again if the run fails before it wrote anything.
class ResultFolder {
  public:
    explicit ResultFolder(std::filesystem::path path) : path_(std::move(path)) {
        for (std::filesystem::path part = path_; !part.empty() && !std::filesystem::exists(part);
             part = part.parent_path()) {
            made_.push_back(part);
        }
        std::error_code error;
        std::filesystem::create_directories(path_, error);
        if (error) {
            throw InputError("--out " + path_.string() + ": cannot be made: " + error.message() +
                             "; name a folder in a place that can be written");
        }
    }
    ResultFolder(const ResultFolder&) = delete;
    ResultFolder& operator=(const ResultFolder&) = delete;
    ~ResultFolder() {
        std::error_code error;
        for (const std::filesystem::path& part : made_) {
            std::filesystem::remove(part, error);  // only if it is empty
        }
    }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
    std::vector<std::filesystem::path> made_;  ///< innermost first
};

/// Writes each frame's pictures as they come and keeps the newest for the collage, so that memory does not
/// grow with the number of frames.
class PictureSink {
  public:
    PictureSink(std::filesystem::path directory, const Scenario& scenario)
        : directory_(std::move(directory)),
          config_(scenario.displays),
          frames_(scenario.frames),
          many_frames_(scenario.frames > 1),
          newest_(static_cast<std::size_t>(scenario.displays.count())) {}

    void take(int frame, int display, const ColourImage& image) {
        const std::string stem = "display_" + std::to_string(display);
        if (many_frames_) {
            std::array<char, 16> number{};
            std::snprintf(number.data(), number.size(), ".%04d.png", frame);
            write_png(directory_ / (stem + number.data()), image);
        }
        newest_[static_cast<std::size_t>(display) - 1] = image;
    }

    void finish() const {
        remove_older_frames();
        for (std::size_t d = 0; d < newest_.size(); ++d) {
            if (newest_[d].values.empty()) {
                return;  // the run ended before a frame was shown
            }
            write_png(directory_ / ("display_" + std::to_string(d + 1) + ".png"), newest_[d]);
        }
        write_png(directory_ / "collage.png", collage(newest_, config_));
    }

  private:
    /// Numbered pictures of an earlier, longer run would pass for this one's.
    void remove_older_frames() const {
        const std::regex numbered(R"(display_\d+\.(\d{4,})\.png)");
        for (const auto& entry : std::filesystem::directory_iterator(directory_)) {
            std::smatch match;
            const std::string name = entry.path().filename().string();
            if (std::regex_match(name, match, numbered) &&
                (!many_frames_ || std::stol(match[1]) >= frames_)) {
                std::filesystem::remove(entry.path());
            }
        }
    }

    std::filesystem::path directory_;
    DisplayConfig config_;
    int frames_;
    bool many_frames_;
    std::vector<ColourImage> newest_;
};

/// One line on a terminal that is overwritten as the run goes on.
class ProgressLine {
  public:
    explicit ProgressLine(bool wanted) : shown_(wanted && isatty(STDERR_FILENO) != 0) {}
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;
    ~ProgressLine() {
        if (shown_) {
            std::fputs("\r\033[K", stderr);
        }
    }
    void update(std::int64_t core_cycles, double share) const {
        if (shown_) {
            std::fprintf(stderr, "\r%lld core clocks, %3.0f %% of the pixels composited\033[K",
                         static_cast<long long>(core_cycles), 100.0 * share);
        }
    }

  private:
    bool shown_;
};

RunReport run_functional(const Scenario& scenario, PictureSink& pictures) {
    RunReport report;
    report.scenario = scenario.name;
    report.level = "functional";
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
            counters.add_rejected_rows(
                pair, validate_table(renderer.frame_of_pair(pair).table, scenario.limits(renderer)));
        }
    }
    report.displays.resize(static_cast<std::size_t>(scenario.displays.count()));
    for (int frame = 0; frame < scenario.frames; ++frame) {
        const std::vector<functional::Contribution> contributions =
            functional::contributions_of(scenario, pairs[static_cast<std::size_t>(frame)]);
        for (int display = 1; display <= scenario.displays.count(); ++display) {
            pictures.take(frame, display, functional::composite_display(scenario, contributions, display));
            ++report.displays[static_cast<std::size_t>(display) - 1].frames_shown;
        }
    }
    return report;
}

}  // namespace

RunCommand::RunCommand(CLI::App& program)
    : command_(program.add_subcommand("run", "Run a scenario; write its pictures and its report")) {
    command_->add_option("SCENARIO", scenario_file_, "The scenario, a YAML file")->required();
    command_->add_option("--level", level_, "rtl: clocked, or functional: no time, the reference")
        ->check(CLI::IsMember({"rtl", "functional"}))
        ->capture_default_str();
    command_->add_option("--out", out_directory_, "Directory for the results (default: out/NAME)");
    command_->add_option("--set", overrides_, "PATH=VALUE: override a scenario key, e.g. bus.width_bits=128")
        ->take_all()
        ->allow_extra_args(false);
    command_->add_option("--frames", frames_, "Composited frames to show, instead of the scenario's number")
        ->check(CLI::Range(1, 1'000'000));
    CLI::Option* const trace =
        command_->add_option("--trace", trace_file_, "Write a waveform to FILE.vcd (level rtl)");
    constexpr std::int64_t kLargestCycles = 1'000'000'000'000;
    CLI::Option* const trace_window =
        command_
            ->add_option("--trace-window", trace_window_,
                         "What it shows: startframe:K, frames:A-B, cycles:A-B, first-busready-drop, "
                         "first-starved-pixel, or all (gigabytes for a whole frame)")
            ->capture_default_str();
    CLI::Option* const trace_before =
        command_
            ->add_option("--trace-before", trace_before_cycles_, "Core clocks before the event (default 200)")
            ->check(CLI::Range(std::int64_t{0}, kLargestCycles));
    CLI::Option* const trace_after =
        command_->add_option("--trace-after", trace_after_cycles_, "Core clocks after it (default 2000)")
            ->check(CLI::Range(std::int64_t{0}, kLargestCycles));
    CLI::Option* const trace_modules =
        command_
            ->add_option("--trace-modules", trace_blocks_,
                         "Only these blocks: comma-separated shell patterns such as 'composer_1_*,swap_lock'")
            ->delimiter(',');
    for (CLI::Option* option : {trace_window, trace_before, trace_after, trace_modules}) {
        option->needs(trace);
    }
    command_->add_flag("--strict", strict_, "Exit with 3 if a pixel starved or a frame or row was rejected");
    command_->add_flag("--quiet", quiet_, "Print no summary and no progress");
    command_->footer(kExamples);
}

ExitStatus RunCommand::execute() {
    std::vector<ScenarioOverride> overrides;
    for (const std::string& text : overrides_) {
        overrides.push_back(parse_override(text));
    }
    if (frames_) {
        overrides.push_back({"frames", std::to_string(*frames_)});
    }
    rtl::RunOptions options;
    if (!trace_file_.empty()) {
        if (level_ != "rtl") {
            throw InputError("--trace " + trace_file_ + ": level " + level_ +
                             " has no signals; use --level rtl");
        }
        rtl::check_trace_name(trace_file_);
        rtl::TraceWindow window = rtl::parse_trace_window(trace_window_);
        window.before_cycles = trace_before_cycles_.value_or(window.before_cycles);
        window.after_cycles = trace_after_cycles_.value_or(window.after_cycles);
        options.trace = rtl::TraceRequest{trace_file_, window, trace_blocks_};
    }
    const Scenario scenario = load_scenario(scenario_file_, overrides);
    const ResultFolder folder(out_directory_.empty() ? std::filesystem::path("out") / scenario.name
                                                     : std::filesystem::path(out_directory_));
    const std::filesystem::path& directory = folder.path();

    PictureSink pictures(directory, scenario);
    rtl::RunResult result;
    if (level_ == "functional") {
        result.report = run_functional(scenario, pictures);
    } else {
        const ProgressLine progress(!quiet_);
        options.on_frame_shown = [&](int frame, int display, const ColourImage& image) {
            pictures.take(frame, display, image);
        };
        options.on_progress = [&](std::int64_t cycles, double share) { progress.update(cycles, share); };
        result = rtl::run(scenario, options);
    }
    pictures.finish();
    write_text(directory / "report.json", report_json(result.report));
    if (!quiet_) {
        std::cout << report_summary(result.report) << "results in " << directory.string() << std::endl;
        if (result.simulation_seconds > 0.0) {
            const double composer_clocks = static_cast<double>(result.report.composers.size()) *
                                           static_cast<double>(result.report.core_cycles);
            std::printf("simulated in %.2f s: %.1f million composer clocks a second\n",
                        result.simulation_seconds, composer_clocks / result.simulation_seconds / 1e6);
        }
        if (result.traced) {
            std::cout << "waveform " << trace_file_ << ": core clocks " << result.traced->first << " to "
                      << result.traced->last << '\n';
        }
    }
    if (!result.trace_note.empty()) {
        std::cerr << "no waveform: " << result.trace_note << '\n';
    }
    if (!result.watchdog_findings.empty()) {
        std::cerr << scenario_file_ << ": the watchdog ended the run: nothing moves any more\n";
        for (const std::string& finding : result.watchdog_findings) {
            std::cerr << "  " << finding << '\n';
        }
        return kExitWatchdog;
    }
    const RunReport& report = result.report;
    if (strict_ && (report.total_starved_pixels() > 0 || report.total_stalled_cycles() > 0 ||
                    report.total_rejected() > 0)) {
        std::cerr << scenario_file_ << ": --strict: " << report.total_starved_pixels() << " pixels starved, "
                  << report.total_stalled_cycles() << " clocks stalled, " << report.total_rejected()
                  << " frames or rows rejected\n";
        return kExitStrict;
    }
    return kExitDone;
}

}  // namespace metabuffer
