#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "support/scratch_directory.h"

namespace metabuffer::test {

/// What a run of the program gave.
struct ProgramResult {
    int status = -1;
    std::string out;
    std::string err;

    /// Whether stderr is one whole line.
    bool complains_in_one_line() const;
};

/// Runs the built program and waits for it.
ProgramResult run_program(const ScratchDirectory& scratch, const std::vector<std::string>& arguments);
/// The same with another program than the built one.
ProgramResult run_program(const std::filesystem::path& program, const ScratchDirectory& scratch,
                          const std::vector<std::string>& arguments);

/// Refused as bad input: one line on stderr that holds all the words, and nothing on stdout.
void check_refused(const ProgramResult& result, const std::vector<std::string>& words);

/// Runs a script by the shell. In it "$0" is the built program, whatever letters its path has.
ProgramResult run_script(const ScratchDirectory& scratch, const std::string& script);

std::string text_of(const std::filesystem::path& file);

/// A value change dump, as far as these tests need it.
class Waveform {
  public:
    explicit Waveform(const std::filesystem::path& file);

    /// Picoseconds, of the initial values and of the last change.
    std::int64_t first_time() const { return first_time_; }
    std::int64_t last_time() const { return last_time_; }
    /// Names below the machine, "composer_1_2.BUSREADY".
    bool has(const std::string& name) const { return identifiers_.count(name) != 0; }
    std::vector<std::string> names() const;
    /// When a one-bit signal first rose within the dump; -1 if it did not.
    std::int64_t first_rise(const std::string& name) const;
    std::int64_t first_fall(const std::string& name) const;

  private:
    struct Change {
        std::int64_t time = 0;
        char value = 0;
    };

    void read_variable(const std::string& line, const std::vector<std::string>& scopes);
    std::int64_t first_change(const std::string& name, char from, char to) const;

    std::int64_t first_time_ = -1;
    std::int64_t last_time_ = -1;
    std::map<std::string, std::string> identifiers_;
    std::map<std::string, std::vector<Change>> changes_;  ///< of one-bit signals, by identifier
};

}  // namespace metabuffer::test
