#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/exploration/results_database.h"

namespace metabuffer::exploration {

/// What is not there yet of a sweep that was cut.
struct MissingPoints {
    std::vector<std::int64_t> shards;             ///< of which there are no results, from 1
    std::vector<std::int64_t> unfinished_shards;  ///< of which there are some
    std::int64_t shard_count = 1;
    std::int64_t points = 0;         ///< not ended, of the shards that are there
    std::int64_t points_wanted = 0;  ///< of the shards that are there, all in all

    bool complete() const { return shards.empty() && points == 0; }
};

/// Of a sweep that was cut into so many shards and of which there is nothing yet.
MissingPoints all_missing(std::int64_t shards);

/// What came of a merge.
struct Merge {
    std::size_t files = 0;
    std::int64_t points = 0;      ///< in the target now
    std::int64_t new_points = 0;  ///< of these, those that it had not
    MissingPoints missing;
};

/// Puts results of one sweep into one file. What the target holds stays; a point that several files hold comes once, and
/// one that crashed or was invalid gives way to one that was not. The target is put in place whole, or stays as it was;
/// it may be one of the parts. Throws InputError for a part that cannot be read, that another program build wrote or
/// that belongs to another sweep, and if a sweep adds to the target; OutputError if it cannot be written.
Merge merge_results(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& target);

}  // namespace metabuffer::exploration
