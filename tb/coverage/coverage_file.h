#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "coverage.h"

namespace metabuffer::coverage {

/// A coverage file that cannot be read or written. what() is one line: which file, where, what is wrong.
class CoverageFileError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// What one machine of a test has reached.
struct Record {
    std::string test;                            ///< the test's name
    std::map<std::string, std::int64_t> counts;  ///< by the goals' full names; above 0
};

Record record_of(const std::string& test, const Coverage& coverage);

/// Adds a record to a file, which is created if it does not exist. A record is text:
///     test NAME
///     COUNT GROUP: BIN      a line for each goal that was reached
///     end
/// Throws CoverageFileError.
void append_record(const std::filesystem::path& file, const Record& record);

/// Throws CoverageFileError for a damaged file: a goal that is not in `goals`, a count that is not a number above 0, a
/// record without its end.
std::vector<Record> read_records(const std::filesystem::path& file, const Coverage& goals);

}  // namespace metabuffer::coverage
