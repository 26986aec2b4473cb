// The database of a merged session (merge_sessions.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "capture/session/session_part.h"

namespace raywalk::capture {

// A line of the merged session.
struct MergedLine {
  std::string id{};
  std::size_t part = 0;  // the session it is taken from
  CapturedLine captured{};
  std::vector<std::size_t> replaced{};  // sessions whose older line is not taken
};

// Writes session.db anew in a directory that nobody else writes to. `readers` and `parts` are the
// same sessions; `plan` has the lines in their order. Exposure and configuration are those of the
// session that captured last. Throws Error if it cannot be written.
void write_merged_database(const std::filesystem::path& directory,
                           std::span<const std::unique_ptr<SessionReader>> readers,
                           const std::vector<SessionPart>& parts,
                           const std::vector<MergedLine>& lines, const CapturePlan& plan,
                           std::int64_t now_utc_us);

}  // namespace raywalk::capture
