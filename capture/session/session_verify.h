// Whether everything a session names is there as it was written.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "capture/session/session_reader.h"

namespace raywalk::capture {

struct SessionVerification {
  std::int64_t frames = 0;              // checked
  std::int64_t bytes = 0;               // of those
  std::vector<std::string> faults{};    // missing and changed frames, a damaged database
  std::vector<std::string> leftover{};  // files in frames/ that belong to no captured station

  bool is_whole() const { return faults.empty(); }
};

// Reads every frame, on several threads, and compares size and SHA-256; has SQLite check the
// database. Leftover files (of a run that was killed, or of a shot that failed) are no fault.
// Throws Interrupted; Error where the session cannot be read at all.
SessionVerification verify_session(SessionReader* session);

// A line for every fault and leftover file and one that sums up; each ends in a line break.
std::string verification_text(const SessionVerification& verification);

// Throws Error of one line, naming the first fault, unless the session is whole.
void require_whole(const SessionVerification& verification, const SessionReader& session);

}  // namespace raywalk::capture
