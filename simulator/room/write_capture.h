// Writes a complete capture of a virtual room with its ground truth.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "simulator/room/virtual_room.h"

namespace raywalk::simulator {

struct CaptureOptions {
  std::filesystem::path out;  // directory to create
  // Viewpoints of the true views: a table (see read_truth_viewpoints), else `truth_views` chosen by
  // the seed.
  std::optional<std::filesystem::path> views{};
  int truth_views = 12;
  int distance_every = 8;   // distance map at every n-th station of a line; 0: none
  bool thin = false;        // masks of thin structures in the true views
  double ods_ipd_mm = 0.0;  // distance between the eyes of true views in stereo; 0: none
  bool replace = false;     // an earlier capture at `out` is replaced
};

// Writes into the directory, which appears when complete:
//   capture/<line>_<iii>.jpg|png  panoramas from the true poses, with gain and noise
//   poses.csv                     file,x,y,z,line of the nominal stations
//   true_poses.csv                file,x,y,z,yaw,pitch,roll of the true poses, if they differ
//   gt/<name>.png, gt.csv         noise-free true views from inside the cells, without moving
//                                 objects
//   ods/<name>.png                with options.ods_ipd_mm: the true views for two eyes, the left
//                                 one's panorama above the right one's
//   thin/<name>.png, gt_thin.csv  with options.thin: where true views show thin structures
//   dist/<line>_<iii>.png         distance maps: 16-bit grey, millimetres along the ray, 0 = sky,
//   dist/gt_<name>.png            at least 1 and at most 65535; from the true poses
//   people/<line>_<iii>.png       with moving objects: 255 where one is seen in the frame, else 0
//   virtual-room.json             marks the directory as the capture of a virtual room
// Shows progress. Returns a one-line summary. Throws Error if the table of viewpoints or the
// directory cannot be used, a camera is inside furniture or a file cannot be written; Interrupted.
std::string write_capture(const VirtualRoom& room, const CaptureOptions& options);

}  // namespace raywalk::simulator
