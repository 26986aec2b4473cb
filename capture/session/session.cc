#include "capture/session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"

namespace raywalk::capture {
namespace {

namespace fs = std::filesystem;

constexpr char kBusy[] = "another raywalk-capture uses this session; wait for it or stop it";
constexpr std::int64_t kClockSlack_us = 1000000;

// Whether a session was ever created in the directory; an interrupted creation leaves an empty
// file.
bool has_database(const fs::path& directory) {
  std::error_code none;
  const std::uintmax_t bytes = fs::file_size(session_database_path(directory), none);
  return !none && bytes > 0;
}

// A session must not take over a folder of other files: it would be mixed with them, and
// raywalk-calibrate would take the folder for a session. Nor must frames without their database be
// mixed with those of a new session.
void require_free_for_session(const fs::path& directory) {
  if (!list_frames(directory).empty()) {
    throw Error(
        fmt::format("{}: holds frames but its session.db is missing or empty; restore it "
                    "from a copy, or use another directory",
                    directory.string()));
  }
  const std::string other = foreign_name(directory);
  if (other.empty()) return;
  throw Error(fmt::format(
      "{}: is a folder with other files ({}), not a session of raywalk-capture; give a new "
      "folder, or an empty one",
      directory.string(), excerpt(other)));
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
  nlohmann::json::json_pointer place(differences[0]["path"].get<std::string>());
  const nlohmann::json::json_pointer parent = place.parent_pointer();
  if (there.contains(parent) && there[parent].is_array()) place = parent;  // an array as a whole
  const auto value_in = [&](const nlohmann::json& plan) {
    if (!plan.contains(place)) return std::string("not planned");
    const nlohmann::json& value = plan[place];
    return value.is_object() ? std::string("planned") : value.dump();
  };
  return fmt::format("{} is {} there, {} here", place.to_string().substr(1), value_in(there),
                     value_in(here));
}

// None for a time that the device did not report.
std::optional<std::int64_t> known_us(WallTime time) {
  return time == WallTime{} ? std::nullopt : std::optional(utc_us_from(time));
}

}  // namespace

std::unique_ptr<Session> Session::open_or_create(const fs::path& directory, const CapturePlan& plan,
                                                 const CaptureConfig& config,
                                                 const std::string& config_text, Clock* clock) {
  if (fs::is_directory(directory) && !has_database(directory)) require_free_for_session(directory);
  make_durable_directory(directory);
  std::unique_ptr<Session> session(new Session(directory, clock));
  if (is_empty_session(&session->database())) {
    require_free_for_session(directory);
    create_session(&session->database(),
                   {.created = clock->wall_now(),
                    .mode = config.run.mode,
                    .camera = config.camera.kind,
                    .frames = config.camera.frames,
                    .bracket_ev = config.camera.exposure.bracket_ev,
                    .locked_exposure = "",
                    .config_text = config_text},
                   plan);
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

Session::Session(const fs::path& directory, Clock* clock)
    : clock_(clock),
      lock_(directory / "session.lock", kBusy),
      reader_(directory, open_session_to_write(directory)) {}

void Session::require_plan(const CapturePlan& plan, const CaptureConfig& config) {
  const std::string there = plan_json(reader_.plan(), reader_.facts().camera_config());
  const std::string difference = plan_difference(
      nlohmann::json::parse(there), nlohmann::json::parse(plan_json(plan, config.camera)));
  if (difference.empty()) return;
  throw Error(fmt::format(
      "{}: holds another plan: {}; use the configuration and the --lines it was started "
      "with, or another directory",
      directory().string(), difference));
}

void Session::require_frames_directory() {
  const fs::path frames_directory = directory() / kFramesDirectory;
  if (fs::is_directory(frames_directory)) return;
  const std::int64_t frames = database().integer("SELECT count(*) FROM frame");
  if (frames > 0) {
    throw Error(fmt::format("{} is missing, but the session names {} frames in it; restore it",
                            frames_directory.string(), frames));
  }
  make_directories(frames_directory);
  sync_directory(directory());
}

void Session::clean_up() {
  require_frames_directory();
  for (const std::string& file : list_frames(directory())) {
    if (is_temporary_frame(file)) fs::remove(directory() / file);
  }
  last_entry_us_ = database().integer(
      "SELECT max(at) FROM (SELECT created_utc_us AS at FROM session"
      " UNION ALL SELECT begun_utc_us FROM attempt UNION ALL SELECT ended_utc_us FROM attempt"
      " UNION ALL SELECT at_utc_us FROM event)");
  SqliteTransaction transaction(&database());
  const int unfinished = database().run(
      "UPDATE attempt SET outcome = 'failed', fault = 'interrupted',"
      " message = 'the program ended before the station was captured' WHERE outcome IS NULL");
  if (unfinished > 0) {
    record_event("tidied-up", "an earlier run ended in the middle of a station");
  }
  transaction.commit();
}

bool Session::is_captured(const std::string& station) const {
  return SqliteStatement(&database(),
                         "SELECT 1 FROM attempt WHERE station_id = ?1 AND "
                         "outcome IN ('captured', 'exposed')")
      .bind(row_of("station", station))
      .step();
}

std::string Session::exposure() const {
  return database().text("SELECT locked_exposure FROM session");
}

void Session::set_exposure(const std::string& exposure) {
  database().run("UPDATE session SET locked_exposure = ?1", exposure);
}

std::optional<PanoramaSize> Session::frame_size() const { return reader_.frame_size(); }

SessionContents Session::contents() { return reader_.contents(); }

bool Session::has_journal(const std::string& line) const {
  return SqliteStatement(&database(), "SELECT 1 FROM journal WHERE line_id = ?1 LIMIT 1")
      .bind(row_of("line", line))
      .step();
}

AttemptId Session::begin_attempt(const std::string& station, double commanded_mm) {
  const std::int64_t station_id = row_of("station", station);
  const std::int64_t clock_us = utc_us_from(clock_->wall_now());
  if (clock_us + kClockSlack_us < last_entry_us_) {
    throw Error(
        fmt::format("this machine's clock shows {}, earlier than the last entry of {} ({}); "
                    "set the clock",
                    utc_text(clock_us), directory().string(), utc_text(last_entry_us_)));
  }
  SqliteStatement add(&database(),
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
  write_new_file(directory() / file, bytes);
  return {.file = file.string(),
          .bytes = static_cast<std::int64_t>(bytes.size()),
          .sha256 = sha256_hex(bytes),
          .exposure_index = exposure_index,
          .lens = lens,
          .size = picture.size,
          .camera_name = picture.camera_name,
          .exposure = picture.exposure};
}

template <typename... Values>
void Session::change_attempt(const AttemptId& attempt, const std::string& from,
                             const std::string& columns, std::span<const StoredFrame> frames,
                             const Values&... values) {
  SqliteTransaction transaction(&database());
  const int changed =
      database().run("UPDATE attempt SET " + columns + " WHERE id = ?1 AND outcome IS " + from,
                     attempt.row, values...);
  if (changed != 1) {
    throw std::logic_error(fmt::format("attempt {} at station {} is in another state",
                                       attempt.number, attempt.station));
  }
  for (const StoredFrame& frame : frames) {
    database().run(
        "INSERT INTO frame (attempt_id, exposure, lens, file, bytes, sha256, width_px, height_px, "
        "camera_name, settings) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
        attempt.row, frame.exposure_index, name_of(frame.lens), frame.file, frame.bytes,
        frame.sha256, frame.size.width, frame.size.height, frame.camera_name, frame.exposure);
  }
  transaction.commit();
}

void Session::complete_attempt(const AttemptId& attempt, const SettledPosition& settled,
                               const Shot& shot, std::span<const StoredFrame> frames,
                               double own_ms) {
  change_attempt(attempt, "NULL",
                 "outcome = ?2, ended_utc_us = ?3, commanded_mm = ?4, measured_mm = ?5, "
                 "moving_ms = ?6, settling_ms = ?7, triggered_utc_us = ?8, exposed_utc_us = ?9, "
                 "exposing_ms = ?10, transfer_ms = ?11, own_ms = ?12",
                 frames, frames.empty() ? "exposed" : "captured", now_us(), settled.commanded_mm,
                 settled.measured_mm, settled.moving_ms, settled.settling_ms,
                 known_us(shot.triggered_at), known_us(shot.exposed_at), shot.exposing_ms,
                 shot.transfer_ms, own_ms);
}

void Session::complete_from_video(const AttemptId& attempt, double measured_mm, WallTime exposed_at,
                                  std::span<const StoredFrame> frames) {
  change_attempt(attempt, "NULL",
                 "outcome = 'captured', ended_utc_us = ?2, measured_mm = ?3, exposed_utc_us = ?4",
                 frames, now_us(), measured_mm, utc_us_from(exposed_at));
}

void Session::add_pictures(const AttemptId& exposed, std::span<const StoredFrame> frames) {
  change_attempt(exposed, "'exposed'", "outcome = 'captured'", frames);
}

void Session::fail_attempt(const AttemptId& attempt, std::string_view fault,
                           const std::string& message) {
  change_attempt(attempt, "NULL", "outcome = 'failed', ended_utc_us = ?2, fault = ?3, message = ?4",
                 {}, now_us(), fault, message);
}

void Session::give_up_frames(const std::string& station) {
  SqliteTransaction transaction(&database());
  const std::int64_t row = row_of("station", station);
  const SessionFacts facts = reader_.facts();
  const bool on_card = facts.camera == CameraKind::kGpio && facts.mode == CaptureMode::kStations;
  database().run(
      "DELETE FROM frame WHERE attempt_id = "
      "(SELECT id FROM attempt WHERE station_id = ?1 AND outcome = 'captured')",
      row);
  database().run(std::string(on_card ? "UPDATE attempt SET outcome = 'exposed'"
                                     : "UPDATE attempt SET outcome = 'failed', fault = 'lost', "
                                       "message = 'its frames were missing or changed'") +
                     " WHERE station_id = ?1 AND outcome = 'captured'",
                 row);
  record_event("given-up", station + ": its frames were missing or changed");
  transaction.commit();
}

void Session::record_event(const std::string& kind, const std::string& text) {
  database().run("INSERT INTO event (at_utc_us, kind, text) VALUES (?1, ?2, ?3)", now_us(), kind,
                 text);
}

void Session::record_journal(const std::string& line, std::span<const JournalSample> samples) {
  const std::int64_t row = row_of("line", line);
  SqliteTransaction transaction(&database());
  SqliteStatement add(&database(),
                      "INSERT INTO journal (line_id, at_utc_us, position_mm) VALUES (?1, ?2, ?3)");
  for (const JournalSample& sample : samples) {
    add.bind(row, utc_us_from(sample.time), sample.position_mm).run();
  }
  transaction.commit();
}

std::int64_t Session::row_of(const std::string& table, const std::string& name) const {
  SqliteStatement row(&database(), "SELECT id FROM " + table + " WHERE name = ?1");
  if (!row.bind(name).step()) throw std::logic_error("the plan has no " + table + " " + name);
  return row.integer(0);
}

std::int64_t Session::now_us() {
  const std::int64_t now = utc_us_from(clock_->wall_now());
  last_entry_us_ = std::max(last_entry_us_, now);
  return now;
}

}  // namespace raywalk::capture
