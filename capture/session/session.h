// A capture session on disk: a directory with session.db (SQLite; docs/session.md documents the
// tables for users who query it), frames/ and session.lock.
//
// The order that keeps it whole at any moment of a crash: the row of an attempt is committed before
// the slider moves; a frame is written under a temporary name, synced, renamed and its directory
// synced; only then is the row that names it committed. Frames carry the number of their attempt,
// so that no file is ever overwritten.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "capture/base/clock.h"
#include "capture/camera/camera.h"
#include "capture/plan/capture_plan.h"
#include "capture/session/frame_files.h"
#include "capture/slider/carriage.h"
#include "core/files/file_lock.h"

namespace raywalk {
class SqliteConnection;  // core/files/sqlite_connection.h
}  // namespace raywalk

namespace raywalk::capture {

// One try at one station, by the number of its row.
struct AttemptId {
  std::int64_t row = 0;
  std::string station{};
  int number = 0;  // of this station, from 1
};

// Which half of the surroundings a file shows: cameras that write a front and a back file per shot
// give two frames for one exposure.
enum class FrameLens { kBoth, kFront, kBack };

// A picture that is safe on the disk and that no row names yet.
struct StoredFrame {
  std::string file{};  // relative to the session's directory, "frames/x0_007.jpg"
  std::int64_t bytes = 0;
  std::string sha256{};
  int exposure_index = 0;  // into ExposureSettings::bracket_ev
  FrameLens lens = FrameLens::kBoth;
  PanoramaSize size{};
  std::string camera_name{};  // on the camera's card
  std::string exposure{};     // settings read back for this picture, as JSON
};

// The carriage's feedback at a time, for matching a video to positions.
struct JournalSample {
  WallTime time{};
  double position_mm = 0.0;
};

// The one writer of a session, used by one thread.
class Session {
 public:
  // Makes the directory, or opens the one that is there to go on. Throws Error: it holds another
  // plan, was written by a newer version, is in use by another process, is read-only, is damaged,
  // or its frames are missing. `config_text` is kept for the record. `clock` and `disk` have to
  // outlive it.
  //
  // Opening tidies up after a run that was killed: its attempt becomes a failed one with the fault
  // "interrupted", unfinished temporary files are removed. Whole files that no row names stay.
  static std::unique_ptr<Session> open_or_create(const std::filesystem::path& directory,
                                                 const CapturePlan& plan,
                                                 const CaptureConfig& config,
                                                 const std::string& config_text, Clock* clock,
                                                 DiskLayer* disk = &system_disk());
  // Opens one that is there, whatever its plan, to add what was captured elsewhere. Throws Error as
  // above; no session is there.
  static std::unique_ptr<Session> open(const std::filesystem::path& directory, Clock* clock,
                                       DiskLayer* disk = &system_disk());
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  // Also where the picture is still on the camera's card. Throws std::logic_error for a station
  // that the plan does not have, as all calls do that name one.
  bool is_captured(const std::string& station) const;
  // What Camera::prepare returned in an earlier run; empty where there was none.
  std::string exposure() const;
  void set_exposure(const std::string& exposure);
  // A picture size that earlier frames of this session have; none before the first.
  std::optional<PanoramaSize> frame_size() const;
  // Whether a pass over the line was recorded.
  bool has_journal(const std::string& line) const;

  // All below are committed when they return, and throw Error where the database cannot be written.

  // Throws Error where the wall clock is earlier than the session's last entry by more than a
  // second (less is a time server's correction).
  AttemptId begin_attempt(const std::string& station, double commanded_mm);
  // The picture as a file on disk, safe against power loss; no row names it yet. Throws Error
  // (disk full), leaving nothing.
  StoredFrame store_frame(const AttemptId& attempt, int exposure_index, const Picture& picture,
                          FrameLens lens = FrameLens::kBoth);
  // All rows of a captured station in one transaction. Without frames the station counts as
  // exposed: its pictures are on the camera's card.
  void complete_attempt(const AttemptId& attempt, const SettledPosition& settled, const Shot& shot,
                        std::span<const StoredFrame> frames, double own_ms);
  // The same for a picture out of a film: where the carriage was when it was exposed.
  void complete_from_film(const AttemptId& attempt, double measured_mm, WallTime exposed_at,
                          std::span<const StoredFrame> frames);
  // The pictures of an exposed station, brought in from the card; it counts as captured then.
  void add_pictures(const AttemptId& exposed, std::span<const StoredFrame> frames);
  void fail_attempt(const AttemptId& attempt, std::string_view fault, const std::string& message);
  // What happened besides: "run-started", "line-placed", "paused", ...
  void record_event(const std::string& kind, const std::string& text);
  // Added to what was recorded of the line before.
  void record_journal(const std::string& line, std::span<const JournalSample> samples);

 private:
  Session(std::filesystem::path directory, Clock* clock, DiskLayer* disk);

  void create(const CapturePlan& plan, const CaptureConfig& config, const std::string& config_text);
  void require_plan(const CapturePlan& plan, const CaptureConfig& config) const;
  void require_frames_directory();
  void tidy_up();
  std::int64_t station_row(const std::string& station) const;
  std::int64_t line_row(const std::string& line) const;
  // The time of an entry being made.
  std::int64_t now_us();
  void add_frames(const AttemptId& attempt, std::span<const StoredFrame> frames);
  void add_event(const std::string& kind, const std::string& text);

  std::filesystem::path directory_;
  Clock* clock_;
  FileLock lock_;
  std::unique_ptr<SqliteConnection> database_;
  FrameFiles files_;
  std::int64_t last_entry_us_ = 0;
};

}  // namespace raywalk::capture
