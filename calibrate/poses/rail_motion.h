// Checks that the panoramas move as their positions say. If they do not, pictures are mirrored,
// upside down or turned, the axes of the list are not those of the pictures, or a rail was laid the
// other way round; bundle adjustment cannot recover from that.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"

namespace raywalk::calibrate {

// A scene point matched in two panoramas: unit vectors in each camera's frame.
struct BearingMatch {
  Eigen::Vector3d in_first{0, 0, 1};
  Eigen::Vector3d in_second{0, 0, 1};
};

// How bearings moved from one station to another, against the positions of the two.
struct PairMotion {
  // Evidence in standard deviations that they moved as the positions predict: positive if against
  // the camera's motion, as static points do, negative if with it. Near 0 where the matches do not
  // determine it, as those of distant points.
  double along = 0.0;
  // The camera's motion by the pictures, a unit vector in world axes; zero where they do not
  // determine it.
  Eigen::Vector3d direction{0, 0, 0};
};
PairMotion pair_motion(const FramePose& first, const FramePose& second,
                       std::span<const BearingMatch> matches);

enum class RailMotion { kUnknown, kAsPlanned, kReversed };

struct LineMotion {
  RailMotion along = RailMotion::kUnknown;
  Eigen::Vector3d direction{0, 0, 0};  // mean, from the first towards the last station; or zero
};

// The result for a line, from its pairs of neighbours.
LineMotion line_motion(std::span<const PairMotion> pairs);

// What all lines along an axis have in common that move otherwise than listed: the likely cause and
// its remedy. Empty if all are as planned or unknown, or if a single line differs from others.
std::string common_fault(const CaptureSet& set, std::span<const LineMotion> motions);

}  // namespace raywalk::calibrate
