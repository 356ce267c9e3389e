#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace metabuffer {

/// Another program, by its name on the PATH, that turns its standard input into its standard output.
struct FilterProgram {
    std::vector<std::string> command;
    std::string package;  ///< of Debian, that has it
    std::string needed_by = "the chart";
};

/// Such a program while it runs. Its error output is kept, and shown only if it fails.
class FilterProcess {
  public:
    /// Throws OutputError, in one line, if it is not there (naming the package) or cannot be started.
    explicit FilterProcess(const FilterProgram& program);
    FilterProcess(const FilterProcess&) = delete;
    FilterProcess& operator=(const FilterProcess&) = delete;
    /// Ends it if it still runs.
    ~FilterProcess();

    /// Sends input. If the program reads no more, the input is lost without an error: finish() reports how the program
    /// ended.
    void feed(std::string_view input);
    /// Ends its input, waits for its end and returns its output. Throws OutputError if it fails, with its first error
    /// line.
    std::string finish();

  private:
    struct Running;

    void exchange(std::string_view& input);

    FilterProgram program_;
    std::unique_ptr<Running> running_;
    std::string output_;
    std::string complaints_;
};

/// Whether the PATH has it.
bool is_installed(const FilterProgram& program);

/// The program's output for the input. Throws OutputError, in one line, if it is not there (naming the package) or
/// fails (with its first error line).
std::string filtered(const FilterProgram& program, const std::string& input);

}  // namespace metabuffer
