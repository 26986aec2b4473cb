// Read-only access to a session, for status, verify, export and import. Everything is checked while
// it is read; a damaged value throws Error (core/session).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/plan/capture_plan.h"
#include "capture/session/session.h"
#include "capture/session/session_database.h"
#include "core/files/json.h"
#include "core/files/sqlite_connection.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {

enum class StationState {
  kPlanned,   // not captured yet
  kExposed,   // the pictures are still on the camera's card
  kCaptured,  // the frames are in the session
};

// A station of the plan and the attempt that captured it.
struct StationRecord {
  std::string line{};
  std::string name{};
  double planned_mm = 0.0;
  StationState state = StationState::kPlanned;
  AttemptId attempt{};  // row 0 if only planned
  std::optional<double> measured_mm{};
  std::optional<WallTime> triggered_at{};
  std::optional<WallTime> exposed_at{};
};

// A frame of a captured station.
struct FrameRecord {
  std::string file{};  // relative to the session's directory
  std::int64_t bytes = 0;
  std::string sha256{};
  std::string line{};
  std::string station{};
  bool validation = false;
  int exposure_index = 0;
  FrameLens lens = FrameLens::kBoth;
  PlanPoint position_m{};  // by the slider's feedback; y = 0
};

// The plan that a session was created with.
CapturePlan plan_of(const SessionContents& contents);

// Works while a run writes, and on read-only disks; changes nothing.
class SessionReader {
 public:
  // Throws Error: no session, damaged, of a newer version.
  explicit SessionReader(std::filesystem::path directory);

  const std::filesystem::path& directory() const { return directory_; }
  SessionFacts facts();
  std::optional<WholePlan> part_of();  // none of a whole plan
  SessionContents contents();
  std::vector<StationRecord> stations();  // in the order of the plan
  // In the order of the plan, by exposure within a station.
  std::vector<FrameRecord> frames();
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
