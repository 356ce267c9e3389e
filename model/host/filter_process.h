#pragma once

#include <string>
#include <vector>

namespace metabuffer {

/// Another program, by its name on the PATH, that turns its standard input into its standard output.
struct FilterProgram {
    std::vector<std::string> command;
    std::string package;  ///< of Debian, which has it
};

/// What the program makes of the input. Throws OutputError, in one line, if it is not there (naming the package) or
/// fails (with the first line that it complains in).
std::string filtered(const FilterProgram& program, const std::string& input);

}  // namespace metabuffer
