#include "tools/program/merge_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "host/errors.h"
#include "host/text.h"
#include "tools/exploration/parts_folder.h"
#include "tools/exploration/results_merge.h"
#include "tools/program/exploration_run.h"

namespace metabuffer {
namespace {

constexpr const char* kMergeFooter =
    "Parts are what metabuffer sweep --shard has written: files, or folders with all of their *.db files. "
    "They must\n"
    "be of one sweep and of one build. A point that several files hold comes once, so merging again changes "
    "nothing,\n"
    "and what -o holds already stays. docs/cluster.md has more.\n"
    "Examples:\n"
    "  metabuffer merge part-*.db -o all.db\n"
    "  metabuffer merge /shared/parts -o all.db\n"
    "Exit status: 0 every point of the sweep has ended; 2 bad input, and nothing is written; 6 merged, but "
    "points\n"
    "are missing: metabuffer sweep SWEEP -o all.db runs them.";

/// "3, 5 and 7".
std::string listed(const std::vector<std::int64_t>& numbers) {
    constexpr std::size_t kMost = 20;
    std::vector<std::string> words;
    for (std::size_t n = 0; n < std::min(numbers.size(), kMost); ++n)
        words.push_back(std::to_string(numbers[n]));
    if (numbers.size() > kMost) words.push_back(std::to_string(numbers.size() - kMost) + " more");
    return text::joined(words, "and");
}

std::string described(const exploration::MissingPoints& missing) {
    std::string words;
    if (!missing.shards.empty()) {
        words = std::string(missing.shards.size() == 1 ? "shard " : "shards ") + listed(missing.shards) +
                " of " + std::to_string(missing.shard_count);
    }
    if (missing.points > 0) {
        words += (words.empty() ? "" : ", and ") + std::to_string(missing.points) + " of the " +
                 std::to_string(missing.points_wanted) + " points" +
                 (missing.shards.empty() ? "" : " of the other shards");
    }
    return words;
}

}  // namespace

MergeCommand::MergeCommand(CLI::App& program)
    : Command(program, "merge", "Put the results of a sweep that was cut into shards into one file") {
    command().add_option("PARTS", parts_, "Files of results, or folders of them")->required();
    command().add_option("-o,--out", results_file_, "The results, an SQLite file")->required();
    command().add_flag("--quiet", quiet_, "Print only what is missing");
    command().footer(kMergeFooter);
}

ExitStatus MergeCommand::execute() {
    const std::vector<std::filesystem::path> files = exploration::results_in(parts_);
    make_folder_of(results_file_, "--out");
    const exploration::Merge merge = exploration::merge_results(files, results_file_);
    if (!quiet_) {
        std::cout << text::counted(static_cast<std::int64_t>(merge.files), "file") << ", "
                  << text::counted(merge.points, "point") << ", " << merge.new_points
                  << " of them new: " << results_file_ << '\n';
    }
    if (merge.missing.complete()) return kExitDone;
    std::cerr << "missing: " << described(merge.missing) << '\n';
    return kExitIncomplete;
}

}  // namespace metabuffer
