#include "capture/session/session_database.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <nlohmann/json.hpp>
#include <optional>

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

void write_session_row(SqliteConnection* connection, const SessionFacts& facts,
                       const CapturePlan& plan) {
  std::optional<std::string> part_of;
  if (const auto& whole = plan.part_of) {
    part_of = nlohmann::json{{"lines", whole->lines}, {"sha256", whole->sha256}}.dump();
  }
  SqliteStatement(connection,
                  "INSERT INTO session (id, created_utc_us, mode, camera, frames, bracket_ev, "
                  "locked_exposure, part_of, config_text) "
                  "VALUES (1, ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)")
      .bind(utc_us_from(facts.created), name_of(facts.mode), name_of(facts.camera),
            name_of(facts.frames), nlohmann::json(facts.bracket_ev).dump(), facts.locked_exposure,
            part_of, facts.config_text)
      .run();
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

}  // namespace

std::int64_t utc_us_from(WallTime time) {
  return std::chrono::floor<std::chrono::microseconds>(time.time_since_epoch()).count();
}

WallTime wall_time_from(std::int64_t utc_us) {
  return WallTime{
      std::chrono::duration_cast<WallTime::duration>(std::chrono::microseconds(utc_us))};
}

std::string utc_text(std::int64_t utc_us) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(wall_time_from(utc_us));
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(seconds));
}

SqliteConnection open_session_to_write(const fs::path& directory) {
  SqliteConnection connection(session_database_path(directory), SqliteAccess::kReadWrite);
  require_session_format(&connection, directory);
  if (sqlite3_db_readonly(connection.database().getHandle(), "main") == 1) {
    throw Error(fmt::format("{} cannot be written; check its permissions",
                            session_database_path(directory).string()));
  }
  use_wal(&connection, directory);
  connection.execute("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON");
  if (!is_empty_session(&connection)) require_sound_session(&connection, directory);
  return connection;
}

void create_session(SqliteConnection* connection, const SessionFacts& facts,
                    const CapturePlan& plan) {
  connection->execute(kSessionSchema);
  connection->execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                                  kSessionApplicationId, kSessionFormatVersion));
  write_session_row(connection, facts, plan);
  write_plan(connection, plan);
}

}  // namespace raywalk::capture
