#include "capture/session/session_database.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "capture/session/session_schema.h"
#include "core/base/error.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void throw_no_session(const fs::path& directory) {
  throw Error(
      fmt::format("{}: not a session of raywalk-capture; give the directory of "
                  "'run --session'",
                  directory.string()));
}

bool is_empty(SqliteConnection* connection) {
  return connection->integer("SELECT count(*) FROM sqlite_master") == 0;
}

// Accepts a file without tables, left by an interrupted creation.
void require_readable_format(SqliteConnection* connection, const fs::path& directory) {
  if (is_empty(connection)) return;
  if (connection->integer("PRAGMA application_id") != kSessionApplicationId) {
    throw Error(fmt::format("{}: not a session of raywalk-capture; give another directory",
                            session_database_path(directory).string()));
  }
  const std::int64_t version = connection->integer("PRAGMA user_version");
  if (version > kSessionFormatVersion) {
    throw Error(fmt::format(
        "{}: written by a newer raywalk-capture (format {}, this one reads up to {}); use that one",
        directory.string(), version, kSessionFormatVersion));
  }
}

void require_undamaged(SqliteConnection* connection, const fs::path& directory) {
  const std::string found = connection->text("PRAGMA quick_check(1)");
  if (found == "ok") return;
  throw Error(
      fmt::format("{}: damaged ({}); the frames are untouched: restore this file from a copy, or "
                  "recover its rows with 'sqlite3 session.db .recover'",
                  session_database_path(directory).string(), one_line(found)));
}

// WAL needs shared memory, which network file systems do not provide (sqlite.org/wal.html).
void use_wal(SqliteConnection* connection, const fs::path& directory) {
  if (connection->text("PRAGMA journal_mode = WAL") == "wal") return;
  throw Error(
      fmt::format("{}: its file system does not support SQLite's write-ahead log; use a "
                  "directory on a local disk",
                  directory.string()));
}

}  // namespace

fs::path session_database_path(const fs::path& directory) { return directory / "session.db"; }

SqliteConnection open_session_to_write(const fs::path& directory) {
  SqliteConnection connection(session_database_path(directory), SqliteAccess::kReadWrite);
  require_readable_format(&connection, directory);
  if (connection.is_read_only()) {
    throw Error(fmt::format("{} cannot be written; check its permissions",
                            session_database_path(directory).string()));
  }
  use_wal(&connection, directory);
  connection.execute("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON");
  require_undamaged(&connection, directory);
  return connection;
}

SqliteConnection open_session_to_read(const fs::path& directory) {
  if (!fs::exists(session_database_path(directory))) throw_no_session(directory);
  SqliteConnection connection = open_sqlite_read_only(session_database_path(directory));
  require_readable_format(&connection, directory);
  if (is_empty(&connection)) throw_no_session(directory);
  return connection;
}

bool is_new_session(SqliteConnection* connection) { return is_empty(connection); }

void create_session_tables(SqliteConnection* connection) {
  connection->execute(kSessionSchema);
  connection->execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                                  kSessionApplicationId, kSessionFormatVersion));
}

void write_plan(SqliteConnection* connection, const CapturePlan& plan) {
  SqliteStatement add_line(
      connection, "INSERT INTO line (name, axis, across_m, validation) VALUES (?1, ?2, ?3, ?4)");
  SqliteStatement add_station(connection,
                              "INSERT INTO station (line_id, number, name, x_m, z_m, planned_mm) "
                              "VALUES (?1, ?2, ?3, ?4, ?5, ?6)");
  for (const CaptureLine& line : plan.lines) {
    add_line.bind(line.id, name_of(line.axis), line.across_m, line.validation).run();
    const std::int64_t line_row = connection->last_row();
    int number = 0;
    for (const CaptureStation& station : line.stations) {
      add_station
          .bind(line_row, number++, station.name, station.position_m.x_m, station.position_m.z_m,
                station.rail_mm)
          .run();
    }
  }
}

CapturePlan read_plan(SqliteConnection* connection) {
  CapturePlan plan;
  SqliteStatement lines(connection,
                        "SELECT id, name, axis, across_m, validation FROM line ORDER BY id");
  SqliteStatement stations(
      connection,
      "SELECT name, x_m, z_m, planned_mm FROM station WHERE line_id = ?1 ORDER BY number");
  while (lines.step()) {
    CaptureLine line;
    line.id = lines.text(1);
    line.axis = lines.text(2) == "x" ? LineAxis::kX : LineAxis::kZ;
    line.across_m = lines.real(3);
    line.validation = lines.integer(4) != 0;
    stations.bind(lines.integer(0));
    while (stations.step()) {
      line.stations.push_back(
          {stations.text(0), {stations.real(1), stations.real(2)}, stations.real(3)});
    }
    plan.lines.push_back(std::move(line));
  }
  return plan;
}

}  // namespace raywalk::capture
