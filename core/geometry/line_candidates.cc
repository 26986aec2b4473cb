#include "core/geometry/line_candidates.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/plan_line.h"
#include "core/geometry/position_tolerance.h"
#include "core/geometry/sphere.h"

namespace raywalk {

std::vector<int> most_near_lines(const Eigen::Vector2d& seed,
                                 const std::vector<Eigen::Vector2d>& points, LineAxis axis,
                                 double limit_m) {
  constexpr double kAngleRounding = 1e-9;
  const int u_index = along_index(axis);
  std::vector<double> angles, begins, ends;
  int everywhere = 0;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d from_seed = point - seed;
    const double u = from_seed[u_index], v = from_seed[1 - u_index];
    const double angle = std::atan2(std::copysign(1.0, u) * v, std::abs(u));
    angles.push_back(angle);
    const double reach_m = limit_m + rounding_m(point.norm() + seed.norm());
    if (reach_m >= from_seed.norm()) {
      ++everywhere;
      continue;
    }
    const double half = std::asin(reach_m / from_seed.norm()) + kAngleRounding;
    const auto add = [&](double turn) {
      begins.push_back(angle - half + turn);
      ends.push_back(angle + half + turn);
    };
    add(0.0);
    if (angle + half > kHalfPi) add(-kPi);
    if (angle - half < -kHalfPi) add(kPi);
  }
  std::sort(begins.begin(), begins.end());
  std::sort(ends.begin(), ends.end());
  std::vector<int> bounds;
  bounds.reserve(angles.size());
  for (const double angle : angles) {
    const auto begun = std::upper_bound(begins.begin(), begins.end(), angle) - begins.begin();
    const auto ended = std::lower_bound(ends.begin(), ends.end(), angle) - ends.begin();
    bounds.push_back(everywhere + static_cast<int>(begun - ended));
  }
  return bounds;
}

}  // namespace raywalk
