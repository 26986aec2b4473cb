#include "core/session/session_file.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/session/session_schema.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kLatest_us = 7258118400000000;  // 2200-01-01; a WallTime holds until 2262

[[noreturn]] void throw_no_session(const fs::path& directory) {
  throw Error(
      fmt::format("{}: not a session of raywalk-capture; give the directory of "
                  "'run --session'",
                  directory.string()));
}

}  // namespace

fs::path session_database_path(const fs::path& directory) { return directory / "session.db"; }

void throw_damaged_session(const fs::path& directory, std::string_view what) {
  throw Error(one_line(
      fmt::format("{}: damaged: {}; the frames are untouched: restore this file from a copy, or "
                  "recover its rows with 'sqlite3 session.db .recover'",
                  session_database_path(directory).string(), what)));
}

bool is_empty_session(SqliteConnection* database) {
  return database->integer("SELECT count(*) FROM sqlite_master") == 0;
}

void require_session_format(SqliteConnection* database, const fs::path& directory) {
  if (is_empty_session(database)) return;
  if (database->integer("PRAGMA application_id") != kSessionApplicationId) {
    throw Error(fmt::format("{}: not a session of raywalk-capture; give another directory",
                            session_database_path(directory).string()));
  }
  const std::int64_t version = database->integer("PRAGMA user_version");
  if (version > kSessionFormatVersion) {
    throw Error(fmt::format(
        "{}: written by a newer raywalk-capture (format {}, this program reads up to {}); use the "
        "programs of that version",
        session_database_path(directory).string(), version, kSessionFormatVersion));
  }
  if (version < 1) {
    throw_damaged_session(directory, fmt::format("its format is {}, not 1 or more", version));
  }
}

void require_sound_session(SqliteConnection* database, const fs::path& directory) {
  const SqliteTransaction snapshot(database, SqliteTransaction::Kind::kRead);
  const std::string found = database->text("PRAGMA integrity_check(1)");
  if (found != "ok") throw_damaged_session(directory, found);
  const std::int64_t dangling =
      database->integer("SELECT count(*) FROM pragma_foreign_key_check()");
  if (dangling > 0) {
    throw_damaged_session(directory, fmt::format("{} rows refer to missing rows", dangling));
  }
}

SqliteConnection open_session_to_read(const fs::path& directory) {
  if (!fs::exists(session_database_path(directory))) throw_no_session(directory);
  SqliteConnection database(session_database_path(directory), SqliteAccess::kReadOnly);
  require_session_format(&database, directory);
  if (is_empty_session(&database)) throw_no_session(directory);
  require_sound_session(&database, directory);
  return database;
}

SessionRow::SessionRow(SqliteConnection* database, const std::string& sql, fs::path directory,
                       std::string row)
    : statement_(database, sql), directory_(std::move(directory)), row_(std::move(row)) {}

void SessionRow::fail(int column, const std::string& what) const {
  const std::string found = is_null(column) ? "NULL" : excerpt(statement_.text(column));
  throw_damaged_session(directory_, fmt::format("{} of {} is {}; it must be {}",
                                                statement_.column_name(column), row_, found, what));
}

std::int64_t SessionRow::integer(int column, std::int64_t min, std::int64_t max) const {
  const std::int64_t value = statement_.integer(column);
  if (is_null(column) || value < min || value > max) {
    fail(column, fmt::format("a whole number from {} to {}", min, max));
  }
  return value;
}

int SessionRow::number(int column, int min, int max) const {
  return static_cast<int>(integer(column, min, max));
}

double SessionRow::real(int column, double min, double max) const {
  const double value = statement_.real(column);
  if (is_null(column) || value < min || value > max) {
    fail(column, fmt::format("a number from {:.10g} to {:.10g}", min, max));
  }
  return value;
}

std::string SessionRow::text(int column) const {
  if (is_null(column)) fail(column, "text");
  return statement_.text(column);
}

std::string SessionRow::name(int column) const {
  std::string name = statement_.text(column);
  if (name.empty()) fail(column, "a name");
  return name;
}

std::int64_t SessionRow::utc_us(int column) const { return integer(column, 0, kLatest_us); }

std::optional<std::int64_t> SessionRow::optional_utc_us(int column) const {
  return is_null(column) ? std::nullopt : std::optional(utc_us(column));
}

}  // namespace raywalk
