// Distance maps on a graphics card, and what they hold of a point (core/view/map_lookup.h).

struct MapPlace {
  vec4 from_centre;  // of its station, from the view's centre, metres
  int layer, width, rows;
  int masks;                    // layer of `masks`; -1: all of the station may be used
  int moved_width, moved_rows;  // of the panoramas in which what moved is marked; 0: nothing moved
  int unused_0, unused_1;
};
// First those that distances are gathered from, nearest first.
layout(std430, binding = 0) readonly buffer MapPlaces { MapPlace map_places[]; };

uniform int gathered;         // number of maps that distances are gathered from
uniform sampler2DArray maps;  // x: row, y: column; inverse distances, 1/m, negative where unknown

float held_in(MapPlace map, int u, int row) {
  return texelFetch(maps, ivec3(row, u, map.layer), 0).r;
}
float column_in(MapPlace map, float theta, float turn) {
  return (theta + turn + kPi) / (2.0 * kPi) * float(map.width) - 0.5;
}
float row_in(MapPlace map, float phi) {
  return (0.5 * kPi - phi) / kPi * float(map.rows) - 0.5;
}

// The inverse distance from the eye of the surface that a map holds at the point at inverse
// distance w, negative where it does not agree; and the part of the four pixels around that do.
vec2 look_up_point(MapPlace map, float theta, vec2 latitude, float w) {
  Seen seen = seen_from(to_eye_from(map.from_centre.xyz, theta), latitude, w);
  float u = column_in(map, theta, seen.turn), v = row_in(map, seen.phi);
  int left = (int(floor(u)) + 2 * map.width) % map.width, right = (left + 1) % map.width;
  int upper = max(int(floor(v)), 0), lower = min(int(floor(v)) + 1, map.rows - 1);
  vec4 held = vec4(held_in(map, left, upper), held_in(map, left, lower),
                   held_in(map, right, upper), held_in(map, right, lower));
  float x = u - floor(u), y = v - floor(v);
  vec4 part = vec4((1.0 - x) * (1.0 - y), (1.0 - x) * y, x * (1.0 - y), x * y);
  part *= step(abs(held - seen.inverse), vec4(tolerance * seen.inverse));
  float total = dot(part, vec4(1.0));
  if (total <= 0.01) return vec2(-1.0, 0.0);
  return vec2(dot(part, held) / total * seen.nearing, total);
}
