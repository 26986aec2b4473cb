#include "core/view/connection.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"

namespace raywalk {

SharedAngles shared_angles(const CornerView& corner) {
  const double a = corner.to_next_side_m;
  const double b = corner.to_this_side_m;
  // At angle g this side's line is read b tan g - a beyond the corner, the next one a / tan g - b.
  // A viewpoint on the corner itself (a = b = 0) reads both lines at the corner at every angle.
  if (a == 0.0 && b == 0.0) return {0.0, kHalfPi};
  return {std::atan2(a, b + corner.overhang_next_m), std::atan2(a + corner.overhang_this_m, b)};
}

double hybrid_cut(const CornerView& corner, double k_rad) {
  const double c = std::atan2(corner.to_next_side_m, corner.to_this_side_m);
  return std::clamp(c, kHalfPi - k_rad, k_rad);
}

CornerConnection connect_corner(const CornerView& corner, const ConnectionRule& rule) {
  CornerConnection connection;
  connection.corner_rad = std::atan2(corner.to_next_side_m, corner.to_this_side_m);
  const double wanted = hybrid_cut(corner, rule.k_rad);
  const SharedAngles shared = shared_angles(corner);
  connection.cut_rad = std::clamp(wanted, shared.begin_rad, shared.end_rad);
  connection.limited = connection.cut_rad != wanted;
  const double half = 0.5 * rule.overlap_rad;
  connection.blend_begin_rad = std::max(connection.cut_rad - half, shared.begin_rad);
  connection.blend_end_rad = std::min(connection.cut_rad + half, shared.end_rad);
  return connection;
}

double next_side_weight(const CornerConnection& connection, double angle_rad) {
  if (angle_rad <= connection.blend_begin_rad) return 0.0;
  if (angle_rad >= connection.blend_end_rad) return 1.0;
  return (angle_rad - connection.blend_begin_rad) /
         (connection.blend_end_rad - connection.blend_begin_rad);
}

}  // namespace raywalk
