#include "tools/program/view_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <optional>
#include <vector>

#include "host/child_process.h"
#include "host/errors.h"
#include "host/output_file.h"
#include "host/text.h"
#include "host/text_file.h"
#include "report/report_difference.h"
#include "tlm/run.h"
#include "tools/analysis/bandwidth_analysis.h"
#include "tools/charts/report_page.h"
#include "tools/charts/run_page.h"
#include "tools/program/output_guard.h"
#include "tools/program/progress_line.h"
#include "tools/program/result_folder.h"
#include "tools/program/starvation_advice.h"
#include "tools/program/watchdog_lines.h"
#include "tools/program/wrong_pixel_record.h"

namespace metabuffer {
namespace {

constexpr const char* kViewFooter =
    "The scenario is run at level tlm, which has the clocks and pictures of level rtl. For a folder of\n"
    "results its effective_scenario.yaml is run again. The page holds all that it shows and needs no\n"
    "network: the displays frame by frame, who won each pixel and at which clock, and what links, buses,\n"
    "buffers and displays did when. docs/run-page.md describes it.\n"
    "Examples:\n"
    "  metabuffer view scenarios/paper-figure-starved.yaml -o run.html\n"
    "  metabuffer view out/paper-figure -o run.html\n"
    "Exit status: 0 done; 1 the model failed; 2 bad input; 4 the watchdog ended the run, which the page\n"
    "shows until then.";

/// Remarks on a report in a folder of results that differs from the report of this run.
std::vector<std::string> remarks_on(const std::filesystem::path& report_file, const std::string& report) {
    if (!std::filesystem::is_regular_file(report_file)) return {};
    std::size_t differences = 0;
    try {
        differences = compare_reports(input::text_of_file(report_file), report).differences.size();
    } catch (const std::exception&) {
        return {report_file.string() + " cannot be read as a report."};
    }
    if (differences == 0) return {};
    return {report_file.string() + " differs from this run in " + text::counted(differences, "value") +
            ": it was made by another program, from other images, or at a level without clocks."};
}

}  // namespace

ViewCommand::ViewCommand(CLI::App& program)
    : Command(program, "view", "Run a scenario and put the run into a page for a browser"),
      scenario_(command()) {
    command()
        .get_option("SCENARIO")
        ->description("The scenario, a YAML file, or a folder of results of metabuffer run");
    command().add_option("-o,--output", output_file_, "The page, an HTML file")->required();
    command().add_option("--title", title_, "The page's title (default: the scenario's name)");
    command()
        .add_option(
            "--embed-mib", embedded_mebibytes_,
            "MiB of pictures in the page, at most half of them the displays'; if there are more, frames "
            "are left out evenly, and then images of renderers")
        ->capture_default_str()
        ->check(CLI::Range(0, 1024));
    command().add_flag("--quiet", quiet_, "Show no progress");
    command().footer(kViewFooter);
}

ExitStatus ViewCommand::execute() {
    std::optional<std::filesystem::path> report_file;
    if (std::filesystem::is_directory(scenario_.file())) {
        const std::filesystem::path folder = scenario_.file();
        const std::filesystem::path effective = folder / kEffectiveScenarioFile;
        if (!std::filesystem::exists(effective)) {
            throw InputError(text::quoted(folder.string()) + " is no folder of results: it has no " +
                             kEffectiveScenarioFile +
                             "; name a scenario, or a folder that metabuffer run has written");
        }
        report_file = folder / kReportFile;
        scenario_.set_file(effective.string());
    }
    Scenario scenario = scenario_.load();
    read_images_ahead(scenario, helper_process_count());
    std::vector<std::filesystem::path> inputs = inputs_of(scenario_.file(), scenario);
    if (report_file) inputs.push_back(*report_file);
    refuse_to_replace(inputs, "-o", output_file_);
    OutputFile file(output_file_);  // before the run, which takes longer

    const std::size_t most_bytes = static_cast<std::size_t>(embedded_mebibytes_) * charts::kBytesPerMebibyte;
    const StarvationAdvice advice(scenario);
    charts::RunRecord record(scenario);
    charts::ShownPictures pictures(scenario, most_bytes / 2);
    WrongPixelRecord wrong_pixels(scenario);
    tlm::RunOptions options;
    options.observer = &record;
    options.on_frame_shown = [&](const DisplayedFrame& displayed) {
        pictures.take(displayed);
        wrong_pixels.take(displayed);
    };
    const ProgressLine progress(!quiet_);
    options.on_progress = [&](std::int64_t cycles, double share) { progress.show_run(cycles, share); };
    RunReport report = tlm::run(scenario, options).report;
    wrong_pixels.put_into(report);

    const std::string report_text = report_json(report);
    charts::RunPage page{scenario, report, report_text, record, pictures};
    page.title = title_.empty() ? scenario.name : title_;
    page.command = {"metabuffer", "run"};
    const std::vector<std::string> words = scenario_.words();
    page.command.insert(page.command.end(), words.begin(), words.end());
    if (report_file) page.remarks = remarks_on(*report_file, report_text);
    page.advice = advice.lines(report);
    page.safe_buffer_pixels = analysis::analyze(scenario).safe_buffer_pixels;
    page.most_image_bytes = most_bytes - std::min(most_bytes, pictures.bytes());
    file.write(charts::run_page(page));
    file.put_in_place();
    std::cerr << watchdog_lines(scenario_.file(), report);
    return report.watchdog.empty() ? kExitDone : kExitWatchdog;
}

}  // namespace metabuffer
