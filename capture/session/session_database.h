// Opening session.db for the process that captures, and writing what it starts with.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"
#include "core/files/sqlite_connection.h"
#include "core/session/session_file.h"  // IWYU pragma: export

namespace raywalk::capture {

// Opens for writing: WAL, every commit synced before it returns (synchronous FULL), foreign keys
// enforced. Creates a missing file, without tables. Throws Error: damaged, not a session, of a
// newer version, read-only, on a file system without WAL.
SqliteConnection open_session_to_write(const std::filesystem::path& directory);

// Times of session.db: whole microseconds since 1970-01-01 00:00 UTC.
std::int64_t utc_us_from(WallTime time);
WallTime wall_time_from(std::int64_t utc_us);

// "2026-01-31 13:05:09 UTC".
std::string utc_text(std::int64_t utc_us);

// Facts of the whole session.
struct SessionFacts {
  WallTime created{};
  CaptureMode mode = CaptureMode::kStations;
  CameraKind camera = CameraKind::kOsc;
  FrameKind frames = FrameKind::kPanorama;
  std::vector<double> bracket_ev{0.0};  // one picture of every station each
  std::string locked_exposure{};        // JSON; empty if nothing was locked
  std::string config_text{};

  int exposures() const { return static_cast<int>(bracket_ev.size()); }
};

// Creates the tables and writes the session's row and its plan, within the caller's transaction.
void create_session(SqliteConnection* connection, const SessionFacts& facts,
                    const CapturePlan& plan);

}  // namespace raywalk::capture
