#include "capture/session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "capture/session/frame_files.h"
#include "capture/session/session_database.h"
#include "capture/session/session_reader.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

constexpr char kBusy[] = "another raywalk-capture uses this session; wait for it or stop it";
constexpr std::int64_t kClockSlack_us = 1000000;

// Frames without their database must not be mixed with those of a new session.
void require_no_frames(const fs::path& directory) {
  if (list_frames(directory).empty()) return;
  throw Error(
      fmt::format("{}: holds frames but its session.db is missing or empty; restore it "
                  "from a copy, or use another directory",
                  directory.string()));
}

// Whether a session was ever created in the directory; an interrupted creation leaves an empty
// file.
bool has_database(const fs::path& directory) {
  std::error_code none;
  const std::uintmax_t bytes = fs::file_size(session_database_path(directory), none);
  return !none && bytes > 0;
}

// A session must not take over a folder of other files: it would be mixed with them, and
// raywalk-calibrate would take the folder for a session.
void require_session_or_empty(const fs::path& directory) {
  if (!fs::is_directory(directory) || has_database(directory)) return;
  require_no_frames(directory);
  const std::set<std::string> own = {"session.db",         "session.db-wal", "session.db-shm",
                                     "session.db-journal", "session.lock",   "frames"};
  for (const fs::directory_entry& entry : fs::directory_iterator(directory)) {
    const std::string name = entry.path().filename().string();
    if (own.contains(name)) continue;
    throw Error(fmt::format(
        "{}: is a folder with other files ({}), not a session of raywalk-capture; give a new "
        "folder, or an empty one",
        directory.string(), excerpt(name)));
  }
}

void make_durable_directory(const fs::path& directory) {
  make_directories(directory);
  try {
    sync_directory(fs::canonical(directory).parent_path());
  } catch (const Error&) {
    // A parent without read permission cannot be synced; the session below it is.
  }
}

// "x0_007.jpg"; further parts only if needed to distinguish frames: "x0_007_a2_e1_front.jpg".
std::string frame_name(const AttemptId& attempt, int exposure_index, FrameLens lens,
                       const std::string& extension) {
  std::string name = attempt.station;
  if (attempt.number > 1) name += fmt::format("_a{}", attempt.number);
  if (exposure_index > 0) name += fmt::format("_e{}", exposure_index);
  if (lens == FrameLens::kFront) name += "_front";
  if (lens == FrameLens::kBack) name += "_back";
  return name + "." + extension;
}

// "lines/x0/stations/x0_001/rail_mm is 800.0 there, 810.0 here"; empty where plans are the same.
std::string plan_difference(const nlohmann::json& there, const nlohmann::json& here) {
  const nlohmann::json differences = nlohmann::json::diff(there, here);
  if (differences.empty()) return "";
  const nlohmann::json::json_pointer place(differences[0]["path"].get<std::string>());
  const auto value_in = [&](const nlohmann::json& plan) {
    if (!plan.contains(place)) return std::string("not planned");
    const nlohmann::json& value = plan[place];
    return value.is_structured() ? std::string("planned") : value.dump();
  };
  return fmt::format("{} is {} there, {} here", place.to_string().substr(1), value_in(there),
                     value_in(here));
}

// None for a time that the device did not report.
std::optional<std::int64_t> known_us(WallTime time) {
  return time == WallTime{} ? std::nullopt : std::optional(utc_us_from(time));
}

void require_changed(const SqliteConnection& database, const AttemptId& attempt) {
  if (database.changes() == 1) return;
  throw std::logic_error(
      fmt::format("attempt {} at station {} is in another state", attempt.number, attempt.station));
}

}  // namespace

std::unique_ptr<Session> Session::open_or_create(const fs::path& directory, const CapturePlan& plan,
                                                 const CaptureConfig& config,
                                                 const std::string& config_text, Clock* clock) {
  require_session_or_empty(directory);
  make_durable_directory(directory);
  std::unique_ptr<Session> session(new Session(directory, clock));
  if (is_empty_session(session->database_.get())) {
    require_no_frames(directory);
    session->create(plan, config, config_text);
  } else {
    session->require_plan(plan, config);
  }
  session->clean_up();
  return session;
}

std::unique_ptr<Session> Session::open(const fs::path& directory, Clock* clock) {
  open_session_to_read(directory);  // throws if there is none, before anything is created
  std::unique_ptr<Session> session(new Session(directory, clock));
  session->contents();  // throws if a value is damaged
  session->clean_up();
  return session;
}

Session::Session(fs::path directory, Clock* clock)
    : directory_(std::move(directory)),
      clock_(clock),
      lock_(directory_ / "session.lock", kBusy),
      database_(std::make_unique<SqliteConnection>(open_session_to_write(directory_))) {}

Session::~Session() = default;

void Session::create(const CapturePlan& plan, const CaptureConfig& config,
                     const std::string& config_text) {
  SqliteTransaction transaction(database_.get());
  create_session(database_.get(),
                 {.created = wall_time_from(now_us()),
                  .mode = config.run.mode,
                  .camera = config.camera.kind,
                  .frames = config.camera.frames,
                  .bracket_ev = config.camera.exposure.bracket_ev,
                  .locked_exposure = "",
                  .config_text = config_text},
                 plan);
  transaction.commit();
}

void Session::require_plan(const CapturePlan& plan, const CaptureConfig& config) {
  auto there = nlohmann::json::parse(plan_json(plan_of(contents()), config.camera));
  auto here = nlohmann::json::parse(plan_json(plan, config.camera));
  // As the columns have them.
  there["frames"] = database_->text("SELECT frames FROM session");
  for (const std::string column : {"bracket_ev", "part_of"}) {
    there[column] = database_->text("SELECT " + column + " FROM session");
    here[column] = here.contains(column) ? here[column].dump() : "";
  }
  const std::string difference = plan_difference(there, here);
  if (difference.empty()) return;
  throw Error(fmt::format(
      "{}: holds another plan: {}; use the configuration and the --lines it was started "
      "with, or another directory",
      directory_.string(), difference));
}

void Session::require_frames_directory() {
  const std::int64_t frames = database_->integer("SELECT count(*) FROM frame");
  const fs::path directory = directory_ / kFramesDirectory;
  if (fs::is_directory(directory)) return;
  if (frames > 0) {
    throw Error(fmt::format("{} is missing, but the session names {} frames in it; restore it",
                            directory.string(), frames));
  }
  make_directories(directory);
  sync_directory(directory_);
}

void Session::clean_up() {
  require_frames_directory();
  remove_temporary_frames(directory_);
  last_entry_us_ = database_->integer(
      "SELECT max(coalesce((SELECT max(created_utc_us) FROM session), 0),"
      " coalesce((SELECT max(begun_utc_us) FROM attempt), 0),"
      " coalesce((SELECT max(ended_utc_us) FROM attempt), 0),"
      " coalesce((SELECT max(at_utc_us) FROM event), 0))");
  SqliteTransaction transaction(database_.get());
  database_->execute(
      "UPDATE attempt SET outcome = 'failed', fault = 'interrupted',"
      " message = 'the program ended before the station was captured' WHERE outcome IS NULL");
  if (database_->changes() > 0) {
    add_event("tidied-up", "an earlier run ended in the middle of a station");
  }
  transaction.commit();
}

bool Session::is_captured(const std::string& station) const {
  return SqliteStatement(database_.get(),
                         "SELECT 1 FROM attempt WHERE station_id = ?1 AND "
                         "outcome IN ('captured', 'exposed')")
      .bind(station_row(station))
      .step();
}

std::string Session::exposure() const {
  return database_->text("SELECT locked_exposure FROM session");
}

void Session::set_exposure(const std::string& exposure) {
  SqliteStatement(database_.get(), "UPDATE session SET locked_exposure = ?1").bind(exposure).run();
}

std::optional<PanoramaSize> Session::frame_size() const {
  SqliteStatement frame(database_.get(), "SELECT width_px, height_px FROM frame LIMIT 1");
  if (!frame.step()) return std::nullopt;
  return PanoramaSize{static_cast<int>(frame.integer(0)), static_cast<int>(frame.integer(1))};
}

SessionContents Session::contents() { return read_session_contents(database_.get(), directory_); }

bool Session::has_journal(const std::string& line) const {
  return SqliteStatement(database_.get(), "SELECT 1 FROM journal WHERE line_id = ?1 LIMIT 1")
      .bind(line_row(line))
      .step();
}

AttemptId Session::begin_attempt(const std::string& station, double commanded_mm) {
  const std::int64_t station_id = station_row(station);
  const std::int64_t clock_us = utc_us_from(clock_->wall_now());
  if (clock_us + kClockSlack_us < last_entry_us_) {
    throw Error(
        fmt::format("this machine's clock shows {}, earlier than the last entry of {} ({}); "
                    "set the clock",
                    utc_text(clock_us), directory_.string(), utc_text(last_entry_us_)));
  }
  SqliteStatement add(database_.get(),
                      "INSERT INTO attempt (station_id, number, begun_utc_us, commanded_mm) VALUES "
                      "(?1, (SELECT coalesce(max(number), 0) + 1 FROM attempt WHERE station_id = "
                      "?1), ?2, ?3) RETURNING id, number");
  add.bind(station_id, now_us(), commanded_mm).step();
  AttemptId attempt{add.integer(0), station, static_cast<int>(add.integer(1))};
  add.run();  // to its end, which commits
  return attempt;
}

StoredFrame Session::store_frame(const AttemptId& attempt, int exposure_index,
                                 const Picture& picture, FrameLens lens) {
  const auto bytes = std::as_bytes(std::span(picture.bytes));
  const fs::path file =
      fs::path(kFramesDirectory) / frame_name(attempt, exposure_index, lens, picture.extension);
  write_new_file(directory_ / file, bytes);
  return {.file = file.string(),
          .bytes = static_cast<std::int64_t>(bytes.size()),
          .sha256 = sha256_hex(bytes),
          .exposure_index = exposure_index,
          .lens = lens,
          .size = picture.size,
          .camera_name = picture.camera_name,
          .exposure = picture.exposure};
}

void Session::complete_attempt(const AttemptId& attempt, const SettledPosition& settled,
                               const Shot& shot, std::span<const StoredFrame> frames,
                               double own_ms) {
  SqliteTransaction transaction(database_.get());
  SqliteStatement(database_.get(),
                  "UPDATE attempt SET outcome = ?2, ended_utc_us = ?3, commanded_mm = ?4, "
                  "measured_mm = ?5, moving_ms = ?6, settling_ms = ?7, triggered_utc_us = ?8, "
                  "exposed_utc_us = ?9, exposing_ms = ?10, transfer_ms = ?11, own_ms = ?12 "
                  "WHERE id = ?1 AND outcome IS NULL")
      .bind(attempt.row, frames.empty() ? "exposed" : "captured", now_us(), settled.commanded_mm,
            settled.measured_mm, settled.moving_ms, settled.settling_ms,
            known_us(shot.triggered_at), known_us(shot.exposed_at), shot.exposing_ms,
            shot.transfer_ms, own_ms)
      .run();
  require_changed(*database_, attempt);
  add_frames(attempt, frames);
  transaction.commit();
}

void Session::complete_from_film(const AttemptId& attempt, double measured_mm, WallTime exposed_at,
                                 std::span<const StoredFrame> frames) {
  SqliteTransaction transaction(database_.get());
  SqliteStatement(database_.get(),
                  "UPDATE attempt SET outcome = 'captured', ended_utc_us = ?2, measured_mm = ?3, "
                  "exposed_utc_us = ?4 WHERE id = ?1 AND outcome IS NULL")
      .bind(attempt.row, now_us(), measured_mm, utc_us_from(exposed_at))
      .run();
  require_changed(*database_, attempt);
  add_frames(attempt, frames);
  transaction.commit();
}

void Session::add_pictures(const AttemptId& exposed, std::span<const StoredFrame> frames) {
  SqliteTransaction transaction(database_.get());
  SqliteStatement(database_.get(),
                  "UPDATE attempt SET outcome = 'captured' WHERE id = ?1 AND outcome = 'exposed'")
      .bind(exposed.row)
      .run();
  require_changed(*database_, exposed);
  add_frames(exposed, frames);
  transaction.commit();
}

void Session::fail_attempt(const AttemptId& attempt, std::string_view fault,
                           const std::string& message) {
  SqliteStatement(database_.get(),
                  "UPDATE attempt SET outcome = 'failed', ended_utc_us = ?2, fault = ?3, "
                  "message = ?4 WHERE id = ?1 AND outcome IS NULL")
      .bind(attempt.row, now_us(), fault, message)
      .run();
  require_changed(*database_, attempt);
}

void Session::give_up_frames(const std::string& station) {
  SqliteTransaction transaction(database_.get());
  const std::int64_t row = station_row(station);
  const bool on_card =
      database_->text("SELECT camera FROM session") == name_of(CameraKind::kGpio) &&
      database_->text("SELECT mode FROM session") == name_of(CaptureMode::kStations);
  SqliteStatement(database_.get(),
                  "DELETE FROM frame WHERE attempt_id = (SELECT id FROM attempt WHERE station_id = "
                  "?1 AND outcome = 'captured')")
      .bind(row)
      .run();
  SqliteStatement(database_.get(), on_card
                                       ? "UPDATE attempt SET outcome = 'exposed' WHERE "
                                         "station_id = ?1 AND outcome = 'captured'"
                                       : "UPDATE attempt SET outcome = 'failed', fault = 'lost', "
                                         "message = 'its frames were missing or changed' WHERE "
                                         "station_id = ?1 AND outcome = 'captured'")
      .bind(row)
      .run();
  add_event("given-up", station + ": its frames were missing or changed");
  transaction.commit();
}

void Session::record_event(const std::string& kind, const std::string& text) {
  add_event(kind, text);
}

void Session::record_journal(const std::string& line, std::span<const JournalSample> samples) {
  const std::int64_t row = line_row(line);
  SqliteTransaction transaction(database_.get());
  SqliteStatement add(database_.get(),
                      "INSERT INTO journal (line_id, at_utc_us, position_mm) VALUES (?1, ?2, ?3)");
  for (const JournalSample& sample : samples) {
    add.bind(row, utc_us_from(sample.time), sample.position_mm).run();
  }
  transaction.commit();
}

std::int64_t Session::station_row(const std::string& station) const {
  SqliteStatement row(database_.get(), "SELECT id FROM station WHERE name = ?1");
  if (!row.bind(station).step()) throw std::logic_error("the plan has no station " + station);
  return row.integer(0);
}

std::int64_t Session::line_row(const std::string& line) const {
  SqliteStatement row(database_.get(), "SELECT id FROM line WHERE name = ?1");
  if (!row.bind(line).step()) throw std::logic_error("the plan has no line " + line);
  return row.integer(0);
}

std::int64_t Session::now_us() {
  const std::int64_t now = utc_us_from(clock_->wall_now());
  last_entry_us_ = std::max(last_entry_us_, now);
  return now;
}

void Session::add_frames(const AttemptId& attempt, std::span<const StoredFrame> frames) {
  SqliteStatement add(database_.get(),
                      "INSERT INTO frame (attempt_id, exposure, lens, file, bytes, sha256, "
                      "width_px, height_px, camera_name, settings) VALUES (?1, ?2, ?3, ?4, ?5, ?6, "
                      "?7, ?8, ?9, ?10)");
  for (const StoredFrame& frame : frames) {
    add.bind(attempt.row, frame.exposure_index, name_of(frame.lens), frame.file, frame.bytes,
             frame.sha256, frame.size.width, frame.size.height, frame.camera_name, frame.exposure)
        .run();
  }
}

void Session::add_event(const std::string& kind, const std::string& text) {
  SqliteStatement(database_.get(), "INSERT INTO event (at_utc_us, kind, text) VALUES (?1, ?2, ?3)")
      .bind(now_us(), kind, text)
      .run();
}

}  // namespace raywalk::capture
