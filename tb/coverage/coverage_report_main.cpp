#include <CLI/CLI.hpp>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>

#include "coverage_recorder.h"
#include "coverage_report.h"

// Merges what the tests have left in a folder and reports it, for scripts/coverage.

using namespace metabuffer::coverage;

namespace {

constexpr int kBadInput = 2;
constexpr int kBelowThreshold = 3;

struct Options {
    std::string directory;
    std::string threshold;
    std::string text_file;
    std::string json_file;
    bool every_goal = false;
};

void write(const std::string& file, const std::string& text) {
    if (file.empty()) return;
    std::ofstream out(file);
    out << text << std::flush;
    if (!out) throw CoverageFileError(file + ": cannot be written");
}

int report(const Options& options) {
    const double threshold = read_threshold(options.threshold);
    Coverage goals;
    declare_machine_goals(goals);
    const MergedCoverage coverage = merge_directory(options.directory, goals);
    write(options.text_file, text_report(coverage, threshold, true));
    write(options.json_file, json_report(coverage, threshold));
    std::cout << text_report(coverage, threshold, options.every_goal);
    return coverage.percent() < threshold ? kBelowThreshold : EXIT_SUCCESS;
}

}  // namespace

// Nothing is simulated, but the samplers, which declare the goals, refer to SystemC's signals.
int sc_main(int argc, char** argv) {
    CLI::App app{
        "Merges functional coverage and reports what is missing.\n"
        "Exit status: 0 threshold reached; 3 it is not; 2 bad input."};
    Options options;
    app.add_option("DIR", options.directory, "folder that tests filled by METABUFFER_COVERAGE=DIR")
        ->required();
    app.add_option("--threshold", options.threshold, "file that holds the least percentage")->required();
    app.add_option("--text", options.text_file, "also write the report with every goal here");
    app.add_option("--json", options.json_file, "also write it as JSON here");
    app.add_flag("--all", options.every_goal, "print the goals that are reached as well");
    try {
        app.parse(argc, argv);
        return report(options);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? EXIT_SUCCESS : kBadInput;
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return kBadInput;
    }
}

int main(int argc, char** argv) {
    setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);
    return sc_core::sc_elab_and_sim(argc, argv);
}
