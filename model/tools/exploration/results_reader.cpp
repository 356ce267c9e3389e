#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <sqlite3.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <system_error>

#include "host/errors.h"
#include "host/text.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/results_database.h"
#include "tools/exploration/results_file.h"
#include "tools/exploration/sqlite_value.h"

namespace metabuffer::exploration {

namespace {

/// Unpacked.
constexpr std::size_t kLongestReportBytes = std::size_t{1} << 30U;

/// The file's name as SQLite's URIs have it.
std::string uri_of(const std::filesystem::path& file) {
    std::string result = "file:";
    for (const char character : file.string()) {
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

/// The file of changes that are not in the database file yet, if there are any.
bool has_pending_changes(const std::filesystem::path& file) {
    std::filesystem::path changes = file;
    changes += "-wal";
    std::error_code error;
    const auto size = std::filesystem::file_size(changes, error);
    return !error && size > 0;
}

/// Opens it to read. A file that was left with a journal of its own kind is read through shared memory in its folder;
/// where that cannot be made the file itself is all there is, unless changes wait.
SQLite::Database open_to_read(const std::filesystem::path& file) {
    try {
        SQLite::Database database(file.string(), SQLite::OPEN_READONLY, kBusyTimeoutMilliseconds);
        check_holds_results(database, file);
        return database;
    } catch (const SQLite::Exception& error) {
        const bool is_folder_at_fault =
            error.getErrorCode() == SQLITE_CANTOPEN || error.getErrorCode() == SQLITE_READONLY;
        if (!is_folder_at_fault) fail_to_read(file, error);
        if (has_pending_changes(file)) {
            throw InputError("'" + file.string() + "' was not finished, and reading '" + file.string() +
                             "-wal' takes a folder that can be written to; copy both into one");
        }
    }
    try {
        SQLite::Database database(uri_of(file) + "?immutable=1", SQLite::OPEN_READONLY | SQLite::OPEN_URI);
        check_holds_results(database, file);
        return database;
    } catch (const SQLite::Exception& error) {
        fail_to_read(file, error);
    }
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
    explicit Content(const std::filesystem::path& file_in)
        : file(file_in),
          database(open_to_read(file)),
          identity(read_identity(database)),
          columns(column_names(database, "results")),
          run_columns(column_names(database, "runs")) {
        run_columns.erase(std::remove(run_columns.begin(), run_columns.end(), "report"), run_columns.end());
    }

    std::vector<std::vector<Value>> rows(const std::string& sql) const {
        try {
            std::vector<std::vector<Value>> result;
            SQLite::Statement statement(database, sql);
            while (statement.executeStep()) {
                std::vector<Value>& row = result.emplace_back();
                for (int n = 0; n < statement.getColumnCount(); ++n) {
                    row.push_back(value_of(statement.getColumn(n)));
                }
            }
            return result;
        } catch (const SQLite::Exception& error) {
            fail_to_read(file, error);
        }
    }

    /// `selected` is SQL.
    std::vector<std::vector<Value>> results(const std::vector<std::string>& selected,
                                            const std::string& condition) const {
        std::string sql = "SELECT " + text::listed(selected) + " FROM results";
        if (!condition.empty()) {
            sql += " WHERE " + sql_expression(condition, columns, "");
        }
        std::vector<std::string> order = quoted_names(axis_columns(identity.keys));
        order.emplace_back("point");
        return rows(sql + " ORDER BY " + text::listed(order));
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
        content_ = std::make_unique<Content>(file);
    } catch (const SQLite::Exception& exception) {
        fail_to_read(file, exception);
    }
}
ResultsReader::ResultsReader(ResultsReader&&) noexcept = default;
ResultsReader& ResultsReader::operator=(ResultsReader&&) noexcept = default;
ResultsReader::~ResultsReader() = default;

const ResultsIdentity& ResultsReader::identity() const { return content_->identity; }

const std::vector<std::string>& ResultsReader::columns() const { return content_->columns; }

ResultsReader::Table ResultsReader::results(const std::string& condition) const {
    return {content_->columns, content_->results(quoted_names(content_->columns), condition)};
}

ResultsReader::Table ResultsReader::results(const std::vector<std::string>& expressions,
                                            const std::string& condition) const {
    std::vector<std::string> selected(expressions.size());
    std::transform(expressions.begin(), expressions.end(), selected.begin(), [this](const std::string& text) {
        return "(" + sql_expression(text, content_->columns, "") + ")";
    });
    return {expressions, content_->results(selected, condition)};
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
