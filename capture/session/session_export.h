// Exports a session as the frame list that raywalk-build-lf packs and the ground-truth views that
// raywalk-render validates against.
#pragma once

#include <string>

#include "capture/session/session_reader.h"

namespace raywalk::capture {

struct ExportOptions {
  int exposure = 0;         // index into the bracket, from 0
  bool partial = false;     // also export an unfinished session
  bool unstitched = false;  // also export fisheye frames
};

// Writes into the session's directory, atomically and replacing an earlier export:
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
