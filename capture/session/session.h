// A capture session on disk: a directory with session.db (SQLite; docs/session.md documents the
// tables for users who query it), frames/ and session.lock.
//
// The order of writes keeps the session consistent after a crash at any moment: the row of an
// attempt is committed before the slider moves; a frame is written under a temporary name, synced,
// renamed, and its directory synced; only then is the row that names it committed. The file
// names of repeated attempts contain their number, so that no file is ever overwritten.
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
#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"
#include "capture/session/session_database.h"
#include "capture/slider/carriage.h"
#include "core/files/file_lock.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {

// One attempt to capture a station.
struct AttemptId {
  std::int64_t row = 0;  // attempt.id
  std::string station{};
  int number = 0;  // of this station, from 1
};

// A picture that is on the disk but not in the database yet.
struct StoredFrame {
  std::string file{};  // relative to the session's directory, "frames/x0_007.jpg"
  std::int64_t bytes = 0;
  std::string sha256{};
  int exposure_index = 0;  // into ExposureSettings::bracket_ev
  FrameLens lens = FrameLens::kBoth;
  PanoramaSize size{};
  std::string camera_name{};  // file name on the camera's card
  std::string exposure{};     // settings read back for this picture, as JSON
};

// The only writer of a session. For one thread.
class Session {
 public:
  // Creates the directory, or opens an existing session to resume it. Throws Error: it holds
  // another plan, was written by a newer version, is in use by another process, is read-only, is
  // damaged, or its frames are missing; or it is a folder of other files, which stays as it is.
  // `config_text` is stored for reference. `clock` must outlive the session.
  //
  // Opening cleans up after a killed run: its unfinished attempt becomes a failed one with the
  // fault "interrupted", and temporary files are removed. Complete files that no row names stay.
  static std::unique_ptr<Session> open_or_create(const std::filesystem::path& directory,
                                                 const CapturePlan& plan,
                                                 const CaptureConfig& config,
                                                 const std::string& config_text, Clock* clock);
  // Opens an existing session, whatever its plan, to import pictures. Throws Error as above, and if
  // there is no session.
  static std::unique_ptr<Session> open(const std::filesystem::path& directory, Clock* clock);

  const std::filesystem::path& directory() const { return reader_.directory(); }
  // True also while the picture is on the camera's card. Like all calls that name a station or
  // line, throws std::logic_error if the plan does not have it.
  bool is_captured(const std::string& station) const;
  // The return value of Camera::prepare in an earlier run; empty if none.
  std::string exposure() const;
  void set_exposure(const std::string& exposure);
  // The size of this session's frames; none before the first.
  std::optional<PanoramaSize> frame_size() const;
  // What it holds now. Throws Error as read_session_contents does.
  SessionContents contents();
  // Whether a video pass over the line was recorded.
  bool has_journal(const std::string& line) const;

  // All calls below are committed when they return, and throw Error if the database cannot be
  // written.

  // Throws Error if the wall clock is more than a second before the session's last entry (less is
  // taken for a correction by a time server).
  AttemptId begin_attempt(const std::string& station, double commanded_mm);
  // Stores the picture as a file, safe against power loss; no row names it yet. Throws Error (disk
  // full) without leaving a file.
  StoredFrame store_frame(const AttemptId& attempt, int exposure_index, const Picture& picture,
                          FrameLens lens = FrameLens::kBoth);
  // Writes all rows of a captured station in one transaction. Without frames the station is marked
  // as exposed: its pictures are on the camera's card.
  void complete_attempt(const AttemptId& attempt, const SettledPosition& settled, const Shot& shot,
                        std::span<const StoredFrame> frames, double own_ms);
  // The same for a frame of a video; `measured_mm` is the carriage's position when it was exposed.
  void complete_from_video(const AttemptId& attempt, double measured_mm, WallTime exposed_at,
                           std::span<const StoredFrame> frames);
  // Adds the imported pictures of an exposed station, which becomes captured.
  void add_pictures(const AttemptId& exposed, std::span<const StoredFrame> frames);
  void fail_attempt(const AttemptId& attempt, std::string_view fault, const std::string& message);
  // Gives up what was captured at a station, because its frames were lost: the station counts as
  // not captured again, or, if the camera keeps its pictures on a card, as not imported. Files
  // stay.
  void give_up_frames(const std::string& station);
  // Records an event for the history: "run-started", "line-placed", "paused", ...
  void record_event(const std::string& kind, const std::string& text);
  // Appends to the journal of the line.
  void record_journal(const std::string& line, std::span<const JournalSample> samples);

 private:
  Session(const std::filesystem::path& directory, Clock* clock);

  void require_plan(const CapturePlan& plan, const CaptureConfig& config);
  void require_frames_directory();
  void clean_up();
  SqliteConnection& database() const { return reader_.database(); }
  // Of a line or a station, by its name.
  std::int64_t row_of(const std::string& table, const std::string& name) const;
  // The time of a new entry; updates last_entry_us_.
  std::int64_t now_us();
  // Sets columns of an attempt whose outcome is `from`, to values from ?2 on, and adds its frames.
  template <typename... Values>
  void change_attempt(const AttemptId& attempt, const std::string& from, const std::string& columns,
                      std::span<const StoredFrame> frames, const Values&... values);

  Clock* clock_;
  FileLock lock_;
  mutable SessionReader reader_;
  std::int64_t last_entry_us_ = 0;
};

}  // namespace raywalk::capture
