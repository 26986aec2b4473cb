// Measures at every intersection of two lines by how much they disagree, from scene points that
// were held out of the adjustment.
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

// Holds out half of the points that both lines of an intersection see from within half a cell of
// it. A sphere about the intersection is a checkerboard of patches of about 11 degrees, of which
// the black ones are held out: both halves cover all directions.
DividedPoints divide_points(const CaptureSet& set, std::span<const LineIntersection> intersections,
                            const SeenPoints& points);

struct IntersectionCheck {
  LineIntersection intersection{};
  int points = 0;  // held out, seen from both lines near the intersection
  // The rigid motion of the line along x, relative to the one along z, that these points ask for:
  // metres, and a rotation vector in radians about the intersection's stations, world axes. Zero is
  // agreement. Its covariance includes the poses' own sigmas there.
  Eigen::Vector3d motion_m{0, 0, 0};
  Eigen::Vector3d rotation_rad{0, 0, 0};
  Matrix6 covariance = Matrix6::Zero();  // of motion, then rotation
};

// One for each intersection, at adjusted poses with sigmas; `noise_px` is that of the adjustment.
// Points outside of `poses` are ignored. An intersection with fewer than kLeastCheckPoints points
// is not measured.
inline constexpr int kLeastCheckPoints = 15;
std::vector<IntersectionCheck> check_intersections(const CaptureSet& set,
                                                   std::span<const LineIntersection> intersections,
                                                   const FramePoses& poses, double noise_px,
                                                   const SeenPoints& held_out);

// Why the lines cannot be trusted to agree at the intersection, each a sentence; empty if they
// agree within their standard deviations, or within half a pixel and a fiftieth of `spacing_m`.
std::vector<std::string> intersection_faults(const CaptureSet& set, const IntersectionCheck& check,
                                             double spacing_m);

}  // namespace raywalk::calibrate
