#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/exploration/sweep_plan.h"
#include "tools/exploration/value.h"

namespace metabuffer::exploration {

/// How a run, or a point, ended.
enum class RunStatus : std::uint8_t {
    kDone,      ///< it came to its end, whatever starved
    kInvalid,   ///< its settings make no valid scenario
    kWatchdog,  ///< nothing moved any more
    kFailed,    ///< the model or the program was at fault
    kCrashed,   ///< its process ended without a report
    kUnmet,     ///< a search only: no value meets the goal
};
/// "done", "invalid", "watchdog", "failed", "crashed", "unmet".
const char* to_string(RunStatus status);
RunStatus run_status_of(const std::string& text);
/// Whether a run would end in the same way again. One that crashed may have been killed from outside, say for lack of
/// memory. One that was invalid may have lacked a file that exists now.
bool is_final(RunStatus status);

/// One simulation.
struct RunRecord {
    std::vector<Setting> settings;  ///< of the point; in a search also that of the key searched
    RunStatus status = RunStatus::kDone;
    std::string reason;          ///< one line; empty if done
    std::vector<Value> figures;  ///< in the order of figure_kinds(); empty without a report
    std::string report;          ///< report.json's text; empty if there is none
    double wall_seconds = 0.0;   ///< from its start to its end, start of the process included
    std::vector<std::pair<int, std::string>> pictures;  ///< display from 1, and a PNG file's bytes
};

/// One point of the plan and its outcome.
struct PointRecord {
    std::vector<Setting> settings;
    RunStatus status = RunStatus::kDone;
    std::string reason;
    /// The id of the run that shows the outcome: the point's own. In a search that of the smallest value; if there is
    /// none, that of the run that failed, else that of the largest value tried.
    std::optional<std::int64_t> run;
    std::optional<double> smallest;  ///< of a search: the smallest value that meets the goal
    std::optional<bool> monotonic;   ///< of a search: whether every value tried agrees with that
    std::string note;                ///< of a search: which values do not agree
    int runs = 1;                    ///< simulations that it took
    /// Of that run, in the order of figure_kinds(); empty without a report. A file has them with its runs.
    std::vector<Value> figures{};
    std::string bounds;  ///< of a search: which values were not tried, and why; a file does not have it
};

/// The level that simulates by default. Results that name no level were made by it.
inline constexpr const char* kUsualLevel = "tlm";

/// What the results in a file were made from: two sweeps may share a file if all that is compared is equal.
struct ResultsIdentity {
    std::string name;         ///< a title; not compared
    std::string fingerprint;  ///< of the settings that all points share
    /// The files that points are made from, each with its size and checksum. Points that need further files may be
    /// added. A file that both know must be the same.
    std::map<std::string, std::string> inputs;
    std::vector<std::string> keys;  ///< of the axes
    std::string search_key;         ///< empty: no search
    std::string goal;               ///< of the search
    // How a point is run by hand; not compared, since paths differ if they are given from another folder.
    std::string scenario;             ///< the file; empty if an axis names the scenarios
    std::string base;                 ///< the folder that the axis' paths are relative to
    std::vector<Setting> fixed;       ///< settings that all points share
    std::string level = kUsualLevel;  ///< that simulates; compared
};

/// What one shard's results say of their sweep.
struct ShardRecord {
    std::string digest;  ///< that of SweepPlan
    Shard shard;
    std::int64_t points = 0;  ///< all that the shard has
    std::int64_t ended = 0;   ///< those of them that have ended
};

/// The results of a sweep in one SQLite file. The schema, which reports and charts read:
///
/// meta(key, value)        schema_version, program_version, name, fingerprint, search_key, goal, ...
/// axes(position, key)     the keys of the settings
/// inputs(file, content)   what the points were made from
/// shards(digest, shard, shards, points, ended)   for each part that a sweep was cut into, from 1: its points and those
///                         that have ended. digest: that of SweepPlan; a sweep that is not cut is shard 1 of 1
/// runs(id, settings, status, reason, <a column for each of figure_kinds()>, wall_seconds, report)
///                         report: report.json, deflated by zlib; NULL if there is none
/// points(id, settings, status, reason, run, smallest, monotonic, runs, note)
/// point_settings(point, position, key, value)   values that are numbers are numbers
/// pictures(run, display, png)
/// view results            a row for each point: point, its settings by key, status, reason, smallest, monotonic,
///                         runs, note, run, and its run's figures and wall_seconds
///
/// `settings` is canonical_text(), and a row with the same settings as one that is there replaces it. An axis with a
/// key that is also the name of a figure or of a fixed column, "renderers" say, has the column "axis.renderers". Once
/// the call that adds a row has returned, the row survives even kill -9. docs/results.md has the columns' meanings.
///
/// While it is open, FILE-wal and FILE-shm are parts of it, and FILE.lock says which process adds to it. After that
/// only FILE is left. A forked child must end by _exit().
class ResultsDatabase {
  public:
    /// Opens a file to add to it; makes the file, but not its folder, if it does not exist. Throws InputError if that
    /// fails, if the file is something else, if another process adds to it, or if it holds results of other input than
    /// `identity`.
    static ResultsDatabase open(const std::filesystem::path& file, const ResultsIdentity& identity);
    ResultsDatabase(ResultsDatabase&&) noexcept;
    ResultsDatabase& operator=(ResultsDatabase&&) noexcept;
    ~ResultsDatabase();

    std::optional<PointRecord> find_point(const std::vector<Setting>& settings) const;
    /// Its id and the run, without report and pictures.
    std::optional<std::pair<std::int64_t, RunRecord>> find_run(const std::vector<Setting>& settings) const;
    /// The run's id. Throws OutputError.
    std::int64_t add_run(const RunRecord& run);
    /// Adds the point with its settings. Throws OutputError.
    void add_point(const PointRecord& point);
    /// For a point that is one run: adds both in one transaction.
    void add_point(PointRecord point, const RunRecord& run);
    /// Replaces what was known of the same shard, but points that have ended stay so. Throws OutputError.
    void put_shard(const ShardRecord& shard);

  private:
    struct Content;
    explicit ResultsDatabase(std::unique_ptr<Content> content);
    std::unique_ptr<Content> content_;
};

/// Reads a results file, also while a sweep adds to it or after one was killed. Each call sees what was there when it
/// began.
class ResultsReader {
  public:
    /// Throws InputError if the file does not exist or is something else. All calls throw it if the file is damaged.
    explicit ResultsReader(const std::filesystem::path& file);
    /// Reads several files of one sweep as merge_results() would merge them, without reports and pictures.
    explicit ResultsReader(const std::vector<std::filesystem::path>& files);
    ResultsReader(ResultsReader&&) noexcept;
    ResultsReader& operator=(ResultsReader&&) noexcept;
    ~ResultsReader();

    struct Table {
        std::vector<std::string> columns;
        std::vector<std::vector<Value>> rows;
    };

    const ResultsIdentity& identity() const;
    /// The columns of view results.
    const std::vector<std::string>& columns() const;
    /// Those of them that are the same whenever and wherever the sweep runs.
    std::vector<std::string> lasting_columns() const;
    /// The rows of view results for which `condition` holds: an expression over the columns, names written plainly;
    /// empty: all rows. They are in the order of the axes' values, the last axis changing fastest, whichever ended
    /// first. Throws InputError with what is wrong with the condition.
    Table results(const std::string& condition = {}) const;
    /// The number of these rows.
    std::int64_t count(const std::string& condition = {}) const;
    /// The same rows with `expressions` over the columns instead of all columns.
    Table results(const std::vector<std::string>& expressions, const std::string& condition) const;
    /// The same, row by row.
    using TakeRow = std::function<void(const std::vector<Value>&)>;
    void each_result(const std::vector<std::string>& expressions, const std::string& condition,
                     const TakeRow& take) const;
    /// Every simulation: settings as text, status, reason, figures, wall_seconds.
    Table runs() const;
    /// report.json's text of a run, empty if there is none.
    std::string report(std::int64_t run) const;
    /// PNG files of a run by display.
    std::vector<std::pair<int, std::string>> pictures(std::int64_t run) const;

  private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace metabuffer::exploration
