// Where the eye of each column of a view is.
//
// All columns of a panorama for one eye are seen from one place. In omnidirectional stereo (ODS)
// two eyes turn with the view: the column in plan direction theta is seen from a circle around the
// viewpoint, an eye's distance to the left or to the right of theta, so that each column is a
// picture of its own (Peleg, Ben-Ezra, Pritch: Omnistereo: Panoramic stereo imaging, IEEE
// Transactions on Pattern Analysis and Machine Intelligence 23 (3), 2001). All rays of one eye
// touch the circle, whose radius is half the distance between the eyes.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/sphere.h"

namespace raywalk {

struct EyeCircle {
  Eigen::Vector3d centre_m{0, 0, 0};
  double radius_m = 0.0;  // of the left eye; negative: of the right one; 0: one place for all

  // The eye of the column in plan direction theta.
  Eigen::Vector3d position_m(double theta_rad) const;
  PlanPoint place(double theta_rad) const;

  // The direction in which a point, `from_centre_m` away from the centre, is seen from the eye of
  // that direction's column; none inside the circle. With radius 0 it is the point's own.
  std::optional<SphereAngles> direction_of(const Eigen::Vector3d& from_centre_m) const;

  // The other eye of the view.
  EyeCircle opposite() const { return {centre_m, -radius_m}; }
};

}  // namespace raywalk
