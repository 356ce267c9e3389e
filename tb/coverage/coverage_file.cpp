#include "coverage_file.h"

#include <charconv>
#include <cstdint>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>

namespace metabuffer::coverage {
namespace {

constexpr std::string_view kTest = "test ";
constexpr std::string_view kEnd = "end";

bool starts_with(std::string_view text, std::string_view start) {
    return text.substr(0, start.size()) == start;
}

/// Reads the lines of one file.
class RecordReader {
  public:
    RecordReader(const std::filesystem::path& file, const Coverage& goals)
        : file_(file), in_(file), goals_(goals) {
        if (!in_) throw CoverageFileError(file.string() + ": cannot be read");
    }

    std::vector<Record> read() {
        std::vector<Record> records;
        while (next()) {
            if (!starts_with(line_, kTest)) fail("expected \"test NAME\"");
            records.push_back(read_record(line_.substr(kTest.size())));
        }
        if (records.empty()) throw CoverageFileError(file_.string() + ": holds no record");
        return records;
    }

  private:
    bool next() {
        ++number_;
        return static_cast<bool>(std::getline(in_, line_));
    }

    Record read_record(std::string test) {
        Record record{std::move(test), {}};
        while (next()) {
            if (line_ == kEnd) return record;
            read_count(record);
        }
        fail("the record ends without \"end\"");
    }

    void read_count(Record& record) {
        std::int64_t count = 0;
        const char* first = line_.data();
        const auto [end, error] = std::from_chars(first, first + line_.size(), count);
        const auto digits = static_cast<std::size_t>(end - first);
        if (error != std::errc() || count < 1 || line_.substr(digits, 1) != " " ||
            line_.find(kBehindGroup) == std::string::npos) {
            fail("expected \"COUNT GROUP: BIN\"");
        }
        const std::string goal = line_.substr(digits + 1);
        if (!goals_.has_goal(goal)) fail("there is no goal \"" + goal + "\"");
        record.counts[goal] += count;
    }

    [[noreturn]] void fail(const std::string& what) const {
        throw CoverageFileError(file_.string() + ":" + std::to_string(number_) + ": " + what);
    }

    std::filesystem::path file_;
    std::ifstream in_;
    const Coverage& goals_;
    std::string line_;
    int number_ = 0;
};

}  // namespace

Record record_of(const std::string& test, const Coverage& coverage) {
    Record record{test, {}};
    for (const auto& [name, group] : coverage.groups()) {
        for (const Goal& goal : group.goals) {
            if (goal.count > 0) record.counts[full_name(name, goal.name)] = goal.count;
        }
    }
    return record;
}

void append_record(const std::filesystem::path& file, const Record& record) {
    std::ostringstream text;
    text << kTest << record.test << '\n';
    for (const auto& [goal, count] : record.counts) text << count << ' ' << goal << '\n';
    text << kEnd << '\n';
    std::error_code ignored;  // the stream then fails
    std::filesystem::create_directories(file.parent_path(), ignored);
    std::ofstream out(file, std::ios::app);
    out << text.str() << std::flush;
    if (!out) throw CoverageFileError(file.string() + ": cannot be written");
}

std::vector<Record> read_records(const std::filesystem::path& file, const Coverage& goals) {
    return RecordReader(file, goals).read();
}

}  // namespace metabuffer::coverage
