// The frame list (poses.csv): the position and attitude at which each panorama was captured.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {

struct Frame {
  std::string file;            // as written in the list, relative to the list
  std::filesystem::path path;  // resolved against the list's directory
  Eigen::Vector3d position_m{0, 0, 0};
  std::optional<Attitude> attitude;           // none: the panorama is already in world axes
  std::optional<std::filesystem::path> mask;  // none: all pixels are valid
  std::string where;                          // "poses.csv:12", for errors
};

// Reads columns file,x,y,z (metres) of a file, or of standard input for "-" with names relative to
// the current directory, and, if present, yaw,pitch,roll (degrees; a missing column is
// 0) and mask (relative to the list; may be empty): an 8-bit grey image of the frame's size in the
// frame's own axes, 0 = invalid. Throws Error naming list and line: no frames, a field that is not
// a number or is out of range, a file listed twice.
std::vector<Frame> read_frame_list(const std::filesystem::path& list);
// The same of text read from `list`.
std::vector<Frame> parse_frame_list(const std::string& text, const std::filesystem::path& list);

}  // namespace raywalk
