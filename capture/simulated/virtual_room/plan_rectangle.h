// Rectangles in the floor plan, which furniture stands on.
#pragma once

#include <Eigen/Core>

namespace raywalk::capture {

// Room units; coordinates are (x, z). Its own axes are turned by yaw as Attitude::yaw_rad turns.
struct PlanRectangle {
  Eigen::Vector2d centre{0, 0};
  Eigen::Vector2d half_size{0.5, 0.5};
  double yaw_rad = 0.0;
};

bool overlap(const PlanRectangle& a, const PlanRectangle& b);

// Whether `inner` lies within the upright rectangle between two corners.
bool inside(const PlanRectangle& inner, const Eigen::Vector2d& min, const Eigen::Vector2d& max);

}  // namespace raywalk::capture
