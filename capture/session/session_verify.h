// Checks that the frames of a session are complete and unchanged. (Its database is checked whenever
// it is opened.)
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/session/session_reader.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {

struct SessionVerification {
  std::int64_t frames = 0;              // checked
  std::int64_t bytes = 0;               // of those
  std::vector<FrameFault> faults{};     // missing and changed frames
  std::vector<std::string> leftover{};  // files in frames/ that belong to no captured station

  bool is_whole() const { return faults.empty(); }
};

// Reads every frame, on several threads, and compares size and SHA-256; checks that every captured
// station has all its frames. Leftover files (of a killed run or a failed shot) are not faults.
// Throws Interrupted, and Error if the session cannot be read at all.
SessionVerification verify_session(SessionReader* session);

// One line per fault and leftover file, and a summary; each ends in a line break.
std::string verification_text(const SessionVerification& verification);

// Gives up the stations whose frames are missing or changed (Session::give_up_frames), so that run
// captures them again, import imports them again, and a partial export leaves them out. Returns one
// line with the next step. Throws Error as Session::open does.
std::string give_up_lost_stations(const SessionVerification& verification,
                                  const std::filesystem::path& session, Clock* clock);

}  // namespace raywalk::capture
