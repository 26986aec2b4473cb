// Checks that the pictures move as the rail does: they are not mirrored, the camera is not the
// other way round, and front and back are not swapped. A fit to such pictures would fail without
// naming the cause.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace raywalk::calibrate {

// A scene point seen from two stations; unit directions in axes that are parallel by the plan.
struct BearingPair {
  Eigen::Vector3d before{0, 0, 1};
  Eigen::Vector3d after{0, 0, 1};
};

// The camera's direction of motion, estimated from the matches: unit, in their axes. nullopt if too
// few agree. Robust to wrong matches and to a common rotation by a few degrees.
std::optional<Eigen::Vector3d> motion_direction(const std::vector<BearingPair>& seen);

// The planned and the estimated direction of a motion along the rail.
struct MotionComparison {
  Eigen::Vector3d planned{1, 0, 0};  // unit, by the plan
  Eigen::Vector3d seen{1, 0, 0};     // unit, in the same axes
};

// Throws Error that names the likely cause and its remedy, unless all motions are within 45 degrees
// of the plan.
void require_motion_as_planned(const std::vector<MotionComparison>& motions);

}  // namespace raywalk::calibrate
