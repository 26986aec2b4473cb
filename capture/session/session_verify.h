// Checks that the frames and database of a session are complete and unchanged.
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

// Reads every frame, on several threads, and compares size and SHA-256; runs SQLite's check of the
// database. Leftover files (of a killed run or a failed shot) are not faults. Throws Interrupted,
// and Error if the session cannot be read at all.
SessionVerification verify_session(SessionReader* session);

// One line per fault and leftover file, and a summary; each ends in a line break.
std::string verification_text(const SessionVerification& verification);

// Throws Error of one line, naming the first fault, if there are faults.
void require_whole(const SessionVerification& verification, const SessionReader& session);

}  // namespace raywalk::capture
