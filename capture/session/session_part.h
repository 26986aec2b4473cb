// A session that is to be merged with others (merge_sessions.h), as far as that needs it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/plan/capture_plan.h"
#include "capture/session/session_reader.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {

// A line of which at least one station is captured, or which is filmed.
struct CapturedLine {
  std::string id{};
  std::size_t captured = 0;       // stations, also with pictures still on the card
  std::size_t planned = 0;        // stations
  std::int64_t ended_utc_us = 0;  // of its last captured station or its film

  bool finished() const { return captured == planned; }
};

struct SessionPart {
  std::filesystem::path directory{};
  std::string name{};  // of the directory, for events
  SessionFacts facts{};
  SessionContents contents{};
  CapturePlan plan{};
  CameraConfig camera{};  // kind, frames and bracketing only
  WholePlan whole{};      // that of which it is a part, or its own
  std::optional<PanoramaSize> frame_size{};
  std::vector<CapturedLine> lines{};
};

// Reads and checks the database, and the sizes of all frames. Throws Error as SessionReader and
// require_no_faults do.
SessionPart read_session_part(SessionReader* session);

// Throws Error unless the sessions are of one camera, one mode and one plan.
void require_same_capture(const std::vector<SessionPart>& parts);

}  // namespace raywalk::capture
