#include "tools/program/export_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string_view>
#include <vector>

#include "host/errors.h"
#include "host/output_file.h"
#include "host/text.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/parts_folder.h"
#include "tools/exploration/results_database.h"
#include "tools/program/output_guard.h"
#include "tools/program/results_table.h"

namespace metabuffer {
namespace {

constexpr const char* kCsv = "csv";
constexpr const char* kJson = "json";

constexpr const char* kExamples =
    "A row for each point: its settings, how it ended, and the figures of its run, in the order of the "
    "axes'\n"
    "values. Conditions and columns are expressions of SQL over these names. docs/results.md has the syntax "
    "and\n"
    "the file's tables.\n"
    "Examples:\n"
    "  metabuffer export results.db -o results.csv\n"
    "  metabuffer export results.db --format json --where \"status <> 'done'\"\n"
    "  metabuffer export results.db --where 'whole and bus.width_bits <= 64' \\\n"
    "      --columns 'bus.width_bits, composer.buffer_pixels, round(frames_per_second, 1)'\n"
    "Exit status: 0 done; 2 bad input, a file that cannot be written among them.\n"
    "Figures:\n";

std::string footer() {
    std::string text = kExamples;
    for (const exploration::FigureKind& figure : exploration::figure_kinds()) {
        const std::string unit = figure.unit;
        text += std::string("  ") + figure.name + (unit.empty() ? "" : " (" + unit + ")") + ": " +
                figure.meaning + "\n";
    }
    text.pop_back();
    return text;
}

}  // namespace

ExportCommand::ExportCommand(CLI::App& program)
    : Command(program, "export", "Write the results of a sweep or a search as CSV or JSON") {
    command()
        .add_option("RESULTS", results_files_, "Files of results, of one sweep, or folders of them")
        ->required();
    command()
        .add_option("--format", format_, "csv or json (default: as -o ends, else csv)")
        ->check(CLI::IsMember({kCsv, kJson}));
    command().add_option("-o,--output", output_file_, "File to write (default: standard output)");
    CLI::Option* const runs =
        command().add_flag("--runs", runs_, "A row for each simulation instead, those of searches included");
    command()
        .add_option("--where", condition_, "Only the points for which this expression is true")
        ->excludes(runs);
    command()
        .add_option("--columns", columns_,
                    "These columns, expressions with commas in between (default: all that do not depend on "
                    "when and where a point ran)")
        ->excludes(runs);
    command()
        .add_flag("--bookkeeping", bookkeeping_,
                  "Columns point, run and wall_seconds, too, which depend on when and where a point ran")
        ->excludes(runs);
    command().footer(footer());
}

std::string ExportCommand::format() const {
    if (!format_.empty()) return format_;
    if (output_file_.empty()) return kCsv;
    const std::string extension = std::filesystem::path(output_file_).extension().string();
    if (extension == std::string(".") + kCsv) return kCsv;
    if (extension == std::string(".") + kJson) return kJson;
    throw InputError("-o: the format of " + text::quoted(output_file_) +
                     " is not known; use a name that ends in .csv or .json, or --format");
}

void ExportCommand::write(const exploration::ResultsReader& reader,
                          const exploration::TableText::Sink& sink) const {
    const auto kind = format() == kJson ? exploration::TableFormat::kJson : exploration::TableFormat::kCsv;
    if (runs_) {
        const exploration::ResultsReader::Table table = reader.runs();
        exploration::TableText text(kind, table.columns, sink);
        for (const auto& row : table.rows) text.add(row);
        text.end();
        return;
    }
    TableColumns table = table_columns(reader, condition_, columns_, bookkeeping_);
    exploration::TableText text(kind, std::move(table.names), sink);
    reader.each_result(table.expressions, condition_, [&text](const auto& row) { text.add(row); });
    text.end();
}

ExitStatus ExportCommand::execute() {
    const std::vector<std::filesystem::path> files = exploration::results_in(results_files_);
    refuse_to_replace(files, "-o", output_file_);
    format();  // throws for an unknown format before anything is written
    const exploration::ResultsReader reader(files);
    if (output_file_.empty()) {
        write(reader, [](std::string_view bytes) { std::cout << bytes; });
        return kExitDone;
    }
    table_columns(reader, condition_, columns_, bookkeeping_);  // throws before the file is opened
    OutputFile output(output_file_);
    write(reader, [&output](std::string_view bytes) { output.write(bytes); });
    output.put_in_place();
    return kExitDone;
}

}  // namespace metabuffer
