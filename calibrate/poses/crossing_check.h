// Measures at every crossing of two lines by how much they disagree, from scene points that were
// held out of the adjustment.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/poses/point_evidence.h"
#include "calibrate/poses/refine_poses.h"
#include "calibrate/poses/seen_points.h"

namespace raywalk::calibrate {

// The scene points of a triangulation in two parts.
struct DividedPoints {
  SeenPoints used{};
  SeenPoints held_out{};
};

// Holds out half of the points that both lines of a crossing see from within half a cell of it. A
// sphere about the crossing is a checkerboard of patches of about 11 degrees, of which the black
// ones are held out: both halves cover all directions.
DividedPoints divide_points(const CaptureSet& set, std::span<const LineCrossing> crossings,
                            const SeenPoints& points);

struct CrossingCheck {
  LineCrossing crossing{};
  int points = 0;  // held out, seen from both lines near the crossing
  // The rigid motion of the line along x, relative to the one along z, that these points ask for:
  // metres, and a rotation vector in radians about the crossing's stations, world axes. Zero is
  // agreement. Its covariance includes the poses' own sigmas there.
  Eigen::Vector3d motion_m{0, 0, 0};
  Eigen::Vector3d rotation_rad{0, 0, 0};
  Matrix6 covariance = Matrix6::Zero();  // of motion, then rotation
};

// One for each crossing, at adjusted poses with sigmas; `noise_px` is that of the adjustment.
// Points outside of `poses` are ignored. A crossing with fewer than kLeastCheckPoints points is not
// measured.
inline constexpr int kLeastCheckPoints = 15;
std::vector<CrossingCheck> check_crossings(const CaptureSet& set,
                                           std::span<const LineCrossing> crossings,
                                           const FramePoses& poses, double noise_px,
                                           const SeenPoints& held_out);

// Why the lines cannot be trusted to agree at the crossing, each a sentence; empty if they agree
// within their standard deviations, or within half a pixel and a fiftieth of `spacing_m`.
std::vector<std::string> crossing_faults(const CaptureSet& set, const CrossingCheck& check,
                                         double spacing_m);

}  // namespace raywalk::calibrate
