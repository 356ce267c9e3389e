#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/exploration/results_database.h"

namespace metabuffer::exploration {

/// What the results lack of a sweep that was cut into shards.
struct MissingPoints {
    std::vector<std::int64_t> shards;             ///< those without results, from 1
    std::vector<std::int64_t> unfinished_shards;  ///< those with some of their results
    std::int64_t shard_count = 1;
    std::int64_t points = 0;         ///< not ended, of the shards with results
    std::int64_t points_wanted = 0;  ///< all points of the shards with results

    bool complete() const { return shards.empty() && points == 0; }
};

/// For a sweep that was cut into so many shards and has no results yet.
MissingPoints all_missing(std::int64_t shards);

/// The outcome of a merge.
struct Merge {
    std::size_t files = 0;
    std::int64_t points = 0;      ///< in the target now
    std::int64_t new_points = 0;  ///< of these, those that it did not have before
    MissingPoints missing;
};

/// Puts results of one sweep into one file. What the target holds stays. A point that several files hold appears once;
/// if it crashed or was invalid in one, a better outcome of another replaces that. The target is put in place as a
/// whole, or stays as it was. It may be one of the parts. Throws InputError for a part that cannot be read, that
/// another program build wrote or that belongs to another sweep, and if a sweep adds to the target; OutputError if it
/// cannot be written.
Merge merge_results(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& target);

}  // namespace metabuffer::exploration
