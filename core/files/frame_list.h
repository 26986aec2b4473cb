// The frame list (poses.csv): which panorama was captured where, and with which attitude.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {

struct Frame {
  std::string file;            // as the list names it, relative to the list
  std::filesystem::path path;  // where it lies
  Eigen::Vector3d position_m{0, 0, 0};
  std::optional<Attitude> attitude;           // none: the panorama is in world axes already
  std::optional<std::filesystem::path> mask;  // where the frame's mask lies; none: all is valid
  std::string where;                          // "poses.csv:12", for errors
};

// Reads columns file,x,y,z (metres) and, where given, yaw,pitch,roll (degrees; a missing column is
// 0) and mask (relative to the list; may be empty): an 8-bit grey picture of the frame's size in
// the frame's own axes, 0 = not to be used. Throws Error naming list and line: no frames, a number
// that is none or out of range, a file listed twice.
std::vector<Frame> read_frame_list(const std::filesystem::path& list);

}  // namespace raywalk
