#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace metabuffer {

/// Another program, by its name on the PATH, that turns its standard input into its standard output.
struct FilterProgram {
    std::vector<std::string> command;
    std::string package;  ///< of Debian, which has it
    std::string needed_by = "the chart";
};

/// Such a program at work. Its complaints are kept, and shown only if it fails.
class FilterProcess {
  public:
    /// Throws OutputError, in one line, if it is not there (naming the package) or cannot be started.
    explicit FilterProcess(const FilterProgram& program);
    FilterProcess(const FilterProcess&) = delete;
    FilterProcess& operator=(const FilterProcess&) = delete;
    /// Ends it if it is still at work.
    ~FilterProcess();

    /// Hands input over. What a program that reads no more is given is lost, without an error: finish() says how it
    /// ended.
    void feed(std::string_view input);
    /// The end of its input: waits for its end and returns its output. Throws OutputError if it fails, with the first
    /// line that it complains in.
    std::string finish();

  private:
    struct Running;

    void exchange(std::string_view& input);

    FilterProgram program_;
    std::unique_ptr<Running> running_;
    std::string output_;
    std::string complaints_;
};

/// Whether the PATH leads to it.
bool is_installed(const FilterProgram& program);

/// What the program makes of the input. Throws OutputError, in one line, if it is not there (naming the package) or
/// fails (with the first line that it complains in).
std::string filtered(const FilterProgram& program, const std::string& input);

}  // namespace metabuffer
