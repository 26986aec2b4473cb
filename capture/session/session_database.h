// A session on the disk for the programs that capture: session.db opened to write, what it starts
// with, what only they read of it (core/session reads stations and frames), and frames/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"
#include "core/files/json.h"
#include "core/files/sqlite_connection.h"
#include "core/geometry/sphere.h"
#include "core/session/session_contents.h"
#include "core/session/session_file.h"  // IWYU pragma: export

namespace raywalk::capture {

inline constexpr char kFramesDirectory[] = "frames";  // in the session's

// Names of all files in frames/ of a session, relative to the session, sorted, with temporary ones.
// Empty if the directory is missing. Throws filesystem_error if it cannot be read.
std::vector<std::string> list_frames(const std::filesystem::path& session_directory);

// Whether a file in frames/ has a temporary name (write_new_file of core/files/atomic_output.h).
bool is_temporary_frame(const std::filesystem::path& file);

// The name of something in a directory that no session has there; empty if there is nothing.
std::string foreign_name(const std::filesystem::path& directory);

// Times of session.db: whole microseconds since 1970-01-01 00:00 UTC.
std::int64_t utc_us_from(WallTime time);
WallTime wall_time_from(std::int64_t utc_us);

// "2026-01-31 13:05:09 UTC".
std::string utc_text(std::int64_t utc_us);

// The row of the table session, but for its plan.
struct SessionFacts {
  WallTime created{};
  CaptureMode mode = CaptureMode::kStations;
  CameraKind camera = CameraKind::kOsc;
  FrameKind frames = FrameKind::kPanorama;
  std::vector<double> bracket_ev{0.0};  // one picture of every station each
  std::string locked_exposure{};        // JSON; empty if nothing was locked
  std::string config_text{};

  int exposures() const { return static_cast<int>(bracket_ev.size()); }
  // What a plan depends on: kind, frames and bracketing.
  CameraConfig camera_config() const;
};

// A reading of the carriage's feedback, for matching a video to positions.
struct JournalSample {
  WallTime time{};
  double position_mm = 0.0;
};

// Opens for writing: WAL, every commit synced before it returns (synchronous FULL), foreign keys
// enforced. Creates a missing file, without tables. Throws Error: damaged, not a session, of a
// newer version, read-only, on a file system without WAL.
SqliteConnection open_session_to_write(const std::filesystem::path& directory);

// Creates the tables and writes the session's row and its plan; committed when it returns.
void create_session(SqliteConnection* connection, const SessionFacts& facts,
                    const CapturePlan& plan);

// Reads a session. Everything is checked while it is read; a damaged value throws Error
// (core/session).
class SessionReader {
 public:
  // Works while a run writes, and on read-only disks; changes nothing. Throws Error: no session,
  // damaged, of a newer version.
  explicit SessionReader(const std::filesystem::path& directory)
      : SessionReader(directory, open_session_to_read(directory)) {}
  // The writer reads over its own connection.
  SessionReader(std::filesystem::path directory, SqliteConnection database);

  const std::filesystem::path& directory() const { return directory_; }
  SessionFacts facts();
  CapturePlan plan();  // that it was created with
  SessionContents contents();
  std::optional<PanoramaSize> frame_size();  // of its frames; none before the first
  std::vector<JournalSample> journal(const std::string& line);  // in the order of recording
  // For queries that only one caller needs; docs/session.md documents the tables. `row` as for
  // SqliteStatement.
  SqliteStatement query(const std::string& sql, const std::string& row);
  SqliteConnection& database() { return database_; }

 private:
  CheckedJson json(const std::string& text, const std::string& column) const;

  std::filesystem::path directory_;
  SqliteConnection database_;
};

}  // namespace raywalk::capture
