#include "core/files/sqlite_connection.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk {
namespace {

constexpr int kBusyTimeout_ms = 10000;

// A file name as an SQLite URI (sqlite.org/uri.html): '%', '?' and '#' escaped.
std::string uri_of(const std::filesystem::path& file, std::string_view query) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02x}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  return uri.append("?").append(query);
}

// SQLite would wait for data of a named pipe.
void require_no_special_file(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::exists(file, error)) require_regular_file(file);
}

sqlite3* open_handle(const std::filesystem::path& file, SqliteAccess access, int* result) {
  sqlite3* handle = nullptr;
  switch (access) {
    case SqliteAccess::kReadWrite:
      *result = sqlite3_open_v2(file.c_str(), &handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE,
                                nullptr);
      break;
    case SqliteAccess::kReadOnly:
      *result = sqlite3_open_v2(file.c_str(), &handle, SQLITE_OPEN_READONLY, nullptr);
      break;
    case SqliteAccess::kImmutable:
      *result = sqlite3_open_v2(uri_of(file, "immutable=1").c_str(), &handle,
                                SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
      break;
  }
  return handle;
}

// What failed and what to do, for the primary result codes (sqlite.org/rescode.html) with external
// causes.
std::string explanation(sqlite3* handle) {
  switch (sqlite3_errcode(handle) & 0xFF) {
    case SQLITE_FULL:
      return "the disk is full; free some space (everything captured so far is safe)";
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return "it cannot be written; check the permissions of the session's directory and files";
    case SQLITE_CORRUPT:
      return fmt::format(
          "damaged ({}); the frames are untouched: restore this file from a copy, or recover its "
          "rows with 'sqlite3 session.db .recover'",
          sqlite3_errmsg(handle));
    case SQLITE_NOTADB:
      return "not an SQLite database, or damaged; restore it from a copy (the frames are "
             "untouched)";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "another program has locked it; close that program first";
    case SQLITE_CANTOPEN:
      return fmt::format("it cannot be opened ({}); check that it exists and is readable",
                         std::generic_category().message(sqlite3_system_errno(handle)));
    case SQLITE_IOERR:
      return fmt::format("reading or writing failed ({}); check the disk",
                         std::generic_category().message(sqlite3_system_errno(handle)));
    default:
      return fmt::format(
          "it cannot be read as a session ({}); it is damaged or of another program: restore it "
          "from a copy",
          sqlite3_errmsg(handle));
  }
}

// On a read-only file system SQLite can read a write-ahead log only if its index file exists;
// without the log the latest rows would silently be missing.
SqliteConnection open_immutable(const std::filesystem::path& file) {
  std::filesystem::path log = file;
  log += "-wal";
  std::error_code none;
  const auto log_bytes = std::filesystem::file_size(log, none);
  if (!none && log_bytes > 0) {
    throw Error(
        fmt::format("{}: its latest entries are in {}, which cannot be read on a read-only "
                    "disk; copy the directory to another disk first",
                    file.string(), log.filename().string()));
  }
  return {file, SqliteAccess::kImmutable};
}

bool can_be_read(SqliteConnection* connection) {
  try {
    connection->integer("PRAGMA user_version");
    return true;
  } catch (const Error&) {
    const int code = sqlite3_errcode(connection->handle()) & 0xFF;
    if (code != SQLITE_CANTOPEN && code != SQLITE_READONLY) throw;
    return false;
  }
}

}  // namespace

SqliteConnection::SqliteConnection(const std::filesystem::path& file, SqliteAccess access)
    : file_(file) {
  require_no_special_file(file);
  int result = SQLITE_OK;
  handle_.reset(open_handle(file, access, &result));
  if (result != SQLITE_OK) fail();
  sqlite3_extended_result_codes(handle_.get(), 1);
  sqlite3_busy_timeout(handle_.get(), kBusyTimeout_ms);
}

void SqliteConnection::fail() const {
  throw Error(fmt::format("{}: {}", file_.string(), one_line(explanation(handle_.get()))));
}

void SqliteConnection::execute(const std::string& sql) {
  if (sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

std::int64_t SqliteConnection::integer(const std::string& sql) {
  SqliteStatement statement(this, sql);
  return statement.step() ? statement.integer(0) : 0;
}

std::string SqliteConnection::text(const std::string& sql) {
  SqliteStatement statement(this, sql);
  return statement.step() ? statement.text(0) : std::string();
}

SqliteConnection open_sqlite_read_only(const std::filesystem::path& file) {
  SqliteConnection connection(file, SqliteAccess::kReadOnly);
  return can_be_read(&connection) ? std::move(connection) : open_immutable(file);
}

SqliteStatement::SqliteStatement(SqliteConnection* connection, std::string_view sql)
    : connection_(connection) {
  sqlite3_stmt* handle = nullptr;
  if (sqlite3_prepare_v2(connection_->handle(), sql.data(), static_cast<int>(sql.size()), &handle,
                         nullptr) != SQLITE_OK) {
    connection_->fail();
  }
  handle_.reset(handle);
}

bool SqliteStatement::step() {
  const int result = sqlite3_step(handle_.get());
  if (result != SQLITE_ROW && result != SQLITE_DONE) connection_->fail();
  return result == SQLITE_ROW;
}

std::string SqliteStatement::column_name(int column) const {
  const char* name = sqlite3_column_name(handle_.get(), column);
  return name == nullptr ? std::string() : std::string(name);
}

bool SqliteStatement::is_null(int column) const { return type(column) == SQLITE_NULL; }

std::string SqliteStatement::text(int column) const {
  // The text must be requested before its length (sqlite.org/c3ref/column_blob.html).
  const auto* characters =
      reinterpret_cast<const char*>(sqlite3_column_text(handle_.get(), column));
  const int bytes = sqlite3_column_bytes(handle_.get(), column);
  return characters == nullptr ? std::string()
                               : std::string(characters, static_cast<std::size_t>(bytes));
}

std::span<const std::byte> SqliteStatement::blob(int column) const {
  const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(handle_.get(), column));
  const int size = sqlite3_column_bytes(handle_.get(), column);
  return {bytes, bytes == nullptr ? std::size_t{0} : static_cast<std::size_t>(size)};
}

std::optional<double> SqliteStatement::optional_real(int column) const {
  return is_null(column) ? std::nullopt : std::optional(real(column));
}

std::optional<std::int64_t> SqliteStatement::optional_integer(int column) const {
  return is_null(column) ? std::nullopt : std::optional(integer(column));
}

void SqliteStatement::bind_null(int parameter) {
  if (sqlite3_bind_null(handle_.get(), parameter) != SQLITE_OK) connection_->fail();
}

void SqliteStatement::bind_integer(int parameter, std::int64_t value) {
  if (sqlite3_bind_int64(handle_.get(), parameter, value) != SQLITE_OK) connection_->fail();
}

void SqliteStatement::bind_real(int parameter, double value) {
  if (sqlite3_bind_double(handle_.get(), parameter, value) != SQLITE_OK) connection_->fail();
}

void SqliteStatement::bind_text(int parameter, std::string_view value) {
  // An empty view may have a null address, which SQLite would bind as NULL.
  const char* characters = value.empty() ? "" : value.data();
  if (sqlite3_bind_text(handle_.get(), parameter, characters, static_cast<int>(value.size()),
                        SQLITE_TRANSIENT) != SQLITE_OK) {
    connection_->fail();
  }
}

SqliteTransaction::SqliteTransaction(SqliteConnection* connection, Kind kind)
    : connection_(connection) {
  connection_->execute(kind == Kind::kWrite ? "BEGIN IMMEDIATE" : "BEGIN");
}

SqliteTransaction::~SqliteTransaction() {
  // Some failures, such as a full disk, have already rolled back.
  if (connection_->in_transaction()) {
    sqlite3_exec(connection_->handle(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
}

void SqliteTransaction::commit() { connection_->execute("COMMIT"); }

}  // namespace raywalk
