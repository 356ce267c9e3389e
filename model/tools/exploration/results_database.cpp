#include "tools/exploration/results_database.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>
#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <system_error>
#include <variant>

#include "host/errors.h"
#include "host/text.h"
#include "host/writer_lock.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/results_file.h"
#include "tools/exploration/sqlite_value.h"

namespace metabuffer::exploration {

namespace {

struct StatusName {
    RunStatus status;
    const char* name;
};
constexpr std::array<StatusName, 6> kStatusNames{{{RunStatus::kDone, "done"},
                                                  {RunStatus::kInvalid, "invalid"},
                                                  {RunStatus::kWatchdog, "watchdog"},
                                                  {RunStatus::kFailed, "failed"},
                                                  {RunStatus::kCrashed, "crashed"},
                                                  {RunStatus::kUnmet, "unmet"}}};

std::string deflated(const std::string& text) {
    // Reports are repetitive: higher levels take several times as long and save little.
    constexpr int kLevel = 1;
    // zlib clears several times its window for each text. So a short one gets a window that just holds it.
    int window_bits = 9;
    while (window_bits < MAX_WBITS && (std::size_t{1} << window_bits) < text.size()) ++window_bits;
    const int memory_level = window_bits - 7;  // zlib's own choice for its largest window

    const auto fail = [&text] {
        throw OutputError("a report of " + std::to_string(text.size()) + " bytes cannot be compressed");
    };
    z_stream stream{};
    if (deflateInit2(&stream, kLevel, Z_DEFLATED, window_bits, memory_level, Z_DEFAULT_STRATEGY) != Z_OK)
        fail();
    std::string result(deflateBound(&stream, static_cast<uLong>(text.size())), '\0');
    // zlib does not write to its input.
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(result.data());
    stream.avail_out = static_cast<uInt>(result.size());
    const int ending = deflate(&stream, Z_FINISH);
    result.resize(stream.total_out);
    deflateEnd(&stream);
    if (ending != Z_STREAM_END) fail();
    return result;
}

[[noreturn]] void fail_identity(const std::filesystem::path& file, const std::string& difference) {
    throw InputError("'" + file.string() + "' holds results " + difference +
                     "; name another file with -o, or remove it");
}

void check_identity(const std::filesystem::path& file, const ResultsIdentity& held,
                    const ResultsIdentity& wanted) {
    const std::string difference = difference_between(held, wanted);
    if (!difference.empty()) fail_identity(file, difference);
}

void check_columns(const std::filesystem::path& file, const SQLite::Database& database) {
    std::vector<std::string> expected = run_columns();
    expected.insert(expected.begin(), "id");
    if (column_names(database, "runs") != expected) {
        fail_identity(file, "with other figures than this program's (another version wrote them)");
    }
}

/// SQL that adds a row, or replaces the row with the same settings, and returns the id.
std::string upsert(const std::string& table, const std::vector<std::string>& columns) {
    const std::vector<std::string> parameters(columns.size(), "?");
    std::vector<std::string> updates(columns.size());
    std::transform(columns.begin(), columns.end(), updates.begin(),
                   [](const std::string& column) { return column + " = excluded." + column; });
    return "INSERT INTO " + table + " (" + text::listed(columns) + ") VALUES (" + text::listed(parameters) +
           ") ON CONFLICT (settings) DO UPDATE SET " + text::listed(updates) + " RETURNING id";
}

/// The statements that are made once and used for every point.
struct Statements {
    explicit Statements(const SQLite::Database& database)
        : upsert_run(database, upsert("runs", run_columns())),
          delete_pictures(database, "DELETE FROM pictures WHERE run = ?"),
          insert_picture(database, "INSERT INTO pictures (run, display, png) VALUES (?, ?, ?)"),
          upsert_point(database, upsert("points", point_columns())),
          delete_settings(database, "DELETE FROM point_settings WHERE point = ?"),
          insert_setting(database,
                         "INSERT INTO point_settings (point, position, key, value) VALUES (?, ?, ?, ?)"),
          find_point(database,
                     "SELECT status, reason, run, smallest, monotonic, runs, note FROM points WHERE settings "
                     "= ?"),
          find_run(database, "SELECT * FROM runs WHERE settings = ?"),
          put_shard(database,
                    "INSERT INTO shards (digest, shard, shards, points, ended) VALUES (?, ?, ?, ?, ?) "
                    "ON CONFLICT DO UPDATE SET points = excluded.points, "
                    "ended = min(excluded.points, max(ended, excluded.ended))") {}

    SQLite::Statement upsert_run;
    SQLite::Statement delete_pictures;
    SQLite::Statement insert_picture;
    SQLite::Statement upsert_point;
    SQLite::Statement delete_settings;
    SQLite::Statement insert_setting;
    SQLite::Statement find_point;
    SQLite::Statement find_run;
    SQLite::Statement put_shard;
};

template <typename Number>
void bind_optional(SQLite::Statement& statement, int parameter, const std::optional<Number>& number) {
    if (number) {
        statement.bind(parameter, static_cast<std::int64_t>(*number));
    } else {
        statement.bind(parameter);
    }
}

void bind_bytes(SQLite::Statement& statement, int parameter, const std::string& bytes) {
    statement.bindNoCopy(parameter, static_cast<const void*>(bytes.data()), static_cast<int>(bytes.size()));
}

/// A whole number if it is one, else as it is.
Value number_value(double number) {
    return number == std::floor(number) ? Value(static_cast<std::int64_t>(number)) : Value(number);
}

std::optional<std::int64_t> whole_of(const SQLite::Column& column) {
    if (column.isNull()) return std::nullopt;
    return column.getInt64();
}

constexpr std::array<RunStatus, 2> kRetriedStatuses{RunStatus::kCrashed, RunStatus::kInvalid};

}  // namespace

std::filesystem::path real_path(const std::filesystem::path& file) {
    std::error_code error;
    const std::filesystem::path real =
        std::filesystem::weakly_canonical(std::filesystem::absolute(file), error);
    return error ? std::filesystem::absolute(file) : real;
}

bool is_final(RunStatus status) {
    return std::find(kRetriedStatuses.begin(), kRetriedStatuses.end(), status) == kRetriedStatuses.end();
}

std::string retried_statuses() {
    std::vector<std::string> names;
    names.reserve(kRetriedStatuses.size());
    for (const RunStatus status : kRetriedStatuses) names.push_back(text::literal(to_string(status), '\''));
    return text::listed(names);
}

std::vector<std::string> run_columns() {
    std::vector<std::string> columns{"settings", "status", "reason"};
    for (const FigureKind& figure : figure_kinds()) columns.emplace_back(figure.name);
    columns.emplace_back("wall_seconds");
    columns.emplace_back("report");
    return columns;
}

std::vector<std::string> point_columns() {
    return {"settings", "status", "reason", "run", "smallest", "monotonic", "runs", "note"};
}

WriterLock lock_results(const std::filesystem::path& file) {
    // SQLite's own locks live on the database file, and closing any descriptor of that would drop them.
    return WriterLock(real_path(file) += ".lock", "'" + file.string() + "'",
                      "wait for it, or name another file with -o");
}

const char* to_string(RunStatus status) {
    for (const StatusName& entry : kStatusNames) {
        if (entry.status == status) return entry.name;
    }
    return "unknown";
}

RunStatus run_status_of(const std::string& text) {
    for (const StatusName& entry : kStatusNames) {
        if (text == entry.name) return entry.status;
    }
    throw InputError(text::quoted(text) +
                     " is no status; use done, invalid, watchdog, failed, crashed or unmet");
}

struct ResultsDatabase::Content {
    Content(const std::filesystem::path& file_in, const ResultsIdentity& identity)
        : file(file_in),
          lock(lock_results(file_in)),
          database(file_to_write().string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE,
                   kBusyTimeoutMilliseconds) {
        const bool is_new = is_empty_database(database);
        if (!is_new) {
            check_holds_results(database, file);
            check_identity(file, read_identity(database), identity);
            check_columns(file, database);
        }
        // What is committed survives if this process is killed. If the system fails, the last points may be lost.
        database.exec("PRAGMA synchronous = NORMAL");
        SQLite::Statement(database, "PRAGMA journal_mode = WAL").executeStep();
        if (is_new) {
            create_schema(database, identity);
        } else {
            SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
            add_inputs(database, identity);
            transaction.commit();
        }
        statements.emplace(database);
    }
    Content(const Content&) = delete;
    Content& operator=(const Content&) = delete;

    /// SQLite cannot write a file without its own locks, and makes a new one that only its owner may write to, whatever the
    /// umask is.
    std::filesystem::path file_to_write() const {
        if (!lock.is_held()) fail_without_locks(file);
        std::filesystem::path target = real_path(file);
        const int made = ::open(target.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (made >= 0) ::close(made);
        return target;
    }

    /// Leaves one plain file that can be read even where nothing can be written. While another process reads the file,
    /// it stays as it is, which is just as complete.
    ~Content() {
        statements.reset();
        try {
            database.setBusyTimeout(0);
            SQLite::Statement(database, "PRAGMA wal_checkpoint(TRUNCATE)").executeStep();
            SQLite::Statement(database, "PRAGMA journal_mode = DELETE").executeStep();
        } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch)
        }
    }

    /// Does an action that writes: all of it or nothing.
    template <typename Action>
    void write(const Action& action) {
        try {
            SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
            action();
            transaction.commit();
        } catch (const SQLite::Exception& error) {
            throw OutputError("cannot add to '" + file.string() + "': " + text::one_line(error.what()));
        }
    }

    std::int64_t put_run(const RunRecord& run) {
        SQLite::Statement& insert = statements->upsert_run;
        const StatementReset reset(insert);
        int parameter = 0;
        insert.bind(++parameter, canonical_text(run.settings));
        insert.bind(++parameter, std::string(to_string(run.status)));
        insert.bind(++parameter, run.reason);
        for (std::size_t n = 0; n < figure_kinds().size(); ++n) {
            bind_value(insert, ++parameter, run.figures.empty() ? Value() : run.figures.at(n));
        }
        insert.bind(++parameter, run.wall_seconds);
        const std::string report = run.report.empty() ? "" : deflated(run.report);
        if (report.empty()) {
            insert.bind(++parameter);
        } else {
            bind_bytes(insert, ++parameter, report);
        }
        insert.executeStep();
        const std::int64_t id = insert.getColumn(0).getInt64();
        put_pictures(id, run);
        return id;
    }

    void put_pictures(std::int64_t id, const RunRecord& run) {
        const StatementReset reset_delete(statements->delete_pictures);
        statements->delete_pictures.bind(1, id);
        statements->delete_pictures.exec();
        for (const auto& [display, png] : run.pictures) {
            const StatementReset reset(statements->insert_picture);
            statements->insert_picture.bind(1, id);
            statements->insert_picture.bind(2, display);
            bind_bytes(statements->insert_picture, 3, png);
            statements->insert_picture.exec();
        }
    }

    void put_point(const PointRecord& point) {
        SQLite::Statement& insert = statements->upsert_point;
        const StatementReset reset(insert);
        int parameter = 0;
        insert.bind(++parameter, canonical_text(point.settings));
        insert.bind(++parameter, std::string(to_string(point.status)));
        insert.bind(++parameter, point.reason);
        bind_optional(insert, ++parameter, point.run);
        bind_value(insert, ++parameter, point.smallest ? number_value(*point.smallest) : Value());
        bind_optional(insert, ++parameter, point.monotonic);
        insert.bind(++parameter, point.runs);
        insert.bind(++parameter, point.note);
        insert.executeStep();
        put_settings(insert.getColumn(0).getInt64(), point);
    }

    void put_settings(std::int64_t id, const PointRecord& point) {
        const StatementReset reset_delete(statements->delete_settings);
        statements->delete_settings.bind(1, id);
        statements->delete_settings.exec();
        std::int64_t position = 0;
        for (const Setting& setting : point.settings) {
            SQLite::Statement& insert = statements->insert_setting;
            const StatementReset reset(insert);
            insert.bind(1, id);
            insert.bind(2, position++);
            insert.bind(3, setting.key);
            bind_value(insert, 4, value_of_setting(setting.value));
            insert.exec();
        }
    }

    RunStatus status_of(const std::string& text) const {
        try {
            return run_status_of(text);
        } catch (const InputError& error) {
            throw InputError("'" + file.string() + "' is damaged: " + error.what());
        }
    }

    std::filesystem::path file;
    WriterLock lock;
    SQLite::Database database;
    std::optional<Statements> statements;
};

ResultsDatabase::ResultsDatabase(std::unique_ptr<Content> content) : content_(std::move(content)) {}
ResultsDatabase::ResultsDatabase(ResultsDatabase&&) noexcept = default;
ResultsDatabase& ResultsDatabase::operator=(ResultsDatabase&&) noexcept = default;
ResultsDatabase::~ResultsDatabase() = default;

ResultsDatabase ResultsDatabase::open(const std::filesystem::path& file, const ResultsIdentity& identity) {
    check_is_file(file);
    try {
        return ResultsDatabase(std::make_unique<Content>(file, identity));
    } catch (const SQLite::Exception& error) {
        fail_to_read(file, error);
    }
}

std::optional<PointRecord> ResultsDatabase::find_point(const std::vector<Setting>& settings) const {
    SQLite::Statement& find = content_->statements->find_point;
    const StatementReset reset(find);
    try {
        find.bind(1, canonical_text(settings));
        if (!find.executeStep()) return std::nullopt;
        PointRecord point;
        point.settings = settings;
        int column = 0;
        point.status = content_->status_of(find.getColumn(column++).getString());
        point.reason = find.getColumn(column++).getString();
        point.run = whole_of(find.getColumn(column++));
        const SQLite::Column smallest = find.getColumn(column++);
        if (!smallest.isNull()) point.smallest = smallest.getDouble();
        const std::optional<std::int64_t> monotonic = whole_of(find.getColumn(column++));
        if (monotonic) point.monotonic = *monotonic != 0;
        point.runs = find.getColumn(column++).getInt();
        point.note = find.getColumn(column++).getString();
        return point;
    } catch (const SQLite::Exception& error) {
        fail_to_read(content_->file, error);
    }
}

std::optional<std::pair<std::int64_t, RunRecord>> ResultsDatabase::find_run(
    const std::vector<Setting>& settings) const {
    SQLite::Statement& find = content_->statements->find_run;
    const StatementReset reset(find);
    try {
        find.bind(1, canonical_text(settings));
        if (!find.executeStep()) return std::nullopt;
        RunRecord run;
        run.settings = settings;
        int column = 0;
        const std::int64_t id = find.getColumn(column++).getInt64();
        ++column;  // settings
        run.status = content_->status_of(find.getColumn(column++).getString());
        run.reason = find.getColumn(column++).getString();
        for (std::size_t n = 0; n < figure_kinds().size(); ++n) {
            run.figures.push_back(value_of(find.getColumn(column++)));
        }
        const bool has_figures = std::any_of(run.figures.begin(), run.figures.end(), [](const Value& value) {
            return !std::holds_alternative<std::monostate>(value);
        });
        if (!has_figures) run.figures.clear();
        run.wall_seconds = find.getColumn(column++).getDouble();
        return std::pair(id, std::move(run));
    } catch (const SQLite::Exception& error) {
        fail_to_read(content_->file, error);
    }
}

std::int64_t ResultsDatabase::add_run(const RunRecord& run) {
    std::int64_t id = 0;
    content_->write([&] { id = content_->put_run(run); });
    return id;
}

void ResultsDatabase::put_shard(const ShardRecord& shard) {
    content_->write([&] {
        SQLite::Statement& insert = content_->statements->put_shard;
        const StatementReset reset(insert);
        int parameter = 0;
        insert.bind(++parameter, shard.digest);
        insert.bind(++parameter, shard.shard.index + 1);
        insert.bind(++parameter, shard.shard.count);
        insert.bind(++parameter, shard.points);
        insert.bind(++parameter, shard.ended);
        insert.exec();
    });
}

void ResultsDatabase::add_point(const PointRecord& point) {
    content_->write([&] { content_->put_point(point); });
}

void ResultsDatabase::add_point(PointRecord point, const RunRecord& run) {
    content_->write([&] {
        point.run = content_->put_run(run);
        content_->put_point(point);
    });
}

}  // namespace metabuffer::exploration
