// The frames of a session: whether they are complete and unchanged (its database is checked
// whenever it is opened), and where they were taken, as lists for the other programs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/base/clock.h"
#include "capture/session/session_database.h"
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

struct ExportOptions {
  int exposure = 0;         // index into the bracket, from 0
  bool partial = false;     // also export an unfinished session
  bool unstitched = false;  // also export fisheye frames
};

// The frame list that raywalk-build-lf packs and the ground-truth views that raywalk-render
// validates against. Writes into the session's directory, atomically and replacing an earlier
// export:
//   poses.csv  file,x,y,z,line  the captured stations of the grid, in the order of the plan
//   gt.csv     file,x,y,z       the same for validation lines, if the plan has any
// Metres in the world frame of core/geometry/sphere.h, y = 0; file names relative to the lists. The
// position along the line is that of the slider's feedback, the position across it as planned.
//
// Before, every frame is compared with its checksum, and the stations with the plan. Returns a
// summary for the user. Throws UsageError for an exposure that the session does not have;
// Error for an unfinished session (unless partial), for frames that are not panoramas (unless
// unstitched), for missing and changed frames, and if a list cannot be written.
std::string export_session(SessionReader* session, const ExportOptions& options);

}  // namespace raywalk::capture
