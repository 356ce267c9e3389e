#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "build_info/build_info.h"
#include "host/errors.h"
#include "host/text.h"
#include "tools/program/analyze_command.h"
#include "tools/program/compare_command.h"
#include "tools/program/counters_command.h"
#include "tools/program/exit_status.h"
#include "tools/program/export_command.h"
#include "tools/program/failure.h"
#include "tools/program/keys_command.h"
#include "tools/program/live_command.h"
#include "tools/program/merge_command.h"
#include "tools/program/plot_command.h"
#include "tools/program/report_command.h"
#include "tools/program/run_command.h"
#include "tools/program/size_command.h"
#include "tools/program/sweep_command.h"
#include "tools/program/view_command.h"

namespace {

using Commands = std::vector<std::unique_ptr<metabuffer::Command>>;

std::vector<std::string> names_of(const Commands& commands) {
    std::vector<std::string> names;
    names.reserve(commands.size());
    std::transform(commands.begin(), commands.end(), std::back_inserter(names),
                   [](const auto& command) { return command->name(); });
    return names;
}

/// Writes what standard output still buffers. Throws OutputError if this or an earlier write failed.
void finish_standard_output() {
    // The stream keeps the failure of an earlier flush.
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout.flush()) {
        throw metabuffer::OutputError("metabuffer: standard output cannot be written");
    }
}

/// Answers --help and --version. For a command line that cannot be understood it throws InputError, with one line that
/// refers to --help.
metabuffer::ExitStatus report_usage(const CLI::App& program, const Commands& commands,
                                    const CLI::ParseError& error, int argc, char** argv) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
        program.exit(error);
        finish_standard_output();
        return metabuffer::kExitDone;
    }
    const std::string first = argc > 1 ? argv[1] : "";
    const std::vector<std::string> names = names_of(commands);
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && !first.empty() &&
        first.front() != '-' && std::find(names.begin(), names.end(), first) == names.end()) {
        throw metabuffer::InputError("metabuffer: " + metabuffer::text::quoted(first) +
                                     " is not a command; use " + metabuffer::text::joined(names, "or") +
                                     ", or see metabuffer --help");
    }
    throw metabuffer::InputError(std::string("metabuffer: ") + error.what() + "; see metabuffer --help");
}

metabuffer::ExitStatus run_command_line(int argc, char** argv) {
    CLI::App program("The Metabuffer: an executable model of image-compositing hardware", "metabuffer");
    program.require_subcommand(1);
    program.set_version_flag("--version", metabuffer::build_description());
    Commands commands;
    commands.push_back(std::make_unique<metabuffer::RunCommand>(program));
    commands.push_back(std::make_unique<metabuffer::LiveCommand>(program));
    commands.push_back(std::make_unique<metabuffer::ViewCommand>(program));
    commands.push_back(std::make_unique<metabuffer::CompareCommand>(program));
    commands.push_back(std::make_unique<metabuffer::SweepCommand>(program));
    commands.push_back(std::make_unique<metabuffer::MergeCommand>(program));
    commands.push_back(std::make_unique<metabuffer::SizeCommand>(program));
    commands.push_back(std::make_unique<metabuffer::AnalyzeCommand>(program));
    commands.push_back(std::make_unique<metabuffer::ReportCommand>(program));
    commands.push_back(std::make_unique<metabuffer::PlotCommand>(program));
    commands.push_back(std::make_unique<metabuffer::ExportCommand>(program));
    commands.push_back(std::make_unique<metabuffer::KeysCommand>(program));
    commands.push_back(std::make_unique<metabuffer::CountersCommand>(program));
    try {
        program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return report_usage(program, commands, error, argc, argv);
    }
    const auto chosen =
        std::find_if(commands.begin(), commands.end(), [](const auto& command) { return command->chosen(); });
    const metabuffer::ExitStatus status = (*chosen)->execute();
    finish_standard_output();
    return status;
}

}  // namespace

int sc_main(int argc, char** argv) {
    try {
        return run_command_line(argc, argv);
    } catch (...) {
        const metabuffer::Failure failure = metabuffer::current_failure();
        std::cerr << failure.message << '\n';
        return failure.status;
    }
}

int main(int argc, char** argv) {
    metabuffer::report_uncaught_exceptions();
    // Without this, a file beyond the size limit would kill the program; so its writer reports an error in one line.
    std::signal(SIGXFSZ, SIG_IGN);
    // The banner of SystemC does not belong in a program's output.
    setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);
    return sc_core::sc_elab_and_sim(argc, argv);
}
