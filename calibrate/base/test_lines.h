// For tests: captures of straight lines of stations, without pictures, and the error of their
// poses.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// Adds a line of `stations` from -length / 2 to length / 2 at `across_m`.
inline void add_test_line(CaptureSet* set, const std::string& id, LineAxis axis, double across_m,
                          double length_m, int stations) {
  CaptureLine line{.id = id, .axis = axis, .across_m = across_m};
  for (int i = 0; i < stations; ++i) {
    const double along_m =
        length_m * (stations == 1 ? 0.0 : static_cast<double>(i) / (stations - 1) - 0.5);
    CaptureFrame frame;
    frame.name = id + "_" + std::to_string(i);
    frame.file = frame.name + ".png";
    frame.line = static_cast<int>(set->lines.size());
    frame.nominal_m = axis == LineAxis::kX ? Eigen::Vector3d(along_m, 0, across_m)
                                           : Eigen::Vector3d(across_m, 0, along_m);
    line.frames.push_back(static_cast<int>(set->frames.size()));
    set->frames.push_back(frame);
  }
  set->lines.push_back(line);
}

// x0, x1, z0, z1 around a cell of side 1 m times `scale`, that reach a quarter beyond its corners.
inline CaptureSet test_grid(int stations, double scale = 1.0) {
  CaptureSet set;
  set.source = "test";
  set.frame = {512, 256};
  add_test_line(&set, "x0", LineAxis::kX, -0.5 * scale, 1.5 * scale, stations);
  add_test_line(&set, "x1", LineAxis::kX, 0.5 * scale, 1.5 * scale, stations);
  add_test_line(&set, "z0", LineAxis::kZ, -0.5 * scale, 1.5 * scale, stations);
  add_test_line(&set, "z1", LineAxis::kZ, 0.5 * scale, 1.5 * scale, stations);
  return set;
}

inline CaptureSet test_line(int stations, double length_m = 1.5) {
  CaptureSet set;
  set.source = "test";
  set.frame = {512, 256};
  add_test_line(&set, "x0", LineAxis::kX, 0.0, length_m, stations);
  return set;
}

// The largest differences of two sets of poses.
struct PoseDifference {
  double position_m = 0.0;
  double rotation_rad = 0.0;
};

inline PoseDifference largest_difference(const FramePoses& a, const FramePoses& b) {
  PoseDifference largest;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!a[i] || !b[i]) continue;
    largest.position_m = std::max(largest.position_m, (a[i]->position_m - b[i]->position_m).norm());
    largest.rotation_rad = std::max(
        largest.rotation_rad, angle_between(a[i]->world_from_camera, b[i]->world_from_camera));
  }
  return largest;
}

}  // namespace raywalk::calibrate
