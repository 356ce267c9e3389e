#pragma once

#include <SQLiteCpp/Database.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "tools/exploration/results_merge.h"

namespace metabuffer::exploration {

/// Adds the rows of results files to an open database, which may be empty.
class ResultsMerger {
  public:
    /// with_reports: reports and pictures, too. The database must have been opened with OPEN_URI.
    ResultsMerger(SQLite::Database& target, bool with_reports);

    /// Throws as merge_results() does.
    void add(const std::filesystem::path& part);
    /// The same for rows after these only, and the runs that these points are shown by.
    void add_later(const std::filesystem::path& part, std::int64_t last_run, std::int64_t last_point);
    /// Takes out what is to be run again.
    void remove_retried();
    /// Of all that was added.
    MissingPoints missing();
    /// Of a sweep with this digest that was cut into so many shards.
    MissingPoints missing(const std::string& digest, std::int64_t shards);
    std::int64_t points() const;

  private:
    void check_belongs(const std::filesystem::path& part, const ResultsIdentity& identity);
    void add_rows(std::int64_t last_run, std::int64_t last_point);
    void count_shards();
    std::map<std::pair<std::string, std::int64_t>, MissingPoints> missing_by_cut();

    SQLite::Database& target_;
    bool with_reports_;
    bool is_empty_ = true;
    std::filesystem::path first_;  ///< what the others are compared with
    ResultsIdentity identity_;
};

}  // namespace metabuffer::exploration
