// RAII wrappers of the part of SQLite that capture sessions use. Failures throw Error with the file
// and what to do.
#pragma once

#include <sqlite3.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace raywalk {

enum class SqliteAccess {
  kReadWrite,  // creates the file if it is missing
  kReadOnly,   // also while another process writes
  kImmutable   // on a read-only file system: no locks, no write-ahead log
};

// An open database, for use by one thread at a time. Every failure throws Error: disk full,
// read-only, damaged, not a database, locked by another program for over 10 s.
class SqliteConnection {
 public:
  SqliteConnection(const std::filesystem::path& file, SqliteAccess access);

  // Runs one or several statements that return nothing.
  void execute(const std::string& sql);
  // The first value of the first row, as "PRAGMA user_version" gives it.
  std::int64_t integer(const std::string& sql);
  std::string text(const std::string& sql);
  // Rows changed by the last statement.
  int changes() const { return sqlite3_changes(handle_.get()); }
  std::int64_t last_row() const { return sqlite3_last_insert_rowid(handle_.get()); }
  bool in_transaction() const { return sqlite3_get_autocommit(handle_.get()) == 0; }
  bool is_read_only() const { return sqlite3_db_readonly(handle_.get(), "main") == 1; }

  sqlite3* handle() const { return handle_.get(); }
  // Throws Error for the last failed call on this connection.
  [[noreturn]] void fail() const;

 private:
  struct Closer {
    void operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
  };

  std::filesystem::path file_;
  std::unique_ptr<sqlite3, Closer> handle_;
};

// Opens a database read-only, also while another process writes and on read-only file systems.
// Throws Error as the constructor does, and if the file system is read-only and the latest entries
// are still in the write-ahead log.
SqliteConnection open_sqlite_read_only(const std::filesystem::path& file);

// A prepared statement: bind, then step through its rows. Columns are counted from 0.
class SqliteStatement {
 public:
  // `connection` must outlive the statement.
  SqliteStatement(SqliteConnection* connection, std::string_view sql);

  // Resets the statement and binds ?1, ?2, ... to integers, doubles, text or optionals of these
  // (none: NULL).
  template <typename... Values>
  SqliteStatement& bind(const Values&... values) {
    sqlite3_reset(handle_.get());
    int parameter = 0;
    (bind_one(++parameter, values), ...);
    return *this;
  }
  // Advances to the next row; false if there is none.
  bool step();
  // For a statement that returns no rows.
  void run() { step(); }

  // The name of a column of the result, as the query gives it.
  std::string column_name(int column) const;
  // SQLITE_INTEGER, SQLITE_FLOAT, SQLITE_TEXT, SQLITE_BLOB or SQLITE_NULL: of the value in this
  // row.
  int type(int column) const { return sqlite3_column_type(handle_.get(), column); }
  bool is_null(int column) const;
  std::int64_t integer(int column) const { return sqlite3_column_int64(handle_.get(), column); }
  double real(int column) const { return sqlite3_column_double(handle_.get(), column); }
  std::string text(int column) const;
  // The bytes of a blob; valid until the next step.
  std::span<const std::byte> blob(int column) const;
  std::optional<double> optional_real(int column) const;
  std::optional<std::int64_t> optional_integer(int column) const;

 private:
  struct Finalizer {
    void operator()(sqlite3_stmt* handle) const { sqlite3_finalize(handle); }
  };

  void bind_null(int parameter);
  void bind_integer(int parameter, std::int64_t value);
  void bind_real(int parameter, double value);
  void bind_text(int parameter, std::string_view value);

  template <typename Value>
  void bind_one(int parameter, const std::optional<Value>& value) {
    value ? bind_one(parameter, *value) : bind_null(parameter);
  }
  template <typename Value>
  void bind_one(int parameter, const Value& value) {
    if constexpr (std::is_integral_v<Value>) {
      bind_integer(parameter, value);
    } else if constexpr (std::is_floating_point_v<Value>) {
      bind_real(parameter, value);
    } else {
      bind_text(parameter, value);
    }
  }

  SqliteConnection* connection_;
  std::unique_ptr<sqlite3_stmt, Finalizer> handle_;
};

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
