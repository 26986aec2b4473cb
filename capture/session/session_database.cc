#include "capture/session/session_database.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/files/json.h"
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
  connection->run(
      "INSERT INTO session (id, created_utc_us, mode, camera, frames, bracket_ev, "
      "locked_exposure, part_of, config_text) VALUES (1, ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
      utc_us_from(facts.created), name_of(facts.mode), name_of(facts.camera), name_of(facts.frames),
      nlohmann::json(facts.bracket_ev).dump(), facts.locked_exposure, part_of, facts.config_text);
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

std::vector<std::string> list_frames(const fs::path& session_directory) {
  const fs::path directory = session_directory / kFramesDirectory;
  std::vector<std::string> files;
  if (!fs::exists(directory)) return files;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory)) {
    files.push_back(fmt::format("{}/{}", kFramesDirectory, entry.path().filename().string()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

bool is_temporary_frame(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.starts_with('.') && name.find(".partial") != std::string::npos;
}

std::string foreign_name(const fs::path& directory) {
  const std::set<std::string> own = {"session.db",         "session.db-wal", "session.db-shm",
                                     "session.db-journal", "session.lock",   kFramesDirectory};
  for (const fs::directory_entry& entry : fs::directory_iterator(directory)) {
    std::string name = entry.path().filename().string();
    if (!own.contains(name)) return name;
  }
  return "";
}

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

CameraConfig SessionFacts::camera_config() const {
  CameraConfig config;
  config.kind = camera;
  config.frames = frames;
  config.exposure.bracket_ev = bracket_ev;
  return config;
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
  SqliteTransaction transaction(connection);
  connection->execute(kSessionSchema);
  connection->execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                                  kSessionApplicationId, kSessionFormatVersion));
  write_session_row(connection, facts, plan);
  write_plan(connection, plan);
  transaction.commit();
}

SessionReader::SessionReader(fs::path directory, SqliteConnection database)
    : directory_(std::move(directory)), database_(std::move(database)) {}

SqliteStatement SessionReader::query(const std::string& sql, const std::string& row) {
  return {&database_, sql, row};
}

CheckedJson SessionReader::json(const std::string& text, const std::string& column) const {
  return CheckedJson::parse(text,
                            session_database_path(directory_).string() + ": damaged: " + column,
                            "restore this file from a copy");
}

SessionFacts SessionReader::facts() {
  SqliteStatement row = query(
      "SELECT created_utc_us, mode, camera, frames, bracket_ev, locked_exposure, config_text "
      "FROM session",
      "the session");
  if (!row.step()) throw_damaged_session(directory_, "the table session has no row");
  SessionFacts facts{.created = wall_time_from(row.utc_us(0)),
                     .mode = row.choice(1, kCaptureModes),
                     .camera = row.choice(2, kCameraKinds),
                     .frames = row.choice(3, kFrameKinds),
                     .bracket_ev = {},
                     .locked_exposure = row.text(5),
                     .config_text = row.text(6)};
  for (const CheckedJson& step : json(row.text(4), "bracket_ev").items()) {
    facts.bracket_ev.push_back(step.number());
  }
  if (facts.bracket_ev.empty()) row.fail(4, "an array of numbers");
  return facts;
}

CapturePlan SessionReader::plan() {
  const SessionContents contents = this->contents();
  CapturePlan plan;
  for (const SessionLine& line : contents.lines) {
    plan.lines.push_back({line.id, line.axis, line.across_m, line.validation, {}});
  }
  for (const SessionStation& station : contents.stations) {
    plan.lines[static_cast<std::size_t>(station.line)].stations.push_back(
        {station.name, station.planned_m, station.planned_mm});
  }
  const std::string part_of = database_.text("SELECT part_of FROM session");
  if (!part_of.empty()) {
    const CheckedJson whole = json(part_of, "part_of");
    plan.part_of = WholePlan{whole.at("lines").texts(), whole.at("sha256").text()};
  }
  return plan;
}

SessionContents SessionReader::contents() { return read_session_contents(&database_, directory_); }

std::optional<PanoramaSize> SessionReader::frame_size() {
  SqliteStatement row = query("SELECT width_px, height_px FROM frame LIMIT 1", "a frame");
  if (!row.step()) return std::nullopt;
  return PanoramaSize{static_cast<int>(row.integer(0)), static_cast<int>(row.integer(1))};
}

std::vector<JournalSample> SessionReader::journal(const std::string& line) {
  SqliteStatement row = query(
      "SELECT at_utc_us, position_mm FROM journal JOIN line ON line.id = line_id "
      "WHERE line.name = ?1 ORDER BY journal.id",
      "the journal of line " + line);
  row.bind(line);
  std::vector<JournalSample> samples;
  while (row.step()) {
    samples.push_back({wall_time_from(row.utc_us(0)), row.real(1, -kFarthest_mm, kFarthest_mm)});
  }
  return samples;
}

}  // namespace raywalk::capture
