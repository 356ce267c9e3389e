#include "tools/program/failure.h"

#include <sysc/kernel/sc_kernel_ids.h>
#include <unistd.h>

#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <system_error>
#include <systemc>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer {

namespace {

constexpr const char* kNoMemory =
    "metabuffer: this computer does not have the memory for a machine of that size";

constexpr const char* kRefused =
    "metabuffer: this computer refuses what a run needs: memory, a thread or a process; raise its limits";

[[noreturn]] void end_with(const char* line, std::size_t length, ExitStatus status) {
    // If this cannot be written, there is no other way to report it.
    static_cast<void>(!::write(STDERR_FILENO, line, length));
    static_cast<void>(!::write(STDERR_FILENO, "\n", 1));
    _exit(status);
}

/// Ends the program for an exception that nothing handles. There may be no memory left to report it.
[[noreturn]] void end_on_uncaught_exception() {
    try {
        Failure failure{kExitModelError, "the program is at fault: it ended itself"};
        if (std::current_exception() != nullptr) {
            failure = current_failure();
        } else if (std::uncaught_exceptions() > 0) {
            // A library ends like this if it cannot start all of its threads: it does not join those that it started.
            failure = {kExitBadInput, kRefused};
        }
        end_with(failure.message.data(), failure.message.size(), failure.status);
    } catch (...) {
        end_with(kNoMemory, std::strlen(kNoMemory), kExitBadInput);
    }
}

}  // namespace

Failure current_failure() {
    try {
        throw;
    } catch (const InputError& error) {
        return {kExitBadInput, text::message(error.what())};
    } catch (const OutputError& error) {
        return {kExitBadInput, text::message(error.what())};
    } catch (const std::bad_alloc&) {
        return {kExitBadInput, kNoMemory};
    } catch (const std::filesystem::filesystem_error& error) {
        return {kExitBadInput,
                text::message("metabuffer: " + text::quoted(error.path1().string()) +
                              " cannot be used: " + error.code().message() + "; name another path")};
    } catch (const std::system_error& error) {
        return {kExitBadInput, text::message("metabuffer: this computer refuses what a run needs: " +
                                             error.code().message())};
    } catch (const sc_core::sc_report& report) {
        // SystemC turns what a process throws into a report, which keeps only the exception's text.
        const bool thrown =
            std::strcmp(report.get_msg_type(), sc_core::SC_ID_SIMULATION_UNCAUGHT_EXCEPTION_) == 0;
        if (thrown && std::strcmp(report.get_msg(), std::bad_alloc().what()) == 0) {
            return {kExitBadInput, kNoMemory};
        }
        return {kExitModelError, text::message(std::string("the model is at fault: ") +
                                               report.get_msg_type() + ": " + report.get_msg())};
    } catch (const std::exception& error) {
        return {kExitModelError, text::message(std::string("the program is at fault: ") + error.what())};
    }
}

void report_uncaught_exceptions() { std::set_terminate(end_on_uncaught_exception); }

}  // namespace metabuffer
