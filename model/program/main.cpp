#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>
#include <string_view>
#include <systemc>

#include "program/compare_command.h"
#include "program/exit_status.h"
#include "program/failure.h"
#include "program/run_command.h"

namespace {

/// A command line that cannot be understood: one line, and where help is.
int report_usage(const CLI::App& program, const CLI::ParseError& error, int argc, char** argv) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
        return program.exit(error);  // --help or --version
    }
    const std::string_view first = argc > 1 ? argv[1] : "";
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && !first.empty() &&
        first.front() != '-' && first != "run" && first != "compare") {
        std::cerr << "metabuffer: " << first
                  << " is not a command; use run or compare, or see metabuffer --help\n";
    } else {
        std::cerr << "metabuffer: " << error.what() << "; see metabuffer --help\n";
    }
    return metabuffer::kExitBadInput;
}

}  // namespace

int sc_main(int argc, char** argv) {
    CLI::App program("The Metabuffer: an executable model of image-compositing hardware", "metabuffer");
    program.require_subcommand(1);
    program.set_version_flag("--version", METABUFFER_VERSION);
    metabuffer::RunCommand run(program);
    metabuffer::CompareCommand compare(program);
    try {
        program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return report_usage(program, error, argc, argv);
    }
    try {
        return compare.chosen() ? compare.execute() : run.execute();
    } catch (...) {
        const metabuffer::Failure failure = metabuffer::current_failure();
        std::cerr << failure.message << '\n';
        return failure.status;
    }
}

int main(int argc, char** argv) {
    // The kernel's banner has no place in a program's output.
    setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);
    return sc_core::sc_elab_and_sim(argc, argv);
}
