#pragma once

#include <SQLiteCpp/Database.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/writer_lock.h"
#include "tools/exploration/results_database.h"

namespace SQLite {
class Exception;
}

/// What writer and reader of a results file share: its schema, and how to recognize such a file.
namespace metabuffer::exploration {

/// PRAGMA application_id: "MBUF".
constexpr int kResultsApplicationId = 0x4D425546;
/// The most bytes of a packed report, of a packed picture or of a text.
constexpr int kLongestValueBytes = 256 << 20;
/// Readers and writers delay each other for milliseconds only.
constexpr int kBusyTimeoutMilliseconds = 10'000;
/// PRAGMA user_version and meta's schema_version.
constexpr int kResultsSchemaVersion = 2;

/// How the results differ from those that are wanted, as "of another build (1.1 instead of 1.0)". Empty if they may
/// share a file.
std::string difference_between(const ResultsIdentity& held, const ResultsIdentity& wanted);

/// Ensures that this process alone adds to the results. Throws InputError if another does.
WriterLock lock_results(const std::filesystem::path& file);

/// The statuses with which a run is tried again, as a list in SQL.
std::string retried_statuses();

/// Columns of view results that depend on when and where a point ran.
inline constexpr std::array<const char*, 3> kPassingColumns{"point", "run", "wall_seconds"};

/// The columns of tables runs and points that are written, without their ids.
std::vector<std::string> run_columns();
std::vector<std::string> point_columns();

/// Moves the changes in a file's journal into the file. This process must have locked it. Throws InputError if another
/// process reads the file.
void settle(const std::filesystem::path& file);

/// The file's path, the same for every spelling, symbolic links included. SQLite never takes it for something else, as
/// it does ":memory:".
std::filesystem::path real_path(const std::filesystem::path& file);

/// The file's path as a URI for SQLite, without parameters.
std::string uri_of(const std::filesystem::path& file);
/// The same for a file that is attached and read. If no process has it open to write, SQLite uses no locks, since locks
/// do not work everywhere. is_locked: this process has locked the file and does not change it meanwhile.
std::string uri_to_read(const std::filesystem::path& file, bool is_locked = false);

/// What the results in a file were made from. Throws InputError if it holds none.
ResultsIdentity identity_of(const std::filesystem::path& file);

/// Throws InputError if the path exists but is not a regular file.
void check_is_file(const std::filesystem::path& file);

/// Whether nothing has ever been stored in it: a new file, or one whose writer ended before its first transaction.
bool is_empty_database(const SQLite::Database& database);

/// Throws InputError if the database holds something other than results that this program knows.
void check_holds_results(const SQLite::Database& database, const std::filesystem::path& file);

/// Makes tables, view, meta and axes in an empty database.
void create_schema(SQLite::Database& database, const ResultsIdentity& identity);

/// Adds those of the identity's inputs that the results do not have yet.
void add_inputs(SQLite::Database& database, const ResultsIdentity& identity);

ResultsIdentity read_identity(const SQLite::Database& database);

/// The columns of a table or view.
std::vector<std::string> column_names(const SQLite::Database& database, const std::string& table);

/// The columns of view results that hold the axes' settings, in their order.
std::vector<std::string> axis_columns(const std::vector<std::string>& keys);

/// Whether an error of a file comes from a file system that has no locks. Reading needs none if nobody writes.
bool is_without_locks(const std::filesystem::path& file, const SQLite::Exception& error);
/// Throws the InputError for a file there.
[[noreturn]] void fail_without_locks(const std::filesystem::path& file);

/// Throws the InputError for a file that cannot be opened or read.
[[noreturn]] void fail_to_read(const std::filesystem::path& file, const SQLite::Exception& error);

}  // namespace metabuffer::exploration
