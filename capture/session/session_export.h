// A finished session as the frame list that raywalk-build-lf packs and the truth that
// raywalk-render validates against.
#pragma once

#include <string>

#include "capture/session/session_reader.h"

namespace raywalk::capture {

struct ExportOptions {
  int exposure = 0;         // which one of a bracket, from 0
  bool partial = false;     // what there is of a session that is not finished
  bool unstitched = false;  // fisheye frames too, which are no panoramas yet
};

// Writes into the session's directory, each file complete when it appears and replacing an earlier
// export:
//   poses.csv  file,x,y,z   every captured station of the grid once, in the order of the plan
//   gt.csv     file,x,y,z   the same of validation lines; only where the plan has such
// Metres in the world frame of core/geometry/sphere.h, y = 0; files relative to the lists. A
// station lies on its line as planned, along it where the slider's feedback says it was captured.
//
// Returns what to tell the user. Throws UsageError for an exposure that the session does not have;
// Error for a session that is not finished (unless partial) or whose frames are no panoramas
// (unless unstitched), and where a list cannot be written.
std::string export_session(SessionReader* session, const ExportOptions& options);

}  // namespace raywalk::capture
