// The truth behind a simulated capture, written down beside it.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "capture/simulated/virtual_room/virtual_room.h"

namespace raywalk::capture {

// In a directory of its own:
//   true_poses.csv         file,line,x,y,z,yaw,pitch,roll of every picture (metres, degrees), by
//   its
//                          name on the camera's card
//   dist/<picture>.png     distance maps, as in write_capture.h
//   gt/<name>.png, gt.csv, dist/gt_<name>.png   true views from inside of the cells
class TruthRecorder {
 public:
  // Goes on with a table that is there already. The room has to outlive it. Throws Error where the
  // directory cannot be made or written.
  TruthRecorder(const VirtualRoom* room, PanoramaSize size, std::filesystem::path directory);

  // So many viewpoints, spread by the room's seed.
  void write_views(int count);
  // One row, on its way to the disk when this returns. Throws Error for a full disk.
  void record(const std::string& picture, const std::string& line, const CameraPose& pose);
  void write_distances(const std::string& picture, const CameraPose& pose);

 private:
  const VirtualRoom* room_;
  PanoramaSize size_;
  std::filesystem::path directory_;
  std::ofstream poses_;
};

}  // namespace raywalk::capture
