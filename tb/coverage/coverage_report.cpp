#include "coverage_report.h"

#include <algorithm>
#include <fstream>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

namespace metabuffer::coverage {
namespace {

constexpr double kHundred = 100.0;
constexpr int kNameColumns = 28;

std::size_t reached_in(const MergedCoverage& coverage, std::size_t first, std::size_t count) {
    std::size_t reached = 0;
    for (std::size_t goal = first; goal < first + count; ++goal) reached += coverage.count(goal) > 0 ? 1 : 0;
    return reached;
}

std::string fixed(double percent) {
    std::ostringstream text;
    text << std::fixed << std::setprecision(1) << percent;
    return text.str();
}

}  // namespace

void MergedCoverage::add(const Record& record) {
    ++records_;
    sum_.add(record.coverage);
    for (std::size_t goal = 0; goal < first_test_.size(); ++goal) {
        std::string& first = first_test_[goal];
        if (record.coverage.count(goal) > 0 && (first.empty() || record.test < first)) first = record.test;
    }
}

std::size_t MergedCoverage::reached() const { return reached_in(*this, 0, goal_count()); }

double MergedCoverage::percent() const {
    return kHundred * static_cast<double>(reached()) / static_cast<double>(goal_count());
}

MergedCoverage merge_directory(const std::filesystem::path& directory) {
    std::vector<std::filesystem::path> files;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(directory, error)) {
        if (entry.path().extension() == ".coverage") files.push_back(entry.path());
    }
    if (error) throw CoverageFileError(directory.string() + ": " + error.message());
    if (files.empty()) {
        throw CoverageFileError(
            directory.string() +
            ": holds no *.coverage; run the tests with METABUFFER_COVERAGE=" + directory.string());
    }
    std::sort(files.begin(), files.end());
    MergedCoverage merged;
    for (const std::filesystem::path& file : files) {
        for (const Record& record : read_records(file)) merged.add(record);
    }
    return merged;
}

std::string text_report(const MergedCoverage& coverage, double threshold_percent, bool every_goal) {
    std::ostringstream text;
    text << "functional coverage of " << coverage.records() << " machines\n\n";
    std::size_t first = 0;
    for (const GoalGroup& group : goal_groups()) {
        const std::size_t reached = reached_in(coverage, first, group.bins.size());
        text << std::left << std::setw(kNameColumns) << group.name << std::right << std::setw(4) << reached
             << " of " << std::setw(3) << group.bins.size() << "  " << group.meaning << '\n';
        for (std::size_t i = 0; i < group.bins.size(); ++i) {
            const std::int64_t count = coverage.count(first + i);
            if (count == 0) {
                text << "    HOLE  " << group.bins[i] << '\n';
            } else if (every_goal) {
                text << "    " << group.bins[i] << ": " << count << ", first in "
                     << coverage.first_test(first + i) << '\n';
            }
        }
        first += group.bins.size();
    }
    text << '\n'
         << coverage.reached() << " of " << goal_count() << " goals reached: " << fixed(coverage.percent())
         << " %, threshold " << fixed(threshold_percent) << " %\n";
    return text.str();
}

std::string json_report(const MergedCoverage& coverage, double threshold_percent) {
    nlohmann::ordered_json json;
    json["machines"] = coverage.records();
    json["goals"] = goal_count();
    json["reached"] = coverage.reached();
    json["percent"] = coverage.percent();
    json["threshold_percent"] = threshold_percent;
    json["groups"] = nlohmann::ordered_json::array();
    std::size_t goal = 0;
    for (const GoalGroup& group : goal_groups()) {
        nlohmann::ordered_json entry;
        entry["name"] = group.name;
        entry["meaning"] = group.meaning;
        entry["reached"] = reached_in(coverage, goal, group.bins.size());
        entry["bins"] = nlohmann::ordered_json::array();
        for (const std::string& bin : group.bins) {
            nlohmann::ordered_json value{{"name", bin}, {"count", coverage.count(goal)}};
            if (coverage.count(goal) > 0) value["first_test"] = coverage.first_test(goal);
            entry["bins"].push_back(std::move(value));
            ++goal;
        }
        json["groups"].push_back(std::move(entry));
    }
    return json.dump(1) + "\n";
}

double read_threshold(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line;
    while (std::getline(in, line)) {
        if (line.empty() || line.front() == '#') continue;
        std::istringstream number(line);
        double percent = 0.0;
        if (number >> percent && number.eof() && percent >= 0.0 && percent <= kHundred) return percent;
        throw CoverageFileError(file.string() + ": \"" + line + "\" is no percentage: 0 to 100");
    }
    throw CoverageFileError(file.string() + ": holds no percentage");
}

}  // namespace metabuffer::coverage
