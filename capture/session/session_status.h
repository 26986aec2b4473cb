// The progress of a session, for `raywalk-capture status`.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/session/session_reader.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {

struct LineStatus {
  std::string id{};
  bool validation = false;
  int stations = 0;  // planned
  int captured = 0;  // frames in the session, and on the disk
  int lost = 0;      // captured, but frames are missing or of another size
  int exposed = 0;   // pictures still on the camera's card
  int attempts = 0;
  bool filmed = false;  // a film pass was recorded
};

// Medians over the captured stations; none if no station has the time. own_ms is the time of a
// station spent by the program: all but motion, settling, exposure and transfer.
struct StationTimes {
  std::optional<double> moving_ms{};
  std::optional<double> settling_ms{};
  std::optional<double> exposing_ms{};
  std::optional<double> transfer_ms{};
  std::optional<double> own_ms{};
  std::optional<double> own_p95_ms{};  // 95th percentile
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
  std::vector<FrameFault> lost_frames{};  // whose files are missing or of another size
  std::map<std::string, int> faults{};    // failed attempts by fault
  StationTimes times{};
  std::optional<double>
      time_left_s{};  // at the median time per station so far, without placing the rail
  std::vector<SessionEvent> last_events{};  // oldest first
  std::string next_step{};

  int stations() const;
  int captured() const;
  int lost() const;
  int exposed() const;
};

// Looks for every frame on the disk without reading it. Throws Error if the session cannot be read.
SessionStatus status_of(SessionReader* session);

// Lines of text, the last one with the next step; each ends in a line break.
std::string status_text(const SessionStatus& status);

// The same as JSON with the field names above; docs/session.md lists them. Unknown times are null.
nlohmann::json status_json(const SessionStatus& status);

}  // namespace raywalk::capture
