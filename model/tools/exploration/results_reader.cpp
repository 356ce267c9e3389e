#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <system_error>
#include <utility>

#include "host/errors.h"
#include "host/text.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/results_database.h"
#include "tools/exploration/results_file.h"
#include "tools/exploration/results_merger.h"
#include "tools/exploration/sqlite_value.h"

namespace metabuffer::exploration {

namespace {

/// The most bytes of a report when unpacked.
constexpr std::size_t kLongestReportBytes = std::size_t{1} << 30U;

/// Whether there are changes that are not in the database file yet.
bool has_pending_changes(const std::filesystem::path& file) {
    std::filesystem::path changes = file;
    changes += "-wal";
    std::error_code error;
    const auto size = std::filesystem::file_size(changes, error);
    return !error && size > 0;
}

/// Opens a file that nobody writes to, without locks and without writing anything.
SQLite::Database open_at_rest(const std::filesystem::path& file) {
    try {
        SQLite::Database database(uri_of(file) + "?immutable=1", SQLite::OPEN_READONLY | SQLite::OPEN_URI);
        check_holds_results(database, file);
        return database;
    } catch (const SQLite::Exception& error) {
        fail_to_read(file, error);
    }
}

/// Opens a file to read. SQLite reads one that is still in WAL mode through shared memory in the file's folder. If that
/// cannot be made, the file alone is read, unless its journal holds changes.
SQLite::Database open_to_read(const std::filesystem::path& file) {
    const auto opened = [&file](int busy_timeout_milliseconds) {
        SQLite::Database database(file.string(), SQLite::OPEN_READONLY, busy_timeout_milliseconds);
        check_holds_results(database, file);
        return database;
    };
    try {
        return opened(0);
    } catch (const SQLite::Exception& error) {
        if (is_without_locks(file, error)) {
            if (has_pending_changes(file)) fail_without_locks(file);
            return open_at_rest(file);
        }
    }
    try {
        return opened(kBusyTimeoutMilliseconds);
    } catch (const SQLite::Exception& error) {
        const bool is_folder_at_fault =
            error.getErrorCode() == SQLITE_CANTOPEN || error.getErrorCode() == SQLITE_READONLY;
        if (!is_folder_at_fault) fail_to_read(file, error);
        if (has_pending_changes(file)) {
            throw InputError("'" + file.string() + "' was not finished, and reading '" + file.string() +
                             "-wal' takes a folder that can be written to; copy both into one");
        }
    }
    return open_at_rest(file);
}

std::string inflated(const std::filesystem::path& file, const SQLite::Column& column) {
    const auto* const bytes = static_cast<const Bytef*>(column.getBlob());
    z_stream stream{};
    // zlib's interface knows no const.
    stream.next_in = const_cast<Bytef*>(bytes);
    stream.avail_in = static_cast<uInt>(column.getBytes());
    std::string text;
    int result = inflateInit(&stream);
    while (result == Z_OK) {
        std::array<char, 65536> part{};
        stream.next_out = reinterpret_cast<Bytef*>(part.data());
        stream.avail_out = static_cast<uInt>(part.size());
        result = inflate(&stream, Z_NO_FLUSH);
        text.append(part.data(), part.size() - stream.avail_out);
        if (text.size() > kLongestReportBytes) break;
    }
    inflateEnd(&stream);
    if (result != Z_STREAM_END)
        throw InputError("'" + file.string() + "' is damaged: a report cannot be read");
    return text;
}

std::vector<std::string> quoted_names(const std::vector<std::string>& names) {
    std::vector<std::string> quoted;
    std::transform(names.begin(), names.end(), std::back_inserter(quoted), quoted_name);
    return quoted;
}

}  // namespace

struct ResultsReader::Content {
    Content(std::filesystem::path file_in, SQLite::Database database_in)
        : file(std::move(file_in)),
          database(std::move(database_in)),
          identity(read_identity(database)),
          columns(column_names(database, "results")),
          run_columns(column_names(database, "runs")) {
        run_columns.erase(std::remove(run_columns.begin(), run_columns.end(), "report"), run_columns.end());
    }

    void each_row(const std::string& sql, const TakeRow& take) const {
        try {
            SQLite::Statement statement(database, sql);
            std::vector<Value> row(static_cast<std::size_t>(statement.getColumnCount()));
            while (statement.executeStep()) {
                for (std::size_t n = 0; n < row.size(); ++n) {
                    row[n] = value_of(statement.getColumn(static_cast<int>(n)));
                }
                take(row);
            }
        } catch (const SQLite::Exception& error) {
            fail_to_read(file, error);
        }
    }

    std::vector<std::vector<Value>> rows(const std::string& sql) const {
        std::vector<std::vector<Value>> result;
        each_row(sql, [&result](const std::vector<Value>& row) { result.push_back(row); });
        return result;
    }

    /// The SQL that selects the results' rows in their order; `selected` is SQL, too.
    std::string query(const std::vector<std::string>& selected, const std::string& condition) const {
        std::string sql = "SELECT " + text::listed(selected) + " FROM results";
        if (!condition.empty()) {
            sql += " WHERE " + sql_expression(condition, columns, "");
        }
        std::vector<std::string> order = quoted_names(axis_columns(identity.keys));
        order.emplace_back("point");
        return sql + " ORDER BY " + text::listed(order);
    }

    std::vector<std::string> sql_of(const std::vector<std::string>& expressions) const {
        std::vector<std::string> selected(expressions.size());
        std::transform(
            expressions.begin(), expressions.end(), selected.begin(),
            [this](const std::string& text) { return "(" + sql_expression(text, columns, "") + ")"; });
        return selected;
    }

    std::filesystem::path file;
    SQLite::Database database;
    ResultsIdentity identity;
    std::vector<std::string> columns;
    std::vector<std::string> run_columns;
};

ResultsReader::ResultsReader(const std::filesystem::path& file) {
    check_is_file(file);
    std::error_code error;
    if (!std::filesystem::exists(file, error)) {
        throw InputError("'" + file.string() + "' cannot be read: there is no such file");
    }
    try {
        content_ = std::make_unique<Content>(file, open_to_read(file));
    } catch (const SQLite::Exception& exception) {
        fail_to_read(file, exception);
    }
}
namespace {

/// The merged results, in a temporary file that SQLite removes with the database.
SQLite::Database merged(const std::vector<std::filesystem::path>& files) {
    SQLite::Database database("", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLite::OPEN_URI);
    ResultsMerger merger(database, false);
    for (const std::filesystem::path& file : files) merger.add(file);
    return database;
}

}  // namespace

ResultsReader::ResultsReader(const std::vector<std::filesystem::path>& files) {
    if (files.empty()) throw InputError("there is no file of results; name one");
    if (files.size() == 1) {
        *this = ResultsReader(files.front());
        return;
    }
    try {
        content_ = std::make_unique<Content>(files.front(), merged(files));
    } catch (const SQLite::Exception& exception) {
        fail_to_read(files.front(), exception);
    }
}
ResultsReader::ResultsReader(ResultsReader&&) noexcept = default;
ResultsReader& ResultsReader::operator=(ResultsReader&&) noexcept = default;
ResultsReader::~ResultsReader() = default;

const ResultsIdentity& ResultsReader::identity() const { return content_->identity; }

const std::vector<std::string>& ResultsReader::columns() const { return content_->columns; }

std::vector<std::string> ResultsReader::lasting_columns() const {
    std::vector<std::string> lasting;
    std::copy_if(content_->columns.begin(), content_->columns.end(), std::back_inserter(lasting),
                 [](const std::string& column) {
                     return std::find(kPassingColumns.begin(), kPassingColumns.end(), column) ==
                            kPassingColumns.end();
                 });
    return lasting;
}

ResultsReader::Table ResultsReader::results(const std::string& condition) const {
    return {content_->columns, content_->rows(content_->query(quoted_names(content_->columns), condition))};
}

std::int64_t ResultsReader::count(const std::string& condition) const {
    std::string sql = "SELECT count(*) FROM results";
    if (!condition.empty()) sql += " WHERE " + sql_expression(condition, content_->columns, "");
    return std::get<std::int64_t>(content_->rows(sql).front().front());
}

ResultsReader::Table ResultsReader::results(const std::vector<std::string>& expressions,
                                            const std::string& condition) const {
    return {expressions, content_->rows(content_->query(content_->sql_of(expressions), condition))};
}

void ResultsReader::each_result(const std::vector<std::string>& expressions, const std::string& condition,
                                const TakeRow& take) const {
    content_->each_row(content_->query(content_->sql_of(expressions), condition), take);
}

ResultsReader::Table ResultsReader::runs() const {
    return {content_->run_columns,
            content_->rows("SELECT " + text::listed(quoted_names(content_->run_columns)) +
                           " FROM runs ORDER BY id")};
}

std::string ResultsReader::report(std::int64_t run) const {
    try {
        SQLite::Statement statement(content_->database, "SELECT report FROM runs WHERE id = ?");
        statement.bind(1, run);
        if (!statement.executeStep() || statement.getColumn(0).isNull()) return {};
        return inflated(content_->file, statement.getColumn(0));
    } catch (const SQLite::Exception& error) {
        fail_to_read(content_->file, error);
    }
}

std::vector<std::pair<int, std::string>> ResultsReader::pictures(std::int64_t run) const {
    try {
        std::vector<std::pair<int, std::string>> result;
        SQLite::Statement statement(content_->database,
                                    "SELECT display, png FROM pictures WHERE run = ? ORDER BY display");
        statement.bind(1, run);
        while (statement.executeStep()) {
            result.emplace_back(statement.getColumn(0).getInt(), statement.getColumn(1).getString());
        }
        return result;
    } catch (const SQLite::Exception& error) {
        fail_to_read(content_->file, error);
    }
}

}  // namespace metabuffer::exploration
