// A viewpoint as it is asked for.
#pragma once

#include <optional>

#include "core/geometry/sphere.h"

namespace raywalk {

// Metres in the world frame, that of poses.csv.
struct Viewpoint {
  Viewpoint() = default;
  Viewpoint(double x_m, double z_m) : plan{x_m, z_m} {}
  // NOLINTNEXTLINE(google-explicit-constructor): most viewpoints are places in the plan
  Viewpoint(PlanPoint place, std::optional<double> y_m = std::nullopt)
      : plan(place), height_m(y_m) {}

  PlanPoint plan{};
  std::optional<double> height_m{};  // y; none: that of the lines around (view_height.h)
};

}  // namespace raywalk
