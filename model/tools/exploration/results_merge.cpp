#include "tools/exploration/results_merge.h"

#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>
#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <system_error>
#include <utility>

#include "host/errors.h"
#include "host/output_file.h"
#include "host/text.h"
#include "host/writer_lock.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/results_file.h"
#include "tools/exploration/results_merger.h"

namespace metabuffer::exploration {
namespace {

/// "a = excluded.a, b = excluded.b".
std::string taken_over(const std::vector<std::string>& columns) {
    std::vector<std::string> updates(columns.size());
    std::transform(columns.begin(), columns.end(), updates.begin(),
                   [](const std::string& column) { return column + " = excluded." + column; });
    return text::listed(updates);
}

/// SQL that adds what `rows` selects to a table of the target. The same settings appear once. A row that is to be run
/// again is replaced by one that is not, and a run without a report by one with a report.
std::string insert_better(const std::string& table, const std::vector<std::string>& columns,
                          const std::string& rows) {
    return "INSERT INTO main." + table + " (" + text::listed(columns) + ") " + rows +
           " ON CONFLICT (settings) DO UPDATE SET " + taken_over(columns) + " WHERE main." + table +
           ".status IN (" + retried_statuses() + ") AND excluded.status NOT IN (" + retried_statuses() + ")" +
           (table == "runs" ? " OR (main.runs.report IS NULL AND excluded.report IS NOT NULL)" : "");
}

/// A part that is attached while this lives.
class Attached {
  public:
    Attached(SQLite::Database& database, const std::filesystem::path& part, bool is_locked)
        : database_(database) {
        SQLite::Statement attach(database, "ATTACH ? AS part");
        attach.bind(1, uri_to_read(part, is_locked));
        attach.exec();
    }
    Attached(const Attached&) = delete;
    Attached& operator=(const Attached&) = delete;
    ~Attached() { database_.tryExec("DETACH part"); }

  private:
    SQLite::Database& database_;
};

std::int64_t number(SQLite::Database& database, const std::string& sql) {
    return database.execAndGet(sql).getInt64();
}

}  // namespace

ResultsMerger::ResultsMerger(SQLite::Database& target, bool with_reports)
    : target_(target), with_reports_(with_reports) {
    // A longer value could not be read again.
    sqlite3_limit(target_.getHandle(), SQLITE_LIMIT_LENGTH, kLongestValueBytes);
    // For each shard, the points that its own files hold.
    target_.exec(
        "CREATE TEMP TABLE counted (digest TEXT, shard INTEGER, shards INTEGER, point INTEGER, "
        "PRIMARY KEY (digest, shards, shard, point)) WITHOUT ROWID");
}

void ResultsMerger::check_belongs(const std::filesystem::path& part, const ResultsIdentity& identity) {
    const std::string difference = difference_between(identity, identity_);
    if (difference.empty()) return;
    throw InputError("'" + part.string() + "' holds results " + difference + " in '" + first_.string() +
                     "'; merge files of one sweep that one build has run");
}

void ResultsMerger::add(const std::filesystem::path& part, bool is_locked) {
    add_later(part, 0, 0, is_locked);
}

/// Throws InputError for a part with other columns: SQLite would take the name of a missing column for a text.
void ResultsMerger::check_columns(const std::filesystem::path& part) const {
    std::vector<std::string> expected = run_columns();
    expected.insert(expected.begin(), "id");
    std::vector<std::string> found;
    SQLite::Statement columns(target_, "SELECT name FROM pragma_table_info('runs', 'part') ORDER BY cid");
    while (columns.executeStep()) found.push_back(columns.getColumn(0).getString());
    if (found == expected) return;
    throw InputError(
        "'" + part.string() +
        "' holds results with other figures than this program's (another version wrote them); merge them "
        "with that version");
}

void ResultsMerger::add_later(const std::filesystem::path& part, std::int64_t last_run,
                              std::int64_t last_point, bool is_locked) {
    const ResultsIdentity identity = identity_of(part);
    try {
        if (is_empty_) {
            create_schema(target_, identity);
            identity_ = identity;
            first_ = part;
            is_empty_ = false;
        } else {
            check_belongs(part, identity);
            identity_.inputs.insert(identity.inputs.begin(), identity.inputs.end());
        }
        const Attached attached(target_, part, is_locked);
        check_columns(part);
        SQLite::Transaction transaction(target_, SQLite::TransactionBehavior::IMMEDIATE);
        add_inputs(target_, identity);
        add_rows(last_run, last_point);
        count_shards();
        transaction.commit();
    } catch (const SQLite::Exception& error) {
        // Parts are only read: what cannot be written is the target, or SQLite's own files next to it.
        if (error.getErrorCode() == SQLITE_FULL || error.getErrorCode() == SQLITE_IOERR) {
            fail_to_write(target_.getFilename(), text::one_line(error.what()));
        }
        fail_to_read(part, error);
    }
}

void ResultsMerger::add_rows(std::int64_t last_run, std::int64_t last_point) {
    std::vector<std::string> columns = run_columns();
    std::vector<std::string> values = columns;
    if (!with_reports_) values.back() = "NULL";
    for (std::vector<std::string>* const names : {&columns, &values}) {
        for (std::string& name : *names) {
            if (name != "NULL") name = quoted_name(name);
        }
    }
    target_.exec(insert_better("runs", columns,
                               "SELECT " + text::listed(values) + " FROM part.runs WHERE id > " +
                                   std::to_string(last_run) +
                                   " OR id IN (SELECT run FROM part.points WHERE id > " +
                                   std::to_string(last_point) + ") ORDER BY id"));
    if (with_reports_) {
        target_.exec(
            "INSERT OR IGNORE INTO main.pictures (run, display, png) SELECT t.id, p.display, p.png "
            "FROM part.pictures AS p JOIN part.runs AS s ON s.id = p.run "
            "JOIN main.runs AS t ON t.settings = s.settings");
    }
    const std::vector<std::string> point_names = point_columns();
    std::vector<std::string> point_values = point_names;
    std::replace(
        point_values.begin(), point_values.end(), std::string("run"),
        std::string("(SELECT t.id FROM part.runs AS r JOIN main.runs AS t ON t.settings = r.settings "
                    "WHERE r.id = run)"));
    target_.exec(insert_better("points", point_names,
                               "SELECT " + text::listed(point_values) + " FROM part.points WHERE id > " +
                                   std::to_string(last_point) + " ORDER BY id"));
    target_.exec(
        "INSERT OR IGNORE INTO main.point_settings (point, position, key, value) "
        "SELECT t.id, s.position, s.key, s.value FROM part.point_settings AS s "
        "JOIN part.points AS p ON p.id = s.point JOIN main.points AS t ON t.settings = p.settings");
}

/// The points in a file of a single shard are all that shard's, so they can be counted, however far its writer came.
/// For a file of several shards its own numbers count.
void ResultsMerger::count_shards() {
    const std::int64_t shards = number(target_, "SELECT count(*) FROM part.shards");
    target_.exec(
        "INSERT INTO main.shards (digest, shard, shards, points, ended) SELECT digest, shard, shards, "
        "points, " +
        std::string(shards == 1 ? "0" : "ended") +
        " FROM part.shards WHERE true "
        "ON CONFLICT (digest, shards, shard) DO UPDATE SET ended = max(ended, excluded.ended)");
    if (shards != 1) return;
    target_.exec(
        "INSERT OR IGNORE INTO temp.counted (digest, shard, shards, point) "
        "SELECT s.digest, s.shard, s.shards, t.id FROM part.shards AS s JOIN part.points AS p "
        "JOIN main.points AS t ON t.settings = p.settings");
}

std::int64_t ResultsMerger::points() const {
    return is_empty_ ? 0 : number(target_, "SELECT count(*) FROM points");
}

void ResultsMerger::remove_retried() {
    if (is_empty_) return;
    const std::string condition = " WHERE status IN (" + retried_statuses() + ")";
    target_.exec("DELETE FROM point_settings WHERE point IN (SELECT id FROM points" + condition + ")");
    target_.exec("DELETE FROM points" + condition);
    target_.exec("DELETE FROM pictures WHERE run IN (SELECT id FROM runs" + condition + ")");
    target_.exec("DELETE FROM runs" + condition);
}

ResultsMerger::Cuts ResultsMerger::missing_by_cut(bool with_retried) {
    target_.exec(
        "UPDATE main.shards AS s SET ended = max(ended, min(points, (SELECT count(*) FROM temp.counted AS c "
        "WHERE c.digest = s.digest AND c.shards = s.shards AND c.shard = s.shard)))");
    const std::string retried =
        "SELECT count(*) FROM temp.counted AS c JOIN points AS p ON p.id = c.point WHERE "
        "c.digest = s.digest AND c.shards = s.shards AND c.shard = s.shard AND p.status IN (" +
        retried_statuses() + ")";
    SQLite::Statement shards(target_, "SELECT digest, shards, shard, points, ended, (" + retried +
                                          ") FROM main.shards AS s ORDER BY digest, shards, shard");
    Cuts cuts;
    std::map<std::pair<std::string, std::int64_t>, std::int64_t> last_shards;
    while (shards.executeStep()) {
        const std::int64_t count = shards.getColumn(1).getInt64();
        const std::int64_t shard = shards.getColumn(2).getInt64();
        const std::int64_t points = shards.getColumn(3).getInt64();
        const std::int64_t ended = shards.getColumn(4).getInt64();
        if (shard < 1 || shard > count || count > kMostPoints || ended < 0 || ended > points ||
            points > kMostPoints) {
            throw InputError("'" + first_.string() + "' or a file next to it is damaged: shard " +
                             std::to_string(shard) + " of " + std::to_string(count) + " with " +
                             std::to_string(ended) + " of " + std::to_string(points) + " points");
        }
        const std::pair cut(shards.getColumn(0).getString(), count);
        MissingPoints& missing = cuts[cut];
        missing.shard_count = count;
        std::int64_t& last = last_shards[cut];
        while (++last < shard) missing.shards.push_back(last);
        const std::int64_t again = with_retried ? std::min(ended, shards.getColumn(5).getInt64()) : 0;
        missing.points_wanted += points;
        missing.points += points - ended + again;
        if (ended - again < points) missing.unfinished_shards.push_back(shard);
    }
    std::set<std::string> digests;
    for (auto& [cut, missing] : cuts) {
        digests.insert(cut.first);
        for (std::int64_t shard = last_shards[cut] + 1; shard <= cut.second; ++shard)
            missing.shards.push_back(shard);
    }
    std::string condition;
    if (with_retried) condition = " WHERE status NOT IN (" + retried_statuses() + ")";
    const std::int64_t there = number(target_, "SELECT count(*) FROM points" + condition);
    for (auto& [cut, missing] : cuts) {
        const std::int64_t lacking = std::max<std::int64_t>(missing.points_wanted - there, 0);
        // All points are this sweep's, and some may have been run by shards of another cut.
        const bool is_exact = digests.size() == 1 && missing.shards.empty();
        missing.points = is_exact ? lacking : std::max(missing.points, lacking);
        if (missing.complete()) missing.unfinished_shards.clear();
    }
    return cuts;
}

MissingPoints ResultsMerger::missing() {
    const Cuts cuts = missing_by_cut(false);
    if (cuts.empty()) return {};
    // Of each sweep the cut that is nearest to its end counts, and of these the one of the largest sweep.
    std::map<std::string, MissingPoints> sweeps;
    for (const auto& [cut, missing] : cuts) {
        const auto rank = [](const MissingPoints& of) { return std::pair(of.shards.size(), of.points); };
        const auto [sweep, is_new] = sweeps.try_emplace(cut.first, missing);
        if (!is_new && rank(missing) < rank(sweep->second)) sweep->second = missing;
    }
    const auto size = [](const auto& sweep) {
        const MissingPoints& missing = sweep.second;
        const auto present = missing.shard_count - static_cast<std::int64_t>(missing.shards.size());
        return static_cast<double>(missing.points_wanted) * static_cast<double>(missing.shard_count) /
               static_cast<double>(present);
    };
    return std::max_element(sweeps.begin(), sweeps.end(),
                            [&size](const auto& a, const auto& b) { return size(a) < size(b); })
        ->second;
}

MissingPoints ResultsMerger::missing(const std::string& digest, std::int64_t shards) {
    const Cuts cuts = missing_by_cut(true);
    // A sweep that was cut in another way is complete all the same.
    for (const auto& [cut, missing] : cuts) {
        if (cut.first == digest && missing.complete()) return missing;
    }
    const auto found = cuts.find({digest, shards});
    return found != cuts.end() ? found->second : all_missing(shards);
}

MissingPoints all_missing(std::int64_t shards) {
    MissingPoints all;
    all.shard_count = shards;
    all.shards.resize(static_cast<std::size_t>(shards));
    std::iota(all.shards.begin(), all.shards.end(), std::int64_t{1});
    return all;
}

Merge merge_results(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& target) {
    check_is_file(target);
    const WriterLock lock = lock_results(target);
    std::error_code error;
    const bool is_there = std::filesystem::exists(target, error);
    // A journal that stays would be taken for that of the new file.
    if (is_there) settle(target);
    OutputFile file(target);
    Merge merge;
    merge.files = parts.size();
    try {
        // No other process knows the file, and it may be where locks do not work.
        SQLite::Database database(uri_of(file.aside()) + "?vfs=unix-none",
                                  SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLite::OPEN_URI);
        database.exec("PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF");
        ResultsMerger merger(database, true);
        if (is_there) merger.add(target, true);
        const std::int64_t before = merger.points();
        for (const std::filesystem::path& part : parts) {
            if (!std::filesystem::equivalent(part, target, error)) merger.add(part);
        }
        merge.missing = merger.missing();
        merge.points = merger.points();
        merge.new_points = merge.points - before;
    } catch (const SQLite::Exception& error) {
        fail_to_write(target, text::one_line(error.what()));
    }
    file.sync();
    file.put_in_place();
    return merge;
}

}  // namespace metabuffer::exploration
