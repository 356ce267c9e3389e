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

std::string fixed(double percent) {
    std::ostringstream text;
    text << std::fixed << std::setprecision(1) << percent;
    return text.str();
}

}  // namespace

void MergedCoverage::add(const Record& record) {
    ++records_;
    for (const auto& [goal, count] : record.counts) {
        Reached& reached = reached_[goal];
        reached.count += count;
        if (reached.first_test.empty() || record.test < reached.first_test) reached.first_test = record.test;
    }
}

MergedCoverage::Reached MergedCoverage::reached(const std::string& group, const std::string& goal) const {
    const auto found = reached_.find(full_name(group, goal));
    return found == reached_.end() ? Reached{} : found->second;
}

std::size_t MergedCoverage::reached_in(const std::string& group) const {
    const std::deque<Goal>& goals = goals_.groups().at(group).goals;
    return static_cast<std::size_t>(std::count_if(
        goals.begin(), goals.end(), [&](const Goal& goal) { return reached(group, goal.name).count > 0; }));
}

double MergedCoverage::percent() const {
    return kHundred * static_cast<double>(goals_reached()) / static_cast<double>(goals_.goal_count());
}

MergedCoverage merge_directory(const std::filesystem::path& directory, const Coverage& goals) {
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
    MergedCoverage merged(goals);
    for (const std::filesystem::path& file : files) {
        for (const Record& record : read_records(file, goals)) merged.add(record);
    }
    return merged;
}

std::string text_report(const MergedCoverage& coverage, double threshold_percent, bool every_goal) {
    std::ostringstream text;
    text << "functional coverage of " << coverage.records() << " machines\n\n";
    for (const auto& [name, group] : coverage.goals().groups()) {
        text << std::left << std::setw(kNameColumns) << name << std::right << std::setw(4)
             << coverage.reached_in(name) << " of " << std::setw(3) << group.goals.size() << "  "
             << group.meaning << '\n';
        for (const Goal& goal : group.goals) {
            const auto [count, first_test] = coverage.reached(name, goal.name);
            if (count == 0) {
                text << "    HOLE  " << goal.name << '\n';
            } else if (every_goal) {
                text << "    " << goal.name << ": " << count << ", first in " << first_test << '\n';
            }
        }
    }
    text << '\n'
         << coverage.goals_reached() << " of " << coverage.goals().goal_count()
         << " goals reached: " << fixed(coverage.percent()) << " %, threshold " << fixed(threshold_percent)
         << " %\n";
    return text.str();
}

std::string json_report(const MergedCoverage& coverage, double threshold_percent) {
    nlohmann::ordered_json json;
    json["machines"] = coverage.records();
    json["goals"] = coverage.goals().goal_count();
    json["reached"] = coverage.goals_reached();
    json["percent"] = coverage.percent();
    json["threshold_percent"] = threshold_percent;
    json["groups"] = nlohmann::ordered_json::array();
    for (const auto& [name, group] : coverage.goals().groups()) {
        nlohmann::ordered_json entry;
        entry["name"] = name;
        entry["meaning"] = group.meaning;
        entry["reached"] = coverage.reached_in(name);
        entry["bins"] = nlohmann::ordered_json::array();
        for (const Goal& goal : group.goals) {
            const auto [count, first_test] = coverage.reached(name, goal.name);
            nlohmann::ordered_json value{{"name", goal.name}, {"count", count}};
            if (count > 0) value["first_test"] = first_test;
            entry["bins"].push_back(std::move(value));
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
