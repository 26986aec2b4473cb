// For tests: poses of a square of four lines, as another program would give them.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "calibrate/import/grid_axes.h"

namespace raywalk::calibrate {

// Seven stations a quarter of the side apart on each of four lines around a cell of 1 m x 1 m,
// upright but for small angles that differ from frame to frame.
inline std::vector<ImportedFrame> square_frames() {
  std::vector<ImportedFrame> frames;
  for (int i = 0; i < 28; ++i) {
    const double along_m = -0.75 + 0.25 * (i % 7);
    const double across_m = i / 7 == 0 || i / 7 == 2 ? 0.5 : -0.5;
    const bool along_x = i / 7 < 2;
    const Attitude attitude{0.02 * (i % 5 - 2), 0.01 * (i % 3 - 1), 0.008 * (i % 4 - 1.5)};
    frames.push_back({.file = fmt::format("{:02d}.png", i),
                      .pose = {{along_x ? along_m : across_m, 0.0, along_x ? across_m : along_m},
                               world_from_camera(attitude)},
                      .where = fmt::format("test: {}", i)});
  }
  return frames;
}

// The frames in another frame of reference: x_source = (R x_world + t) / scale.
inline std::vector<ImportedFrame> in_other_axes(std::vector<ImportedFrame> frames,
                                                const Eigen::Matrix3d& rotation,
                                                const Eigen::Vector3d& translation, double scale) {
  for (ImportedFrame& frame : frames) {
    frame.pose.position_m = (rotation * frame.pose.position_m + translation) / scale;
    frame.pose.world_from_camera = rotation * frame.pose.world_from_camera;
  }
  return frames;
}

}  // namespace raywalk::calibrate
