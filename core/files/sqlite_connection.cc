#include "core/files/sqlite_connection.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <string_view>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr int kBusyTimeout_ms = 10000;
constexpr std::int64_t kLatest_us = 7258118400000000;  // 2200-01-01; a WallTime holds until 2262
constexpr std::string_view kRestore =
    "; the frames are untouched: restore this file from a copy, or recover its rows with 'sqlite3 "
    "session.db .recover'";

// The primary result code (sqlite.org/rescode.html).
int code_of(const SQLite::Exception& error) { return error.getErrorCode() & 0xFF; }

// A file name as an SQLite URI (sqlite.org/uri.html): '%', '?' and '#' escaped.
std::string uri_of(const fs::path& file, std::string_view query) {
  std::string uri = "file:";
  for (const char c : fs::absolute(file).string()) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02x}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  return uri.append("?").append(query);
}

// On a read-only file system SQLite can read a write-ahead log only if its index file exists;
// without the log the latest rows would silently be missing.
void require_no_log(const fs::path& file) {
  fs::path log = file;
  log += "-wal";
  std::error_code none;
  const auto log_bytes = fs::file_size(log, none);
  if (none || log_bytes == 0) return;
  throw Error(fmt::format(
      "{}: its latest entries are in {}, which cannot be read on a read-only disk; copy "
      "the directory to another disk first",
      file.string(), log.filename().string()));
}

SQLite::Database opened(const fs::path& file, SqliteAccess access) {
  std::error_code none;
  if (fs::exists(file, none)) require_regular_file(file);  // SQLite would wait for a named pipe
  if (access == SqliteAccess::kReadWrite) {
    // As a URI, which attach() needs.
    return {uri_of(file, "mode=rwc"),
            SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLITE_OPEN_URI, kBusyTimeout_ms};
  }
  try {
    SQLite::Database database(file.string(), SQLite::OPEN_READONLY, kBusyTimeout_ms);
    database.execAndGet("PRAGMA user_version");  // the first access to the log
    return database;
  } catch (const SQLite::Exception& error) {
    if (code_of(error) != SQLITE_CANTOPEN && code_of(error) != SQLITE_READONLY) throw;
  }
  require_no_log(file);
  return {uri_of(file, "immutable=1"), SQLite::OPEN_READONLY | SQLITE_OPEN_URI, kBusyTimeout_ms};
}

// What failed and what to do, for the codes with external causes.
std::string explanation(const SQLite::Exception& error) {
  const std::string words = one_line(error.what());
  switch (code_of(error)) {
    case SQLITE_FULL:
      return "the disk is full; free some space (everything captured so far is safe)";
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return "it cannot be written; check the permissions of the session's directory and files";
    case SQLITE_CORRUPT:
      return fmt::format("damaged ({}){}", words, kRestore);
    case SQLITE_NOTADB:
      return "not an SQLite database, or damaged; restore it from a copy (the frames are "
             "untouched)";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "another program has locked it; close that program first";
    case SQLITE_CANTOPEN:
      return "it cannot be opened; check that it exists and is readable";
    case SQLITE_IOERR:
      return "reading or writing failed (" + words + "); check the disk";
    default:
      return "it cannot be read as a session (" + words +
             "); it is damaged or of another program: restore it from a copy";
  }
}

}  // namespace

SqliteConnection::SqliteConnection(const fs::path& file, SqliteAccess access)
    : file_(file), database_(guarded([&] { return opened(file, access); })) {}

void SqliteConnection::fail(const SQLite::Exception& error) const {
  throw Error(file_.string() + ": " + explanation(error));
}

void SqliteConnection::execute(const std::string& sql) {
  guarded([&] { database_.exec(sql); });
}

void SqliteConnection::attach(const SqliteConnection& other, const std::string& name) {
  const bool is_immutable = other.database_.getFilename().starts_with("file:");
  const std::string uri = uri_of(other.file_, is_immutable ? "immutable=1" : "mode=ro");
  SqliteStatement(this, "ATTACH ?1 AS " + name).bind(uri).run();
}

std::int64_t SqliteConnection::integer(const std::string& sql) {
  return guarded([&] { return database_.execAndGet(sql).getInt64(); });
}

std::string SqliteConnection::text(const std::string& sql) {
  return guarded([&] { return database_.execAndGet(sql).getString(); });
}

void throw_damaged_database(const fs::path& file, std::string_view what) {
  throw Error(one_line(fmt::format("{}: damaged: {}{}", file.string(), what, kRestore)));
}

SqliteStatement::SqliteStatement(SqliteConnection* connection, const std::string& sql,
                                 std::string row)
    : connection_(connection),
      statement_(
          connection->guarded([&] { return SQLite::Statement(connection->database(), sql); })),
      row_(std::move(row)) {}

bool SqliteStatement::step() {
  return connection_->guarded([&] { return statement_.executeStep(); });
}

void SqliteStatement::fail(int column, const std::string& what) const {
  const std::string found =
      is_null(column) ? "NULL" : excerpt(statement_.getColumn(column).getString());
  throw_damaged_database(connection_->file(),
                         fmt::format("{} of {} is {}; it must be {}",
                                     statement_.getColumnName(column), row_, found, what));
}

std::int64_t SqliteStatement::integer(int column, std::int64_t min, std::int64_t max) const {
  const std::int64_t value = statement_.getColumn(column).getInt64();
  if (is_null(column) || value < min || value > max) {
    fail(column, fmt::format("a whole number from {} to {}", min, max));
  }
  return value;
}

double SqliteStatement::real(int column, double min, double max) const {
  const double value = statement_.getColumn(column).getDouble();
  if (is_null(column) || value < min || value > max) {
    fail(column, fmt::format("a number from {:.10g} to {:.10g}", min, max));
  }
  return value;
}

std::string SqliteStatement::text(int column) const {
  if (is_null(column)) fail(column, "text");
  return statement_.getColumn(column).getString();
}

std::string SqliteStatement::name(int column) const {
  std::string name = statement_.getColumn(column).getString();
  if (name.empty()) fail(column, "a name");
  return name;
}

std::int64_t SqliteStatement::utc_us(int column) const { return integer(column, 0, kLatest_us); }

std::span<const std::byte> SqliteStatement::blob(int column) const {
  const SQLite::Column value = statement_.getColumn(column);
  const void* first = value.getBlob();  // to be asked for before its length
  return {static_cast<const std::byte*>(first), static_cast<std::size_t>(value.getBytes())};
}

std::optional<std::int64_t> SqliteStatement::optional_utc_us(int column) const {
  return is_null(column) ? std::nullopt : std::optional(utc_us(column));
}

SqliteTransaction::SqliteTransaction(SqliteConnection* connection, Kind kind)
    : connection_(connection) {
  connection_->execute(kind == Kind::kWrite ? "BEGIN IMMEDIATE" : "BEGIN");
}

SqliteTransaction::~SqliteTransaction() {
  // Fails after commit(), and after errors that have rolled back already, such as a full disk.
  connection_->database().tryExec("ROLLBACK");
}

void SqliteTransaction::commit() { connection_->execute("COMMIT"); }

}  // namespace raywalk
