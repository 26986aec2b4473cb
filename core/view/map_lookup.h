// Looks a point up in a distance map: what the map holds where it sees the point.
#pragma once

#include <cmath>

#include "core/view/column_geometry.h"
#include "core/view/map_cache.h"

namespace raywalk {

// A map to look columns of a view up in.
struct ColumnLookup {
  ColumnLookup(const SurfaceMap& map, const Eigen::Vector3d& map_m, const Eigen::Vector3d& eye_m,
               double theta_rad)
      : inverse(map.inverse.data()),
        width(map.size.width),
        rows(map.size.height),
        to_eye(offset_in_column(eye_m - map_m, theta_rad)),
        column(static_cast<float>((theta_rad + kPi) / kTwoPi * map.size.width - 0.5)) {}

  const float* inverse;
  int width, rows;
  Offset to_eye;
  float column;  // of the map, in the plan direction of the view's column
};

struct HeldPoint {
  float inverse;  // from the eye, 1/m, of the surface that the map holds there
  float part;     // of the four pixels around the point, by bilinear weight, that are on it
};

// What a map holds at the point at inverse distance `w` in a row of a column: the mean, by
// bilinear weight, of those of the four pixels around it that agree with the point within
// `tolerance`, relative to it. Without any, or of a negative w, `part` is 0, `inverse` negative.
RAYWALK_INLINE HeldPoint look_up_point(ColumnLookup map, float sin_phi, float cos_phi, float w,
                                       float tolerance) {
  const SeenPoint seen = seen_from(sin_phi, cos_phi, w, map.to_eye);
  const float u =
      map.column + seen.turn_rad * (static_cast<float>(map.width) / static_cast<float>(kTwoPi));
  const float v = (static_cast<float>(kHalfPi) - seen.phi_rad) *
                      (static_cast<float>(map.rows) / static_cast<float>(kPi)) -
                  0.5f;
  int left = static_cast<int>(u + static_cast<float>(map.width));  // neither is negative: floor
  int upper = static_cast<int>(v + 1.0f);
  const float part_u = u + static_cast<float>(map.width) - static_cast<float>(left);
  const float part_v = v + 1.0f - static_cast<float>(upper);
  upper -= 1;
  left -= left >= map.width ? map.width : 0;
  left -= left >= map.width ? map.width : 0;
  int right = left + 1;
  right -= right >= map.width ? map.width : 0;
  const int lower = upper + 1 >= map.rows ? map.rows - 1 : upper + 1;
  upper = upper < 0 ? 0 : upper;
  const float a = map.inverse[left * map.rows + upper], b = map.inverse[left * map.rows + lower];
  const float c = map.inverse[right * map.rows + upper], d = map.inverse[right * map.rows + lower];
  const float expected = w / seen.length, limit = tolerance * expected;
  const float wa = (std::fabs(a - expected) <= limit ? 1.0f : 0.0f) * (1 - part_u) * (1 - part_v);
  const float wb = (std::fabs(b - expected) <= limit ? 1.0f : 0.0f) * (1 - part_u) * part_v;
  const float wc = (std::fabs(c - expected) <= limit ? 1.0f : 0.0f) * part_u * (1 - part_v);
  const float wd = (std::fabs(d - expected) <= limit ? 1.0f : 0.0f) * part_u * part_v;
  const float total = wa + wb + wc + wd;
  const float sum = wa * a + wb * b + wc * c + wd * d;
  const float known = total > 0.01f ? 1.0f : 0.0f;
  // -1 where nothing agrees.
  const float held = (sum + known - 1.0f) / (total * known + 1.0f - known);
  return {held * seen.length, total * known};
}

// The same of `count` points of a column.
void look_up_points(ColumnLookup map, const float* sin_phi, const float* cos_phi,
                    const float* inverse, int count, float tolerance, float* part, float* held);

}  // namespace raywalk
