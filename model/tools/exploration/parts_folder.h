#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/temporary_folder.h"
#include "tools/exploration/results_database.h"
#include "tools/exploration/results_merge.h"

namespace metabuffer::exploration {

/// The results files that a name on a command line stands for: the file, or all *.db files of the folder, by name.
/// Throws InputError if there is none.
std::vector<std::filesystem::path> results_in(const std::filesystem::path& path);
std::vector<std::filesystem::path> results_in(const std::vector<std::string>& paths);

/// The *.db files of a folder by name, without an error if there are none. Throws InputError if it cannot be read.
std::vector<std::filesystem::path> parts_in(const std::filesystem::path& folder);

/// How many points a file of results holds. Throws InputError.
std::int64_t points_in(const std::filesystem::path& file);

/// Throws InputError if the file holds results of something else.
void check_belongs(const std::filesystem::path& file, const ResultsIdentity& identity);

/// What the results in a folder lack of their sweep; empty if there are no results. Throws InputError if they do not
/// belong to the sweep.
std::optional<MissingPoints> missing_in(const std::filesystem::path& folder, const ResultsIdentity& identity,
                                        const std::string& digest, std::int64_t shards);

/// The results of one shard, on the way to a folder that computers share. They are written to a disk of this computer,
/// since SQLite's locks need not work elsewhere. From time to time the new ones are handed in as a file of their own, put
/// in place by renaming it. So nothing is written twice, two processes that run the same shard do no harm, and one that
/// is killed loses only what it has not handed in.
class PartsFolder {
  public:
    /// Begins with what the folder holds of the shard. The folder must exist. Throws InputError if it holds results of
    /// another sweep or build, OutputError if the local file cannot be written.
    PartsFolder(std::filesystem::path folder, const ResultsIdentity& identity, ShardRecord shard,
                std::chrono::seconds interval);

    ResultsDatabase& results() { return *results_; }
    /// ended: points of the shard that have ended so far.
    void hand_in(std::int64_t ended);
    /// The same, if there is something new and the last time was longer ago than the interval.
    void hand_in_if_due(std::int64_t ended);

  private:
    struct Limits {
        std::int64_t run = 0;
        std::int64_t point = 0;
    };
    Limits last_rows() const;
    std::string name_of_part() const;
    bool holds_only_other_shards(const std::filesystem::path& file) const;

    std::filesystem::path folder_;
    ResultsIdentity identity_;
    ShardRecord shard_;
    std::chrono::seconds interval_;
    TemporaryFolder scratch_;
    std::filesystem::path file_;  ///< on this computer's disk
    std::optional<ResultsDatabase> results_;
    Limits handed_in_;
    std::chrono::steady_clock::time_point last_time_ = std::chrono::steady_clock::now();
};

}  // namespace metabuffer::exploration
