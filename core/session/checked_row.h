// Reading rows of a session's database that anything may have happened to: every value is checked
// for its type and range.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/files/sqlite_connection.h"

namespace raywalk {

// Steps through the rows of a query. Values are read as from SqliteStatement; where one is NULL, of
// another type, not finite or out of range (bounds are inclusive), the functions throw Error as
// throw_damaged_session does, naming the column as the query names it and the row.
class CheckedRow {
 public:
  // `directory` is the session's. `row` says what a row is, for messages: "station".
  CheckedRow(SqliteConnection* database, const std::string& sql, std::filesystem::path directory,
             std::string row);

  template <typename... Values>
  CheckedRow& bind(const Values&... values) {
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
  // Without control characters; may be empty.
  std::string text(int column) const;
  // Not empty.
  std::string name(int column) const;
  // Any text.
  std::string document(int column) const;
  // Microseconds since 1970-01-01 00:00 UTC, until 2200.
  std::int64_t utc_us(int column) const;

  bool is_null(int column) const { return statement_.is_null(column); }
  std::optional<std::int64_t> optional_utc_us(int column) const;

 private:
  SqliteStatement statement_;
  std::filesystem::path directory_;
  std::string row_;
};

}  // namespace raywalk
