// Position and attitude of a simulated camera.
#pragma once

#include <Eigen/Core>

#include "core/geometry/sphere.h"

namespace raywalk::capture {

// World frame (core/geometry/sphere.h), metres.
struct CameraPose {
  Eigen::Vector3d position_m{0, 0, 0};
  Attitude attitude{};
};

}  // namespace raywalk::capture
