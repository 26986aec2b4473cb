// A whole capture of a virtual room, with its truth, as files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "capture/simulated/virtual_room/virtual_room.h"

namespace raywalk::capture {

struct CaptureOptions {
  std::filesystem::path out;  // directory to make
  // Truth: viewpoints from a table (see read_truth_viewpoints), else so many that the seed spreads.
  std::optional<std::filesystem::path> views{};
  int truth_views = 12;
  int distance_every = 8;  // every so many-th station of a line has a distance map; 0: none has
};

// Writes into the directory, which appears when all is written:
//   capture/<line>_<iii>.jpg|png  what the camera saw from its true pose, with gain and noise
//   poses.csv                     file,x,y,z of the stations where they were meant to be
//   true_poses.csv                file,x,y,z,yaw,pitch,roll where they truly were, if that differs
//   gt/<name>.png, gt.csv         true views from inside the cells: exact, noise-free
//   dist/<line>_<iii>.png         distance maps: 16-bit grey, millimetres along the ray, 0 = sky,
//   dist/gt_<name>.png            at least 1 and at most 65535; from the true poses
// Progress is shown. Returns one line that says what was written. Throws Error: a table of views or
// the directory cannot be used, a camera that is inside of furniture, a full disk; Interrupted.
std::string write_capture(const VirtualRoom& room, const CaptureOptions& options);

}  // namespace raywalk::capture
