// Records the ground truth of a simulated capture.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "simulator/room/virtual_room.h"

namespace raywalk::capture {

// Files in its directory:
//   true_poses.csv      file,line,x,y,z,yaw,pitch,roll (metres, degrees) of every picture, `file`
//                       being its name on the camera's card
//   dist/<picture>.png  distance maps, as in write_capture.h
//   gt/<name>.png, gt.csv, dist/gt_<name>.png   true views from inside the cells
class TruthRecorder {
 public:
  // Appends to an existing table. The room must outlive this object. Throws Error if the directory
  // cannot be created or written.
  TruthRecorder(const VirtualRoom* room, PanoramaSize size, std::filesystem::path directory);

  // Writes true views at `count` viewpoints chosen by the room's seed.
  void write_views(int count);
  // Appends one row and flushes it. Throws Error if it cannot be written.
  void record(const std::string& picture, const std::string& line, const CameraPose& pose);
  void write_distances(const std::string& picture, const CameraPose& pose);

 private:
  const VirtualRoom* room_;
  PanoramaSize size_;
  std::filesystem::path directory_;
  std::ofstream poses_;
};

}  // namespace raywalk::capture
