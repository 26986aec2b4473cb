// Rectangular footprints of furniture in the floor plan.
#pragma once

#include <Eigen/Core>

namespace raywalk::capture {

// Room units; coordinates are (x, z). Its axes are rotated by yaw as by Attitude::yaw_rad.
struct PlanRectangle {
  Eigen::Vector2d centre{0, 0};
  Eigen::Vector2d half_size{0.5, 0.5};
  double yaw_rad = 0.0;
};

bool overlap(const PlanRectangle& a, const PlanRectangle& b);

// Whether `inner` lies within the axis-aligned rectangle between two corners.
bool inside(const PlanRectangle& inner, const Eigen::Vector2d& min, const Eigen::Vector2d& max);

}  // namespace raywalk::capture
