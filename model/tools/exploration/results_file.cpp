#include "tools/exploration/results_file.h"

#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <system_error>

#include "build_info/build_info.h"
#include "host/errors.h"
#include "host/text.h"
#include "host/text_file.h"
#include "host/writer_lock.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/figures.h"

namespace metabuffer::exploration {

namespace {

/// The columns of view results other than those of axes and figures.
constexpr std::array<const char*, 9> kPointColumns{"point", "status", "reason", "smallest",    "monotonic",
                                                   "runs",  "note",   "run",    "wall_seconds"};

// Values have no declared type: numbers stay numbers, and texts stay texts.
constexpr const char* kTables = R"(
    CREATE TABLE meta (key TEXT PRIMARY KEY, value) WITHOUT ROWID;
    CREATE TABLE axes (position INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE);
    CREATE TABLE inputs (file TEXT PRIMARY KEY, content TEXT NOT NULL) WITHOUT ROWID;
    CREATE TABLE shards (digest TEXT NOT NULL, shard INTEGER NOT NULL, shards INTEGER NOT NULL,
                         points INTEGER NOT NULL, ended INTEGER NOT NULL,
                         PRIMARY KEY (digest, shards, shard)) WITHOUT ROWID;
    CREATE TABLE points (id INTEGER PRIMARY KEY, settings TEXT NOT NULL UNIQUE, status TEXT NOT NULL,
                         reason TEXT NOT NULL, run INTEGER REFERENCES runs (id), smallest, monotonic,
                         runs INTEGER NOT NULL, note TEXT NOT NULL);
    CREATE TABLE point_settings (point INTEGER NOT NULL REFERENCES points (id), position INTEGER NOT NULL,
                                 key TEXT NOT NULL, value, PRIMARY KEY (point, key)) WITHOUT ROWID;
    CREATE TABLE pictures (run INTEGER NOT NULL REFERENCES runs (id), display INTEGER NOT NULL,
                           png BLOB NOT NULL, PRIMARY KEY (run, display));
)";

std::vector<std::string> figure_names() {
    std::vector<std::string> names;
    for (const FigureKind& figure : figure_kinds()) names.emplace_back(figure.name);
    return names;
}

std::string runs_table(const std::vector<std::string>& figures) {
    std::string sql =
        "CREATE TABLE runs (id INTEGER PRIMARY KEY, settings TEXT NOT NULL UNIQUE, status TEXT NOT NULL, "
        "reason TEXT NOT NULL";
    for (const std::string& figure : figures) sql += ", " + quoted_name(figure);
    return sql + ", wall_seconds, report BLOB)";
}

std::string results_view(const std::vector<std::string>& keys, const std::vector<std::string>& figures) {
    const std::vector<std::string> columns = axis_columns(keys);
    std::string sql = "CREATE VIEW results AS SELECT p.id AS point";
    for (std::size_t n = 0; n < keys.size(); ++n) {
        sql += ", (SELECT s.value FROM point_settings AS s WHERE s.point = p.id AND s.key = " +
               text::literal(keys[n], '\'') + ") AS " + quoted_name(columns[n]);
    }
    sql +=
        ", p.status AS status, p.reason AS reason, p.smallest AS smallest, p.monotonic AS monotonic, "
        "p.runs AS runs, p.note AS note, p.run AS run";
    for (const std::string& figure : figures) {
        sql += ", r." + quoted_name(figure) + " AS " + quoted_name(figure);
    }
    return sql + ", r.wall_seconds AS wall_seconds FROM points AS p LEFT JOIN runs AS r ON r.id = p.run";
}

void make_tables(SQLite::Database& database, const std::vector<std::string>& keys,
                 const std::vector<std::string>& figures) {
    database.exec(kTables);
    database.exec(runs_table(figures));
    database.exec(results_view(keys, figures));
}

std::vector<std::string> keys_of_axes(const SQLite::Database& database) {
    std::vector<std::string> keys;
    SQLite::Statement axes(database, "SELECT key FROM axes ORDER BY position");
    while (axes.executeStep()) keys.push_back(axes.getColumn(0).getString());
    return keys;
}

/// The figures that the view shows: those of the program that wrote the file, which may differ from this one's.
std::vector<std::string> shown_figures(const SQLite::Database& database,
                                       const std::vector<std::string>& keys) {
    const std::vector<std::string> axes = axis_columns(keys);
    const auto is_other = [&axes](const std::string& name) {
        return std::find(axes.begin(), axes.end(), name) != axes.end() ||
               std::find(kPointColumns.begin(), kPointColumns.end(), name) != kPointColumns.end();
    };
    std::vector<std::string> figures = column_names(database, "results");
    figures.erase(std::remove_if(figures.begin(), figures.end(), is_other), figures.end());
    return figures;
}

[[noreturn]] void fail_as_damaged(const std::filesystem::path& file, const std::string& how) {
    throw InputError(text::one_line("'" + file.string() + "' is damaged: " + how));
}

/// Throws InputError if tables or view are not as this program makes them: a changed view or a trigger may give any
/// result, or never end. Columns may have been added to the table of runs, but none that are computed.
void check_tables(const SQLite::Database& database, const std::filesystem::path& file) {
    SQLite::Database made(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    const std::vector<std::string> keys = keys_of_axes(database);
    make_tables(made, keys, shown_figures(database, keys));
    SQLite::Statement expected(made, "SELECT type, name, tbl_name, coalesce(sql, '') FROM sqlite_master");
    while (expected.executeStep()) {
        const std::string name = expected.getColumn(1).getString();
        SQLite::Statement found(
            database, "SELECT sql FROM main.sqlite_master WHERE type = ? AND name = ? AND tbl_name = ?");
        for (int n = 0; n < 3; ++n) found.bind(n + 1, expected.getColumn(n).getString());
        if (found.executeStep() &&
            (name == "runs" || found.getColumn(0).getString() == expected.getColumn(3).getString())) {
            continue;
        }
        fail_as_damaged(file,
                        expected.getColumn(0).getString() + " " + name + " is not as metabuffer makes it");
    }
    SQLite::Statement computed(database, "SELECT name FROM pragma_table_xinfo('runs') WHERE hidden <> 0");
    if (computed.executeStep()) {
        fail_as_damaged(file, "column " + text::quoted(computed.getColumn(0).getString()) + " is computed");
    }
    SQLite::Statement triggers(database, "SELECT name FROM main.sqlite_master WHERE type = 'trigger'");
    if (triggers.executeStep()) {
        fail_as_damaged(file, "it has a trigger, " + text::quoted(triggers.getColumn(0).getString()) +
                                  ", and metabuffer makes none");
    }
}

std::int64_t pragma(const SQLite::Database& database, const std::string& name) {
    SQLite::Statement statement(database, "PRAGMA " + name);
    return statement.executeStep() ? statement.getColumn(0).getInt64() : 0;
}

std::string meta(const SQLite::Database& database, const std::string& key) {
    SQLite::Statement statement(database, "SELECT value FROM meta WHERE key = ?");
    statement.bind(1, key);
    return statement.executeStep() ? statement.getColumn(0).getString() : "";
}

}  // namespace

namespace {

std::string or_none(const std::string& text) {
    return text.empty() ? "none" : "'" + text::one_line(text) + "'";
}

/// A fingerprint begins with the build.
std::string build_of(const std::string& fingerprint) { return fingerprint.substr(0, fingerprint.find(';')); }

}  // namespace

std::string difference_between(const ResultsIdentity& held, const ResultsIdentity& wanted) {
    if (held.keys != wanted.keys) {
        return "over other axes (" + text::joined(held.keys, "and") + " instead of " +
               text::joined(wanted.keys, "and") + ")";
    }
    if (held.search_key != wanted.search_key) {
        return "of another search (of " + or_none(held.search_key) + " instead of " +
               or_none(wanted.search_key) + ")";
    }
    if (held.goal != wanted.goal) {
        return "of a search with another goal (" + or_none(held.goal) + " instead of " +
               or_none(wanted.goal) + ")";
    }
    if (held.level != wanted.level) return "of level " + held.level + " instead of level " + wanted.level;
    if (build_of(held.fingerprint) != build_of(wanted.fingerprint)) {
        return "of another build (" + text::one_line(build_of(held.fingerprint)) + " instead of " +
               text::one_line(build_of(wanted.fingerprint)) + ")";
    }
    if (held.fingerprint != wanted.fingerprint) {
        return "of other input (settings that all points share are not the same)";
    }
    for (const auto& [input, content] : wanted.inputs) {
        const auto known = held.inputs.find(input);
        if (known == held.inputs.end() || known->second == content) continue;
        return "of other input ('" + text::one_line(input) + "' is not the same)";
    }
    return "";
}

std::string uri_of(const std::filesystem::path& file) {
    std::string result = "file://";
    for (const char character : real_path(file).string()) {
        constexpr std::array<char, 17> kHexadecimal{"0123456789ABCDEF"};
        if (character == '%' || character == '?' || character == '#') {
            const auto code = static_cast<unsigned char>(character);
            result += {'%', kHexadecimal[code >> 4U], kHexadecimal[code & 0xFU]};
        } else {
            result += character;
        }
    }
    return result;
}

std::string uri_to_read(const std::filesystem::path& file, bool is_locked) {
    const auto has_beside = [real = real_path(file)](const char* ending) {
        std::filesystem::path beside = real;
        std::error_code error;
        return std::filesystem::exists(beside += ending, error);
    };
    const bool is_at_rest =
        !has_beside("-wal") && !has_beside("-journal") && (is_locked || !has_beside(".lock"));
    return uri_of(file) + "?mode=ro&vfs=unix" + (is_at_rest ? "&immutable=1" : "");
}

void settle(const std::filesystem::path& file) {
    std::filesystem::path changes = real_path(file);
    std::error_code error;
    if (!std::filesystem::exists(changes += "-wal", error)) return;
    try {
        SQLite::Database database(real_path(file).string(), SQLite::OPEN_READWRITE, kBusyTimeoutMilliseconds);
        check_holds_results(database, file);
        SQLite::Statement(database, "PRAGMA wal_checkpoint(TRUNCATE)").executeStep();
        SQLite::Statement mode(database, "PRAGMA journal_mode = DELETE");
        if (mode.executeStep() && mode.getColumn(0).getString() == "delete") return;
    } catch (const SQLite::Exception& exception) {
        fail_to_read(file, exception);
    }
    throw InputError("'" + file.string() +
                     "' is being read by another process; try again when that is through");
}

ResultsIdentity identity_of(const std::filesystem::path& file) {
    check_is_file(file);
    std::error_code error;
    if (!std::filesystem::exists(file, error)) {
        throw InputError("'" + file.string() + "' cannot be read: there is no such file");
    }
    try {
        const SQLite::Database database(uri_to_read(file), SQLite::OPEN_READONLY | SQLite::OPEN_URI,
                                        kBusyTimeoutMilliseconds);
        check_holds_results(database, file);
        return read_identity(database);
    } catch (const SQLite::Exception& exception) {
        fail_to_read(file, exception);
    }
}

void check_is_file(const std::filesystem::path& file) {
    if (input::is_no_regular_file(file)) {
        throw InputError("'" + file.string() + "' is no file; a file of results is needed");
    }
}

bool is_empty_database(const SQLite::Database& database) {
    SQLite::Statement statement(database, "SELECT count(*) FROM sqlite_master");
    statement.executeStep();
    return statement.getColumn(0).getInt() == 0 && pragma(database, "application_id") == 0 &&
           pragma(database, "user_version") == 0;
}

void check_holds_results(const SQLite::Database& database, const std::filesystem::path& file) {
    if (is_empty_database(database)) throw InputError("'" + file.string() + "' holds no results");
    if (pragma(database, "application_id") != kResultsApplicationId) {
        throw InputError("'" + file.string() +
                         "' is an SQLite file, but not one of results; name one that metabuffer sweep wrote");
    }
    const std::int64_t version = pragma(database, "user_version");
    if (version != kResultsSchemaVersion) {
        throw InputError("'" + file.string() + "' has schema version " + std::to_string(version) +
                         " (of metabuffer " + meta(database, "program_version") +
                         "); this program knows version " + std::to_string(kResultsSchemaVersion));
    }
    // SQLite refuses to read values that are longer than any run stores.
    sqlite3_limit(database.getHandle(), SQLITE_LIMIT_LENGTH, kLongestValueBytes);
    check_tables(database, file);
}

void add_inputs(SQLite::Database& database, const ResultsIdentity& identity) {
    SQLite::Statement insert(database, "INSERT OR IGNORE INTO inputs (file, content) VALUES (?, ?)");
    for (const auto& [file, content] : identity.inputs) {
        insert.bind(1, file);
        insert.bind(2, content);
        insert.exec();
        insert.reset();
    }
}

void create_schema(SQLite::Database& database, const ResultsIdentity& identity) {
    SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
    make_tables(database, identity.keys, figure_names());

    SQLite::Statement insert_meta(database, "INSERT INTO meta (key, value) VALUES (?, ?)");
    const auto add_meta = [&insert_meta](const std::string& key, const std::string& value) {
        insert_meta.bind(1, key);
        insert_meta.bind(2, value);
        insert_meta.exec();
        insert_meta.reset();
    };
    add_meta("schema_version", std::to_string(kResultsSchemaVersion));
    add_meta("program_version", build_version());
    add_meta("name", identity.name);
    add_meta("fingerprint", identity.fingerprint);
    add_meta("search_key", identity.search_key);
    add_meta("goal", identity.goal);
    add_meta("level", identity.level);
    add_meta("scenario", identity.scenario);
    add_meta("base", identity.base);
    add_meta("fixed", canonical_text(identity.fixed));

    SQLite::Statement insert_axis(database, "INSERT INTO axes (position, key) VALUES (?, ?)");
    for (std::size_t n = 0; n < identity.keys.size(); ++n) {
        insert_axis.bind(1, static_cast<std::int64_t>(n));
        insert_axis.bind(2, identity.keys[n]);
        insert_axis.exec();
        insert_axis.reset();
    }
    add_inputs(database, identity);
    database.exec("PRAGMA application_id = " + std::to_string(kResultsApplicationId));
    database.exec("PRAGMA user_version = " + std::to_string(kResultsSchemaVersion));
    transaction.commit();
}

ResultsIdentity read_identity(const SQLite::Database& database) {
    ResultsIdentity identity;
    identity.name = meta(database, "name");
    identity.fingerprint = meta(database, "fingerprint");
    identity.search_key = meta(database, "search_key");
    identity.goal = meta(database, "goal");
    if (const std::string level = meta(database, "level"); !level.empty()) identity.level = level;
    identity.scenario = meta(database, "scenario");
    identity.base = meta(database, "base");
    const auto fixed = nlohmann::ordered_json::parse(meta(database, "fixed"), nullptr, false);
    if (!fixed.is_object()) fail_as_damaged(database.getFilename(), "its settings, 'fixed', are no map");
    for (const auto& [key, value] : fixed.items()) {
        if (!value.is_string()) {
            fail_as_damaged(database.getFilename(), "the setting " + text::quoted(key) + " is no text");
        }
        identity.fixed.push_back({key, value.get<std::string>()});
    }
    SQLite::Statement inputs(database, "SELECT file, content FROM inputs");
    while (inputs.executeStep()) {
        identity.inputs[inputs.getColumn(0).getString()] = inputs.getColumn(1).getString();
    }
    identity.keys = keys_of_axes(database);
    return identity;
}

std::vector<std::string> column_names(const SQLite::Database& database, const std::string& table) {
    std::vector<std::string> names;
    SQLite::Statement columns(database, "SELECT name FROM pragma_table_info(?) ORDER BY cid");
    columns.bind(1, table);
    while (columns.executeStep()) names.push_back(columns.getColumn(0).getString());
    return names;
}

std::vector<std::string> axis_columns(const std::vector<std::string>& keys) {
    std::vector<std::string> columns;
    for (const std::string& key : keys) {
        const bool is_taken =
            figure_index(key).has_value() ||
            std::find(kPointColumns.begin(), kPointColumns.end(), key) != kPointColumns.end();
        columns.push_back(is_taken ? "axis." + key : key);
    }
    return columns;
}

bool is_without_locks(const std::filesystem::path& file, const SQLite::Exception& error) {
    const int code = error.getErrorCode();
    return (code == SQLITE_BUSY || code == SQLITE_IOERR) && lacks_locks(file);
}

void fail_without_locks(const std::filesystem::path& file) {
    throw InputError(
        "'" + file.string() +
        "' lies on a file system without locks; copy it to a local disk, or for a sweep name a file "
        "there, or a folder with --parts, which merge reads");
}

void fail_to_read(const std::filesystem::path& file, const SQLite::Exception& error) {
    const std::string name = "'" + file.string() + "'";
    if (is_without_locks(file, error)) fail_without_locks(file);
    switch (error.getErrorCode()) {
        case SQLITE_NOTADB:
            throw InputError(name + " is no file of results: it is no SQLite file");
        case SQLITE_CORRUPT:
            throw InputError(name + " is damaged: " + text::one_line(error.what()));
        case SQLITE_TOOBIG:
            throw InputError(name + " is damaged: a value has more than " +
                             std::to_string(kLongestValueBytes >> 20U) + " MiB");
        case SQLITE_BUSY:
            throw InputError(name + " is being read by another process; try again when that is through");
        default:
            throw InputError(name + " cannot be read: " + text::one_line(error.what()));
    }
}

}  // namespace metabuffer::exploration
