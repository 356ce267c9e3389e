#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "coverage_file.h"

namespace metabuffer::coverage {

/// What all tests together have reached.
class MergedCoverage {
  public:
    struct Reached {
        std::int64_t count = 0;
        std::string first_test;  ///< the first by name; empty if none has reached it
    };

    /// The goals must outlive it; their counts do not matter.
    explicit MergedCoverage(const Coverage& goals) : goals_(goals) {}

    void add(const Record& record);
    const Coverage& goals() const { return goals_; }
    Reached reached(const std::string& group, const std::string& goal) const;
    std::size_t reached_in(const std::string& group) const;
    std::size_t goals_reached() const { return reached_.size(); }
    std::size_t records() const { return records_; }
    double percent() const;

  private:
    const Coverage& goals_;
    std::map<std::string, Reached> reached_;  ///< by full name
    std::size_t records_ = 0;
};

/// Every file DIR/*.coverage, in the order of their names. Throws CoverageFileError, also if there is none.
MergedCoverage merge_directory(const std::filesystem::path& directory, const Coverage& goals);

/// The report for people: a line for each group, under it the holes by name; with `every_goal` the goals that are
/// reached as well, how often and first by which test.
std::string text_report(const MergedCoverage& coverage, double threshold_percent, bool every_goal);

/// The same for programs.
std::string json_report(const MergedCoverage& coverage, double threshold_percent);

/// The number in a file of one number and lines of comment behind '#'. Throws CoverageFileError.
double read_threshold(const std::filesystem::path& file);

}  // namespace metabuffer::coverage
