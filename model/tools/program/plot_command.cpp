#include "tools/program/plot_command.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <system_error>
#include <variant>

#include "host/errors.h"
#include "host/output_file.h"
#include "host/text.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/parts_folder.h"
#include "tools/exploration/value.h"
#include "tools/program/output_guard.h"

namespace metabuffer {
namespace {

constexpr const char* kPlotFooter =
    "The charts of `metabuffer report`, for a paper or a slide. EXPR is an expression of SQL over the "
    "columns that\n"
    "`metabuffer export` writes; what is not given is chosen by the results' axes. SVG is drawn by node "
    "(Debian's\n"
    "nodejs), PNG from it by rsvg-convert (librsvg2-bin), at twice the size.\n"
    "Examples:\n"
    "  metabuffer plot results.db -o smallest.svg --x bus.width_bits --y smallest --colour bus.arbitration\n"
    "  metabuffer plot results.db -o glitches.png --chart heatmap --x bus.width_bits --y "
    "composer.buffer_pixels \\\n"
    "      --colour starved_pixels\n"
    "  metabuffer plot results.db -o ratio.png --chart histogram --x 'bound * 1.0 / smallest' --reference "
    "'1:exact'\n"
    "Exit status: 0 done; 2 bad input, a program that is not installed, or a file that cannot be written.";

constexpr int kLeastPixels = 200;
constexpr int kMostPixels = 8000;

/// "320", "320:one source row".
charts::ReferenceLine parse_reference(const std::string& text) {
    const std::size_t colon = text.find(':');
    const exploration::Value value = exploration::value_of(text.substr(0, colon));
    charts::ReferenceLine line;
    if (const auto* whole = std::get_if<std::int64_t>(&value)) {
        line.value = static_cast<double>(*whole);
    } else if (const auto* number = std::get_if<double>(&value)) {
        line.value = *number;
    } else {
        throw InputError("--reference: " + text::quoted(text) +
                         " does not begin with a number; use 320 or '320:label'");
    }
    if (colon != std::string::npos) line.label = text.substr(colon + 1);
    return line;
}

}  // namespace

PlotCommand::PlotCommand(CLI::App& program)
    : Command(program, "plot", "Draw a chart of the results of a sweep or a search as SVG or PNG") {
    command()
        .add_option("RESULTS", results_files_, "Files of results, of one sweep, or folders of them")
        ->required();
    command().add_option("-o,--output", output_file_, "FILE.svg or FILE.png")->required();
    add_chart_options();
    command().footer(kPlotFooter);
}

void PlotCommand::add_chart_options() {
    command()
        .add_option("--chart", chart_, "lines, heatmap, pareto, policy, histogram or scatter")
        ->capture_default_str();
    command().add_option("--x", request_.x, "EXPR along the horizontal axis");
    command().add_option("--y", y_, "EXPR[,EXPR] along the vertical axis; of a heat map the other axis");
    command().add_option("--colour", request_.colour, "EXPR that colours show; of a heat map the figure");
    command().add_option("--facet", request_.facet, "EXPR: a panel for each of its values");
    command().add_option("--label", request_.label,
                         "EXPR: names of the points on a front (default: the settings that vary)");
    command().add_option("--where", request_.condition, "Only the points for which this expression is true");
    command().add_option("--title", request_.title, "Above the chart");
    command().add_option("--x-title", request_.x_title, "Below the horizontal axis");
    command().add_option("--y-title", request_.y_title, "Beside the vertical axis");
    command().add_option("--colour-title", request_.colour_title, "Above the legend");
    command().add_option("--facet-title", request_.facet_title, "Above each panel, before its value");
    command().add_flag("--log-x", request_.log_x,
                       "Logarithmic, as it is anyway for values such as 32, 64, 128");
    command().add_flag("--log-y", request_.log_y, "Logarithmic");
    for (auto& [name, pixels] :
         {std::pair{"--width", &request_.width_pixels}, std::pair{"--height", &request_.height_pixels}}) {
        command()
            .add_option(name, *pixels, "Pixels of the SVG; a PNG has twice as many")
            ->capture_default_str()
            ->check(CLI::Range(kLeastPixels, kMostPixels));
    }
    command().add_option("--reference", references_,
                         "VALUE[:label]: a line across the chart; may be repeated");
}

ExitStatus PlotCommand::execute() {
    const std::string extension = std::filesystem::path(output_file_).extension().string();
    const bool is_png = extension == ".png";
    if (!is_png && extension != ".svg") {
        throw InputError("-o: the format of " + text::quoted(output_file_) +
                         " is not known; use a name that ends in .svg or .png");
    }
    const std::vector<std::filesystem::path> files = exploration::results_in(results_files_);
    refuse_to_replace(files, "-o", output_file_);
    request_.chart = charts::chart_of(chart_);
    if (!y_.empty()) request_.y = exploration::split_expressions(y_);
    for (const std::string& text : references_) request_.references.push_back(parse_reference(text));
    const std::string svg = charts::plot_svg(files, request_);
    write_output_file(output_file_, is_png ? charts::png_of(svg) : svg);
    return kExitDone;
}

}  // namespace metabuffer
