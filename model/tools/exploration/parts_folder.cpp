#include "tools/exploration/parts_folder.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <random>
#include <system_error>
#include <utility>

#include "host/errors.h"
#include "host/output_file.h"
#include "host/text.h"
#include "tools/exploration/results_file.h"
#include "tools/exploration/results_merger.h"

namespace metabuffer::exploration {
namespace {

constexpr const char* kEnding = ".db";

}  // namespace

std::vector<std::filesystem::path> parts_in(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code error;
    for (auto entry = std::filesystem::directory_iterator(folder, error);
         !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
        // A name that begins with a dot is that of a file that is still being written.
        if (entry->path().extension() == kEnding && entry->path().filename().string().front() != '.') {
            files.push_back(entry->path());
        }
    }
    if (error) {
        throw InputError("'" + folder.string() + "' cannot be read: " + error.message());
    }
    std::sort(files.begin(), files.end());
    return files;
}

void check_belongs(const std::filesystem::path& file, const ResultsIdentity& identity) {
    const std::string difference = difference_between(identity_of(file), identity);
    if (!difference.empty()) {
        throw InputError("'" + file.string() + "' holds results " + difference +
                         "; name another, or remove it");
    }
}

namespace {

std::string host_name() {
    std::array<char, 256> name{};
    if (gethostname(name.data(), name.size() - 1) != 0) return "host";
    return name.data();
}

void copy_into_place(const std::filesystem::path& from, const std::filesystem::path& to) {
    std::ifstream input(from, std::ios::binary);
    if (!input) fail_to_write(to, "'" + from.string() + "' cannot be read");
    OutputFile output(to);
    std::vector<char> part(1U << 20U);
    while (input.read(part.data(), static_cast<std::streamsize>(part.size())) || input.gcount() > 0) {
        output.write({part.data(), static_cast<std::size_t>(input.gcount())});
    }
    if (!input.eof()) fail_to_write(to, "'" + from.string() + "' cannot be read");
    output.sync();
    output.put_in_place();
}

}  // namespace

std::vector<std::filesystem::path> results_in(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::is_directory(path, error)) return {path};
    std::vector<std::filesystem::path> files = parts_in(path);
    if (files.empty()) {
        throw InputError("'" + path.string() + "' holds no results: there is no file *" + kEnding + " in it");
    }
    return files;
}

std::vector<std::filesystem::path> results_in(const std::vector<std::string>& paths) {
    std::vector<std::filesystem::path> files;
    for (const std::string& path : paths) {
        const std::vector<std::filesystem::path> found = results_in(std::filesystem::path(path));
        files.insert(files.end(), found.begin(), found.end());
    }
    return files;
}

std::int64_t points_in(const std::filesystem::path& file) {
    try {
        SQLite::Database part(uri_to_read(file), SQLite::OPEN_READONLY | SQLite::OPEN_URI,
                              kBusyTimeoutMilliseconds);
        check_holds_results(part, file);
        return part.execAndGet("SELECT count(*) FROM points").getInt64();
    } catch (const SQLite::Exception& error) {
        fail_to_read(file, error);
    }
}

std::optional<MissingPoints> missing_in(const std::filesystem::path& folder, const ResultsIdentity& identity,
                                        const std::string& digest, std::int64_t shards) {
    const std::vector<std::filesystem::path> files = parts_in(folder);
    if (files.empty()) return std::nullopt;
    try {
        SQLite::Database database("", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLite::OPEN_URI);
        ResultsMerger merger(database, false);
        for (const std::filesystem::path& file : files) {
            check_belongs(file, identity);
            merger.add(file);
        }
        return merger.missing(digest, shards);
    } catch (const SQLite::Exception& error) {
        fail_to_read(folder, error);
    }
}

PartsFolder::PartsFolder(std::filesystem::path folder, const ResultsIdentity& identity, ShardRecord shard,
                         std::chrono::seconds interval)
    : folder_(std::move(folder)),
      identity_(identity),
      shard_(std::move(shard)),
      interval_(interval),
      file_(scratch_.path() / "shard.db") {
    const std::vector<std::filesystem::path> files = parts_in(folder_);
    if (!files.empty()) {
        try {
            SQLite::Database database(uri_of(file_),
                                      SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLite::OPEN_URI);
            ResultsMerger merger(database, false);
            for (const std::filesystem::path& file : files) {
                check_belongs(file, identity_);
                if (!holds_only_other_shards(file)) merger.add(file);
            }
            // These are run again and handed in as something new.
            merger.remove_retried();
            // What is handed in reports the progress of this shard alone.
            if (merger.points() > 0) database.exec("DELETE FROM shards");
        } catch (const SQLite::Exception& error) {
            fail_to_write(file_, text::one_line(error.what()));
        }
    }
    results_.emplace(ResultsDatabase::open(file_, identity_));
    handed_in_ = last_rows();
}

/// Whether the file is only of other shards of the same cut, so that none of its points can be this shard's.
bool PartsFolder::holds_only_other_shards(const std::filesystem::path& file) const {
    const SQLite::Database part(uri_to_read(file), SQLite::OPEN_READONLY | SQLite::OPEN_URI);
    SQLite::Statement shards(part, "SELECT digest, shards, shard FROM shards");
    while (shards.executeStep()) {
        if (shards.getColumn(0).getString() != shard_.digest ||
            shards.getColumn(1).getInt64() != shard_.shard.count ||
            shards.getColumn(2).getInt64() == shard_.shard.index + 1) {
            return false;
        }
    }
    return true;
}

PartsFolder::Limits PartsFolder::last_rows() const {
    try {
        const SQLite::Database database(file_.string(), SQLite::OPEN_READONLY, kBusyTimeoutMilliseconds);
        SQLite::Statement last(database,
                               "SELECT coalesce((SELECT max(id) FROM runs), 0), "
                               "coalesce((SELECT max(id) FROM points), 0)");
        last.executeStep();
        return {last.getColumn(0).getInt64(), last.getColumn(1).getInt64()};
    } catch (const SQLite::Exception& error) {
        fail_to_read(file_, error);
    }
}

/// A name that no other process uses, on any computer and in any container.
std::string PartsFolder::name_of_part() const {
    std::random_device random;
    return fmt::format("part-{}-of-{}-{}-{:08x}{:08x}{}", shard_.shard.index + 1, shard_.shard.count,
                       host_name(), random(), random(), kEnding);
}

void PartsFolder::hand_in(std::int64_t ended) {
    last_time_ = std::chrono::steady_clock::now();
    shard_.ended = ended;
    results_->put_shard(shard_);
    const std::filesystem::path aside = scratch_.path() / "new.db";
    std::error_code ignored;
    std::filesystem::remove(aside, ignored);  // left by a try that failed
    const Limits now = last_rows();
    try {
        SQLite::Database database(uri_of(aside),
                                  SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLite::OPEN_URI);
        database.exec("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF");
        ResultsMerger merger(database, true);
        merger.add_later(file_, handed_in_.run, handed_in_.point);
    } catch (const SQLite::Exception& error) {
        fail_to_write(aside, text::one_line(error.what()));
    }
    copy_into_place(aside, folder_ / name_of_part());
    std::filesystem::remove(aside, ignored);
    handed_in_ = now;
}

void PartsFolder::hand_in_if_due(std::int64_t ended) {
    if (std::chrono::steady_clock::now() - last_time_ < interval_) return;
    last_time_ = std::chrono::steady_clock::now();
    const Limits now = last_rows();
    if (now.run > handed_in_.run || now.point > handed_in_.point) hand_in(ended);
}

}  // namespace metabuffer::exploration
