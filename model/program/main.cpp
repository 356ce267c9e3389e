#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>
#include <new>
#include <string_view>
#include <systemc>

#include "program/exit_status.h"
#include "program/run_command.h"
#include "report/picture_writer.h"
#include "scenario/scenario_loader.h"

namespace {

/// A command line that cannot be understood: one line, and where help is.
int report_usage(const CLI::App& program, const CLI::ParseError& error, int argc, char** argv) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
        return program.exit(error);  // --help or --version
    }
    const std::string_view first = argc > 1 ? argv[1] : "";
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && !first.empty() &&
        first.front() != '-' && first != "run") {
        std::cerr << "metabuffer: " << first << " is not a command; use run, or see metabuffer --help\n";
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
    try {
        program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return report_usage(program, error, argc, argv);
    }
    try {
        return run.execute();
    } catch (const metabuffer::InputError& error) {
        std::cerr << error.what() << '\n';
        return metabuffer::kExitBadInput;
    } catch (const metabuffer::OutputError& error) {
        std::cerr << error.what() << '\n';
        return metabuffer::kExitBadInput;
    } catch (const std::bad_alloc&) {
        std::cerr << "metabuffer: this computer does not have the memory for a machine of that size\n";
        return metabuffer::kExitBadInput;
    } catch (const sc_core::sc_report& report) {
        std::cerr << "the model is at fault: " << report.get_msg_type() << ": " << report.get_msg() << '\n';
        return metabuffer::kExitModelError;
    }
}

int main(int argc, char** argv) {
    // The kernel's banner has no place in a program's output.
    setenv("SYSTEMC_DISABLE_COPYRIGHT_MESSAGE", "1", 0);
    return sc_core::sc_elab_and_sim(argc, argv);
}
