// Pass 1 in three programs: DRAW draws the points of one map, REFINE closes the cracks between them
// and reads the maps, FILL fills what no map sees (gathering.glsl).

layout(local_size_x = 8, local_size_y = 8) in;

// As drawn_at() and refined_at() return them.
layout(std430, binding = 2) buffer Drawn { uint drawn[]; };
layout(std430, binding = 3) buffer Refined { float refined[]; };  // 1/m, negative where unseen

#ifdef DRAW
uniform int drawn_map;

void draw(MapPlace map, float u_in_map, vec2 latitude, float w, float half_px) {
  DrawnPoint point = point_seen(map, u_in_map, latitude, w, half_px);
  if (point.inverse < 0.0) return;
  int width = distance_size.x, rows = distance_size.y;
  uint word = floatBitsToUint(point.inverse) + 1u;
  for (int i = point.column - point.across; i <= point.column + point.across; ++i) {
    int last = min(point.row + point.down, rows - 1);
    for (int j = max(point.row - point.down, 0); j <= last; ++j) {
      atomicMax(drawn[(i + width) % width * rows + j], word);
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
uint drawn_at(int column, int row) { return drawn[column * distance_size.y + row]; }

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);  // x: row, y: column
  if (at.x >= distance_size.y || at.y >= distance_size.x) return;
  refined[at.y * distance_size.y + at.x] = refined_inverse(at.y, at.x);
}
#endif

#ifdef FILL
uniform bool has_trust;

float refined_at(int column, int row) { return refined[column * distance_size.y + row]; }

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (at.x >= distance_size.y || at.y >= distance_size.x) return;
  int pixel = at.y * distance_size.y + at.x, pixels = distance_size.x * distance_size.y;
  float w = filled_inverse(at.y, at.x);
  if (has_trust) {
    float trust = distances[pixels + pixel], smoothed = distances[2 * pixels + pixel];
    if (trust < 1.0) w = smoothed + (w - smoothed) * trust;
  }
  distances[pixel] = w;
  drawn[pixel] = 0u;  // for the next view
}
#endif
