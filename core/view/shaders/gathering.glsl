// Pass 1 on a graphics card (core/view/distance_view.h), shared with the page of exported rooms:
// where a point of a map is drawn (DRAW), what a pixel sees when the cracks between points are
// closed and the maps looked up (REFINE), and what fills pixels that no map sees (FILL).

#ifdef DRAW
// A point of a map (core/view/map_points.h) in the view's distances.
struct DrawnPoint {
  int column, row;
  int across, down;  // pixels that it covers on either side of its own
  float inverse;     // its inverse distance from the eye; negative: no eye sees it
};

// Pixels that a point covers beside its own, if `half_px` lie from its middle to its end: what is
// closed afterwards need not be drawn.
int covered(float half_px, float most) { return half_px < 1.5 ? 0 : int(min(half_px, most)); }

// The point at inverse distance w from the map's station; `half_px` as if seen from there.
DrawnPoint point_seen(MapPlace map, float u_in_map, vec2 latitude, float w, float half_px) {
  DrawnPoint point = DrawnPoint(0, 0, 0, 0, -1.0);
  if (w < 0.0) return point;
  vec3 from_eye = in_column(map.from_centre.xyz, theta_of(u_in_map, map.width));
  float ahead = latitude.y + w * from_eye.x, aside = w * from_eye.y;
  float up = latitude.x + w * from_eye.z, radius = w * eye_radius_m;
  // Seen from a circle of eyes the ray touches it (core/geometry/eye_circle.h).
  float leg = ahead * ahead + aside * aside - radius * radius;
  if (leg < 0.0) return point;  // what is inside the circle no eye sees
  float plan = sqrt(leg);
  float turn = arc_tangent(aside * plan + ahead * radius, ahead * plan - aside * radius);
  float nearing = sqrt(plan * plan + up * up) + 1e-30;
  int width = distance_size.x, rows = distance_size.y;
  float u = (u_in_map + 0.5) * float(width) / float(map.width) + turn * float(width) / (2.0 * kPi);
  float v = (0.5 * kPi - arc_tangent(up, plan)) / kPi * float(rows);
  point.column = (int(floor(u)) + width) % width;
  point.row = clamp(int(v), 0, rows - 1);
  point.across = covered(half_px * latitude.y / (plan + 1e-6), float(width) / 16.0);
  point.down = covered(half_px / nearing, 8.0);
  point.inverse = w / nearing;
  return point;
}
#endif

#ifdef REFINE
// 0 where nothing was drawn, else 1 + the bits of an inverse distance, which are in its order.
uint drawn_at(int column, int row);

// The nearest surface drawn, after closing 3 x 3; negative where nothing is.
float closed(int column, int row) {
  int width = distance_size.x, rows = distance_size.y;
  uint around[25];
  for (int i = 0; i < 25; ++i) {
    int beside = row + i % 5 - 2;
    bool inside = beside >= 0 && beside < rows;
    around[i] = inside ? drawn_at((column + i / 5 - 2 + width) % width, beside) : 0u;
  }
  uint least = 0xffffffffu;
  for (int i = 1; i < 4; ++i) {
    for (int j = 1; j < 4; ++j) {
      if (row + j - 2 < 0 || row + j - 2 >= rows) continue;
      uint most = 0u;
      for (int k = 0; k < 9; ++k) most = max(most, around[5 * (i - 1 + k / 3) + j - 1 + k % 3]);
      least = min(least, most);
    }
  }
  return least == 0u ? -1.0 : uintBitsToFloat(least - 1u);
}

// What the first map that agrees holds where the middle of a pixel sees what was drawn there;
// negative where nothing was.
float refined_inverse(int column, int row) {
  float w = closed(column, row), theta = theta_of(float(column), distance_size.x);
  vec2 latitude = latitude_of(float(row), distance_size.y);
  for (int i = 0; i < gathered && w >= 0.0; ++i) {
    vec2 held = look_up_point(map_places[i], theta, latitude, w);
    if (held.x >= 0.0) return held.x;
  }
  return w;
}
#endif

#ifdef FILL
float refined_at(int column, int row);

// A pixel's inverse distance: unseen, the farther of the surfaces above and below.
float filled_inverse(int column, int row) {
  int above = row, below = row;
  while (above >= 0 && refined_at(column, above) < 0.0) --above;
  if (above == row) return refined_at(column, row);
  while (below < distance_size.y && refined_at(column, below) < 0.0) ++below;
  if (above < 0 && below == distance_size.y) return 0.0;
  if (above < 0) return refined_at(column, below);
  if (below == distance_size.y) return refined_at(column, above);
  return min(refined_at(column, above), refined_at(column, below));
}
#endif
