#include "capture/session/session_database.h"

#include <fmt/format.h>

#include <string>

#include "core/base/error.h"
#include "core/session/session_schema.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

// WAL needs shared memory, which network file systems do not provide (sqlite.org/wal.html).
void use_wal(SqliteConnection* connection, const fs::path& directory) {
  if (connection->text("PRAGMA journal_mode = WAL") == "wal") return;
  throw Error(
      fmt::format("{}: its file system does not support SQLite's write-ahead log; use a "
                  "directory on a local disk",
                  directory.string()));
}

void add_missing_copies(SqliteConnection* connection) {
  if (connection->integer("SELECT count(*) FROM sqlite_master WHERE name = 'attempt_copy'") > 0) {
    return;
  }
  SqliteTransaction transaction(connection);
  connection->execute(kSessionCopies);
  transaction.commit();
}

}  // namespace

SqliteConnection open_session_to_write(const fs::path& directory) {
  SqliteConnection connection(session_database_path(directory), SqliteAccess::kReadWrite);
  require_session_format(&connection, directory);
  if (connection.is_read_only()) {
    throw Error(fmt::format("{} cannot be written; check its permissions",
                            session_database_path(directory).string()));
  }
  use_wal(&connection, directory);
  connection.execute("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON");
  if (!is_empty_session(&connection)) {
    require_sound_session(&connection, directory);
    add_missing_copies(&connection);
  }
  return connection;
}

void create_session_tables(SqliteConnection* connection) {
  connection->execute(kSessionSchema);
  connection->execute(kSessionCopies);
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

}  // namespace raywalk::capture
