#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "coverage_file.h"

namespace metabuffer::coverage {

/// What all tests together have reached.
class MergedCoverage {
  public:
    MergedCoverage() : first_test_(goal_count()) {}

    void add(const Record& record);
    std::int64_t count(std::size_t goal) const { return sum_.count(goal); }
    /// The test that reached it, the first by name; empty if none has.
    const std::string& first_test(std::size_t goal) const { return first_test_[goal]; }
    std::size_t reached() const;
    std::size_t records() const { return records_; }
    double percent() const;

  private:
    Coverage sum_;
    std::vector<std::string> first_test_;
    std::size_t records_ = 0;
};

/// Every file DIR/*.coverage, in the order of their names. Throws CoverageFileError, also if there is none.
MergedCoverage merge_directory(const std::filesystem::path& directory);

/// The report for people: a line for each group, under it the holes by name; with `every_goal` the goals that are
/// reached as well, how often and first by which test.
std::string text_report(const MergedCoverage& coverage, double threshold_percent, bool every_goal);

/// The same for programs.
std::string json_report(const MergedCoverage& coverage, double threshold_percent);

/// The number in a file of one number and lines of comment behind '#'. Throws CoverageFileError.
double read_threshold(const std::filesystem::path& file);

}  // namespace metabuffer::coverage
