// Pass 1 on a graphics card (core/view/distance_view.h), in three programs: DRAW draws the points
// of one map (core/view/map_points.h), REFINE closes the cracks between them and reads the maps,
// FILL fills what no map sees.

layout(local_size_x = 8, local_size_y = 8) in;

// 0 where nothing was drawn, else 1 + the bits of an inverse distance, which are in its order.
layout(std430, binding = 2) buffer Drawn { uint drawn[]; };
layout(std430, binding = 3) buffer Refined { float refined[]; };  // 1/m, negative where unseen

#ifdef DRAW
uniform int drawn_map;

// Pixels that a point covers beside its own, if `half_px` lie from its middle to its end: what is
// closed afterwards need not be drawn.
int covered(float half_px, float most) { return half_px < 1.5 ? 0 : int(min(half_px, most)); }

void draw(MapPlace map, float u_in_map, vec2 latitude, float w, float half_px) {
  if (w < 0.0) return;
  float theta = theta_of(u_in_map, map.width);
  vec3 from_eye = in_column(map.from_centre.xyz, theta);
  float ahead = latitude.y + w * from_eye.x, aside = w * from_eye.y;
  float up = latitude.x + w * from_eye.z, radius = w * eye_radius_m;
  // Seen from a circle of eyes the ray touches it (core/geometry/eye_circle.h).
  float leg = ahead * ahead + aside * aside - radius * radius;
  if (leg < 0.0) return;  // what is inside the circle no eye sees
  float plan = sqrt(leg);
  float turn = arc_tangent(aside * plan + ahead * radius, ahead * plan - aside * radius);
  float nearing = sqrt(plan * plan + up * up) + 1e-30;
  int width = distance_size.x, rows = distance_size.y;
  float u = (u_in_map + 0.5) * float(width) / float(map.width) + turn * float(width) / (2.0 * kPi);
  float v = (0.5 * kPi - arc_tangent(up, plan)) / kPi * float(rows);
  int x = (int(floor(u)) + width) % width, y = clamp(int(v), 0, rows - 1);
  int across = covered(half_px * latitude.y / (plan + 1e-6), float(width) / 16.0);
  int down = covered(half_px / nearing, 8.0);
  uint inverse = floatBitsToUint(w / nearing) + 1u;
  for (int i = x - across; i <= x + across; ++i) {
    for (int j = max(y - down, 0); j <= min(y + down, rows - 1); ++j) {
      atomicMax(drawn[(i + width) % width * rows + j], inverse);
    }
  }
}

// The mean of 2 x 2 pixels where all 4 x 4 around are on one surface; else negative.
float surface_mean(MapPlace map, ivec2 first) {
  float most = -1.0, least = 3e38, sum = 0.0;
  for (int i = -1; i <= 2; ++i) {
    for (int j = -1; j <= 2; ++j) {
      float held = held_in(map, (first.y + i + map.width) % map.width, first.x + j);
      most = max(most, held);
      least = min(least, held);
      if (i == clamp(i, 0, 1) && j == clamp(j, 0, 1)) sum += held;
    }
  }
  // surface_tolerance_of() the map: that of a surface seen at 80 degrees.
  float of_map = min(0.25, 5.67128182 * 2.0 * kPi / float(map.width));
  return least >= 0.0 && most - least <= of_map * most ? 0.25 * sum : -1.0;
}

// A block of 2 x 2 pixels of the map: x: rows, y: columns.
void main() {
  MapPlace map = map_places[drawn_map];
  ivec2 block = ivec2(gl_GlobalInvocationID.xy), first = 2 * block;
  if (first.x >= map.rows || first.y >= map.width) return;
  float scale = float(distance_size.x) / float(map.width), mean = -1.0;
  bool halves = map.width % 2 == 0 && map.rows % 2 == 0;
  if (halves && block.x > 0 && block.x < map.rows / 2 - 1) mean = surface_mean(map, first);
  if (mean >= 0.0) {
    draw(map, float(first.y) + 0.5, latitude_of(float(block.x), map.rows / 2), mean, scale);
    return;
  }
  for (int u = first.y; u < min(first.y + 2, map.width); ++u) {
    for (int row = first.x; row < min(first.x + 2, map.rows); ++row) {
      draw(map, float(u), latitude_of(float(row), map.rows), held_in(map, u, row), 0.5 * scale);
    }
  }
}
#endif

#ifdef REFINE
// The nearest surface drawn, after closing 3 x 3; negative where nothing is.
float closed(ivec2 at) {
  int width = distance_size.x, rows = distance_size.y;
  uint around[25];
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      int row = at.x + j - 2;
      bool inside = row >= 0 && row < rows;
      around[5 * i + j] = inside ? drawn[(at.y + i - 2 + width) % width * rows + row] : 0u;
    }
  }
  uint least = 0xffffffffu;
  for (int i = 1; i < 4; ++i) {
    for (int j = 1; j < 4; ++j) {
      if (at.x + j - 2 < 0 || at.x + j - 2 >= rows) continue;
      uint most = 0u;
      for (int k = 0; k < 9; ++k) most = max(most, around[5 * (i - 1 + k / 3) + j - 1 + k % 3]);
      least = min(least, most);
    }
  }
  return least == 0u ? -1.0 : uintBitsToFloat(least - 1u);
}

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);  // x: row, y: column
  if (at.x >= distance_size.y || at.y >= distance_size.x) return;
  float w = closed(at), theta = theta_of(float(at.y), distance_size.x);
  vec2 latitude = latitude_of(float(at.x), distance_size.y);
  for (int i = 0; i < gathered && w >= 0.0; ++i) {
    vec2 held = look_up_point(map_places[i], theta, latitude, w);
    if (held.x < 0.0) continue;
    w = held.x;
    break;
  }
  refined[at.y * distance_size.y + at.x] = w;
}
#endif

#ifdef FILL
// Inverse distances, then how far they can be relied on, and smooth ones (SmoothDistances).
layout(std430, binding = 1) buffer Distances { float distances[]; };
uniform bool has_trust;

// The farther of the surfaces above and below an unseen row.
float fill_of(int column, int row) {
  int above = row, below = row;
  while (above >= 0 && refined[column + above] < 0.0) --above;
  while (below < distance_size.y && refined[column + below] < 0.0) ++below;
  if (above < 0 && below == distance_size.y) return 0.0;
  if (above < 0) return refined[column + below];
  if (below == distance_size.y) return refined[column + above];
  return min(refined[column + above], refined[column + below]);
}

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (at.x >= distance_size.y || at.y >= distance_size.x) return;
  int column = at.y * distance_size.y, pixels = distance_size.x * distance_size.y;
  float w = refined[column + at.x];
  if (w < 0.0) w = fill_of(column, at.x);
  if (has_trust) {
    float trust = distances[pixels + column + at.x];
    float smoothed = distances[2 * pixels + column + at.x];
    if (trust < 1.0) w = smoothed + (w - smoothed) * trust;
  }
  distances[column + at.x] = w;
  drawn[column + at.x] = 0u;  // for the next view
}
#endif
