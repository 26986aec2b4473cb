// Whether the pictures move as the rail did: that they are not mirrored, the camera not the other
// way round, and front and back not swapped. A fit to such pictures would fail with no word of why.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace raywalk::calibrate {

// The same thing seen from two stations; unit directions in axes that the plan has parallel.
struct SeenTwice {
  Eigen::Vector3d before{0, 0, 1};
  Eigen::Vector3d after{0, 0, 1};
};

// The direction in which the camera went, by what was seen: unit, in the axes of the directions.
// None where too few agree on any. Wrong matches and a common turn by a few degrees are survived.
std::optional<Eigen::Vector3d> motion_seen(const std::vector<SeenTwice>& seen);

// A motion of the camera along the rail.
struct MotionSeen {
  Eigen::Vector3d planned{1, 0, 0};  // unit, by the plan
  Eigen::Vector3d seen{1, 0, 0};     // unit, in the same axes
};

// Throws Error that tells what the pictures show instead and what to do; nothing where all motions
// are seen within 45 degrees of the plan.
void require_motion_as_planned(const std::vector<MotionSeen>& motions);

}  // namespace raywalk::calibrate
