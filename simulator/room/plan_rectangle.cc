#include "simulator/room/plan_rectangle.h"

#include <array>
#include <cmath>

namespace raywalk::capture {
namespace {

using Eigen::Vector2d;

// Directions of the rectangle's x and z axes in the plan.
std::array<Vector2d, 2> axes_of(const PlanRectangle& rectangle) {
  const double sine = std::sin(rectangle.yaw_rad), cosine = std::cos(rectangle.yaw_rad);
  return {Vector2d(cosine, -sine), Vector2d(sine, cosine)};
}

// Half the length of the rectangle's projection on `axis`.
double half_projection(const PlanRectangle& rectangle, const Vector2d& axis) {
  const auto own = axes_of(rectangle);
  return rectangle.half_size.x() * std::abs(own[0].dot(axis)) +
         rectangle.half_size.y() * std::abs(own[1].dot(axis));
}

}  // namespace

// Two convex polygons are disjoint if and only if their projections on the normal of some side are
// (separating axis theorem).
bool overlap(const PlanRectangle& a, const PlanRectangle& b) {
  for (const PlanRectangle* side : {&a, &b}) {
    for (const Vector2d& axis : axes_of(*side)) {
      const double gap = std::abs((a.centre - b.centre).dot(axis));
      if (gap > half_projection(a, axis) + half_projection(b, axis)) return false;
    }
  }
  return true;
}

bool inside(const PlanRectangle& inner, const Vector2d& min, const Vector2d& max) {
  const Vector2d half(half_projection(inner, Vector2d::UnitX()),
                      half_projection(inner, Vector2d::UnitY()));
  return ((inner.centre - half).array() >= min.array()).all() &&
         ((inner.centre + half).array() <= max.array()).all();
}

}  // namespace raywalk::capture
