// SQLite databases through SQLiteCpp. Every failure throws Error with the file and what to do: disk
// full, read-only, damaged, not a database, locked by another program for over 10 s.
#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace raywalk {

enum class SqliteAccess {
  kReadWrite,  // creates the file if it is missing
  kReadOnly    // also while another process writes, and on read-only disks
};

// An open database, for use by one thread at a time.
class SqliteConnection {
 public:
  // Throws Error as above; also if the disk is read-only and the latest entries are still in the
  // write-ahead log, which SQLite cannot read there.
  SqliteConnection(const std::filesystem::path& file, SqliteAccess access);

  // Runs one or several statements that return nothing.
  void execute(const std::string& sql);
  // Runs one statement with values bound to it (SqliteStatement::bind). Returns the number of rows
  // that it changed.
  template <typename... Values>
  int run(const std::string& sql, const Values&... values);
  // Makes the tables of a database that was opened to read available as "name.table".
  void attach(const SqliteConnection& other, const std::string& name);
  // The first value of the first row, as "PRAGMA user_version" gives it; 0 or "" for NULL. Throws
  // Error if there is no row.
  std::int64_t integer(const std::string& sql);
  std::string text(const std::string& sql);
  std::int64_t last_row() const { return database_.getLastInsertRowid(); }

  const std::filesystem::path& file() const { return file_; }
  SQLite::Database& database() { return database_; }
  // The result of `work`; what SQLite reports in it becomes an Error.
  template <typename Work>
  auto guarded(const Work& work) const {
    try {
      return work();
    } catch (const SQLite::Exception& error) {
      fail(error);
    }
  }

 private:
  [[noreturn]] void fail(const SQLite::Exception& error) const;

  std::filesystem::path file_;
  SQLite::Database database_;
};

// Throws Error "FILE: damaged: WHAT; ..." of a session's database.
[[noreturn]] void throw_damaged_database(const std::filesystem::path& file, std::string_view what);

// A prepared statement: bind, then step through its rows. Columns are counted from 0. Where a value
// is NULL or not within the bounds (inclusive), those that return no optional throw Error as
// throw_damaged_database does, naming the column as the query names it and the row.
class SqliteStatement {
 public:
  // `connection` must outlive the statement. `row` says what a row is, for messages: "a station".
  SqliteStatement(SqliteConnection* connection, const std::string& sql, std::string row = "a row");

  // Resets the statement and binds ?1, ?2, ... to integers, doubles, text or optionals of these
  // (none: NULL).
  template <typename... Values>
  SqliteStatement& bind(const Values&... values) {
    statement_.tryReset();
    int parameter = 0;
    connection_->guarded([&] { (bind_one(++parameter, values), ...); });
    return *this;
  }
  // Advances to the next row; false if there is none.
  bool step();
  // For a statement that returns no rows.
  void run() { step(); }
  // What this row is called in messages from now on: "station x0_007".
  void call(std::string row) { row_ = std::move(row); }
  [[noreturn]] void fail(int column, const std::string& what) const;

  bool is_null(int column) const { return statement_.isColumnNull(column); }
  std::int64_t integer(int column, std::int64_t min = INT64_MIN,
                       std::int64_t max = INT64_MAX) const;
  int number(int column, int min, int max) const {
    return static_cast<int>(integer(column, min, max));
  }
  bool boolean(int column) const { return integer(column, 0, 1) != 0; }
  double real(int column, double min = -HUGE_VAL, double max = HUGE_VAL) const;
  std::string text(int column) const;
  std::string name(int column) const;  // not empty
  // The enumerator whose word, name_of() of it, stands there.
  template <typename Enum, std::size_t count>
  Enum choice(int column, const std::array<Enum, count>& choices) const {
    std::string known;
    for (const Enum each : choices) {
      if (name_of(each) == text(column)) return each;
      known += (known.empty() ? "" : " or ") + std::string(name_of(each));
    }
    fail(column, known);
  }
  // Microseconds since 1970-01-01 00:00 UTC, until 2200.
  std::int64_t utc_us(int column) const;
  // The bytes of a blob, none of NULL; valid until the next step.
  std::span<const std::byte> blob(int column) const;
  std::optional<std::int64_t> optional_utc_us(int column) const;

 private:
  template <typename Value>
  void bind_one(int parameter, const std::optional<Value>& value) {
    value ? bind_one(parameter, *value) : statement_.bind(parameter);
  }
  template <typename Value>
  void bind_one(int parameter, const Value& value) {
    if constexpr (std::is_arithmetic_v<Value>) {
      statement_.bind(parameter, value);
    } else {
      statement_.bind(parameter, std::string(value));
    }
  }

  SqliteConnection* connection_;
  SQLite::Statement statement_;
  std::string row_;
};

template <typename... Values>
int SqliteConnection::run(const std::string& sql, const Values&... values) {
  SqliteStatement(this, sql).bind(values...).run();
  return database_.getChanges();
}

// A transaction; without commit() the destructor rolls it back.
class SqliteTransaction {
 public:
  enum class Kind {
    kWrite,  // BEGIN IMMEDIATE: waits for other writers
    kRead    // BEGIN: all queries see the same state, whatever another program writes meanwhile
  };

  explicit SqliteTransaction(SqliteConnection* connection, Kind kind = Kind::kWrite);
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;

  // The changes are on disk when it returns.
  void commit();

 private:
  SqliteConnection* connection_;
};

}  // namespace raywalk
