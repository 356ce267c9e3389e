#include "tools/program/report_command.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <system_error>

#include "host/errors.h"
#include "host/output_file.h"
#include "host/text.h"
#include "tools/charts/report_page.h"
#include "tools/program/output_guard.h"

namespace metabuffer {
namespace {

constexpr const char* kReportFooter =
    "The page holds all that it shows and needs no network: charts, a table of the points, and each point's\n"
    "settings, figures, report, pictures and the command that runs it by hand. docs/report-page.md describes "
    "it.\n"
    "Conditions are expressions of SQL over the columns that `metabuffer export` writes.\n"
    "Examples:\n"
    "  metabuffer report results.db -o report.html\n"
    "  metabuffer report narrow.db wide.db -o report.html --where 'bus.width_bits >= 64' --title 'Two "
    "buses'\n"
    "Exit status: 0 done; 2 bad input, a file that cannot be written among them.";

}  // namespace

ReportCommand::ReportCommand(CLI::App& program)
    : Command(program, "report", "Put the results of sweeps and searches into a page for a browser") {
    command().add_option("RESULTS", results_files_, "Files of results")->required();
    command().add_option("-o,--output", output_file_, "The page, an HTML file")->required();
    command().add_option("--where", condition_, "Only the points for which this expression is true");
    command().add_option("--title", title_, "The page's title (default: the results' names)");
    command()
        .add_option("--embed-mib", embedded_mebibytes_,
                    "MiB of reports and pictures in the page; what goes beyond is left out")
        ->capture_default_str()
        ->check(CLI::Range(0, 1024));
    command().footer(kReportFooter);
}

ExitStatus ReportCommand::execute() {
    std::vector<std::filesystem::path> files;
    for (const std::string& file : results_files_) {
        files.emplace_back(file);
    }
    refuse_to_replace(files, "-o", output_file_);
    charts::PageOptions options;
    options.title = title_;
    options.condition = condition_;
    options.most_embedded_bytes = static_cast<std::size_t>(embedded_mebibytes_) * charts::kBytesPerMebibyte;
    write_output_file(output_file_, charts::report_page(files, options));
    return kExitDone;
}

}  // namespace metabuffer
