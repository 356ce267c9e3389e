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

    /// is_locked: as for uri_to_read(). Throws as merge_results() does.
    void add(const std::filesystem::path& part, bool is_locked = false);
    /// The same, but only for rows after these and for the runs that show these later points.
    void add_later(const std::filesystem::path& part, std::int64_t last_run, std::int64_t last_point,
                   bool is_locked = false);
    /// Removes what is to be run again.
    void remove_retried();
    /// What is missing from all that was added. If axes have grown in between, the larger sweep counts.
    MissingPoints missing();
    /// The same for a sweep with this digest that is cut into so many shards. What is to be tried again counts as
    /// missing.
    MissingPoints missing(const std::string& digest, std::int64_t shards);
    std::int64_t points() const;

  private:
    void check_belongs(const std::filesystem::path& part, const ResultsIdentity& identity);
    void add_rows(std::int64_t last_run, std::int64_t last_point);
    void count_shards();
    void check_columns(const std::filesystem::path& part) const;
    /// What each cut of a sweep lacks, by its digest and the number of its shards.
    using Cuts = std::map<std::pair<std::string, std::int64_t>, MissingPoints>;
    Cuts missing_by_cut(bool with_retried);

    SQLite::Database& target_;
    bool with_reports_;
    bool is_empty_ = true;
    std::filesystem::path first_;  ///< the part that the others are compared with
    ResultsIdentity identity_;
};

}  // namespace metabuffer::exploration
