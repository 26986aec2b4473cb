// How far a session is: what `raywalk-capture status` tells.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/session/session_reader.h"

namespace raywalk::capture {

struct LineStatus {
  std::string id{};
  bool validation = false;
  int stations = 0;  // planned
  int captured = 0;  // frames in the session
  int exposed = 0;   // pictures still on the camera's card
  int attempts = 0;
  bool filmed = false;  // a pass over it was recorded
};

// Medians over the captured stations; none where no station has the time. own_ms is the program's
// own share of a station: everything but motion, settling, exposure and transfer.
struct StationTimes {
  std::optional<double> moving_ms{};
  std::optional<double> settling_ms{};
  std::optional<double> exposing_ms{};
  std::optional<double> transfer_ms{};
  std::optional<double> own_ms{};
  std::optional<double> own_p95_ms{};  // 95 % of the stations took no longer
};

struct SessionEvent {
  WallTime at{};
  std::string kind{};
  std::string text{};
};

struct SessionStatus {
  std::string directory{};
  CaptureMode mode = CaptureMode::kStations;
  std::vector<LineStatus> lines{};
  std::map<std::string, int> faults{};  // failed attempts by fault
  StationTimes times{};
  std::optional<double> time_left_s{};      // at the median pace so far, without placing the rail
  std::vector<SessionEvent> last_events{};  // oldest first
  std::string next_step{};

  int stations() const;
  int captured() const;
  int exposed() const;
};

// Throws Error where the session cannot be read.
SessionStatus status_of(SessionReader* session);

// Lines for people, the last one the next step; each ends in a line break.
std::string status_text(const SessionStatus& status);

// The same with the field names above; docs/session.md lists them. A time that is not known is
// null.
nlohmann::json status_json(const SessionStatus& status);

}  // namespace raywalk::capture
