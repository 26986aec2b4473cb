// The database of a capture session, and its rows, checked before anything in it is believed.
// docs/session.md documents its tables.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/files/sqlite_connection.h"

namespace raywalk {

// "<directory>/session.db".
std::filesystem::path session_database_path(const std::filesystem::path& directory);

// Throws Error "<directory>/session.db: damaged: WHAT; ...".
[[noreturn]] void throw_damaged_session(const std::filesystem::path& directory,
                                        std::string_view what);

// Whether a database has no tables, as after an interrupted creation of a session.
bool is_empty_session(SqliteConnection* database);

// Throws Error: not a session, or of a newer version. Accepts a file without tables.
void require_session_format(SqliteConnection* database, const std::filesystem::path& directory);

// Throws Error if SQLite's integrity check finds damage or a row refers to a missing row. Reads the
// whole database.
void require_sound_session(SqliteConnection* database, const std::filesystem::path& directory);

// Opens for reading and checks format and soundness, also while another process writes, and on
// read-only disks. Throws Error: damaged, no session, of a newer version, or a read-only disk on
// which entries are only in the write-ahead log.
SqliteConnection open_session_to_read(const std::filesystem::path& directory);

// Steps through the rows of a query. Values are read as from SqliteStatement; where one is NULL or
// out of range (bounds are inclusive), the functions throw Error as throw_damaged_session does,
// naming the column as the query names it and the row.
class SessionRow {
 public:
  // `directory` is the session's. `row` says what a row is, for messages: "a station".
  SessionRow(SqliteConnection* database, const std::string& sql, std::filesystem::path directory,
             std::string row);

  template <typename... Values>
  SessionRow& bind(const Values&... values) {
    statement_.bind(values...);
    return *this;
  }
  bool step() { return statement_.step(); }
  // What this row is called in messages from now on: "station x0_007".
  void call(std::string row) { row_ = std::move(row); }
  [[noreturn]] void fail(int column, const std::string& what) const;

  std::int64_t integer(int column, std::int64_t min, std::int64_t max) const;
  int number(int column, int min, int max) const;
  bool boolean(int column) const { return integer(column, 0, 1) != 0; }
  double real(int column, double min, double max) const;
  std::string text(int column) const;
  std::string name(int column) const;  // not empty
  // Microseconds since 1970-01-01 00:00 UTC, until 2200.
  std::int64_t utc_us(int column) const;
  std::optional<std::int64_t> optional_utc_us(int column) const;
  bool is_null(int column) const { return statement_.is_null(column); }

 private:
  SqliteStatement statement_;
  std::filesystem::path directory_;
  std::string row_;
};

}  // namespace raywalk
