// What distance maps hold of a point (core/view/map_lookup.h). The engine and the page of exported
// rooms share this file; each has before it a struct MapPlace with the map's size in pixels and
//   vec4 from_centre;  // of its station, from the view's centre, metres
// and float held_in(MapPlace map, int column, int row), the inverse distance that the map stores.

float column_in(MapPlace map, float theta, float turn) {
  return (theta + turn + kPi) / (2.0 * kPi) * float(map.width) - 0.5;
}
float row_in(MapPlace map, float phi) {
  return (0.5 * kPi - phi) / kPi * float(map.rows) - 0.5;
}

// Whether neighbours in an image of inverse distances are on different surfaces.
bool is_step(float a, float b) { return abs(a - b) > tolerance * max(a, b); }

// The four pixels around a place in a map: upper left, lower left, upper right, lower right. And
// their parts by bilinear weight.
vec4 held_around(MapPlace map, float u, float v) {
  int left = (int(floor(u)) + 2 * map.width) % map.width, right = (left + 1) % map.width;
  int upper = max(int(floor(v)), 0), lower = min(int(floor(v)) + 1, map.rows - 1);
  return vec4(held_in(map, left, upper), held_in(map, left, lower),
              held_in(map, right, upper), held_in(map, right, lower));
}
vec4 parts_around(float u, float v) {
  float x = u - floor(u), y = v - floor(v);
  return vec4((1.0 - x) * (1.0 - y), (1.0 - x) * y, x * (1.0 - y), x * y);
}
// 1 for those that agree with an inverse distance.
vec4 agreeing(vec4 held, float w) { return step(abs(held - w), vec4(tolerance * w)); }
float largest(vec4 held) { return max(max(held.x, held.y), max(held.z, held.w)); }

// The inverse distance from the eye of the surface that a map holds at the point at inverse
// distance w, negative where it does not agree; and the part of the four pixels around that do.
vec2 look_up_point(MapPlace map, float theta, vec2 latitude, float w) {
  Seen seen = seen_from(to_eye_from(map.from_centre.xyz, theta), latitude, w);
  float u = column_in(map, theta, seen.turn), v = row_in(map, seen.phi);
  vec4 held = held_around(map, u, v);
  vec4 part = parts_around(u, v) * agreeing(held, seen.inverse);
  float total = dot(part, vec4(1.0));
  if (total <= 0.01) return vec2(-1.0, 0.0);
  return vec2(dot(part, held) / total * seen.nearing, total);
}

// What a map holds in a point's direction, and the largest of the four pixels around; negative
// where unknown (look_up() in core/view/map_choice.h).
vec2 look_up(MapPlace map, float theta, Seen seen) {
  float u = column_in(map, theta, seen.turn);
  float v = clamp(row_in(map, seen.phi), 0.0, float(map.rows - 1));
  vec4 held = held_around(map, u, v), part = parts_around(u, v);
  vec4 agrees = part * agreeing(held, seen.inverse);
  float total = dot(agrees, vec4(1.0)), best = -1.0, nearest = -1.0;
  if (total > 0.01) return vec2(dot(agrees, held) / total, largest(held));
  for (int i = 0; i < 4; ++i) {
    if (held[i] < 0.0 || part[i] <= best) continue;
    best = part[i];
    nearest = held[i];
  }
  return vec2(nearest, largest(held));
}

const float kClearlyNearerPx = 2.0;  // as in core/view/visibility.cc

// Whether one of the four pixels around a point holds a surface that is clearly nearer: so that
// the two move by that much against each other on the way to the eye.
bool hides(MapPlace map, float theta, vec2 latitude, float w) {
  vec3 to_eye = to_eye_from(map.from_centre.xyz, theta);
  Seen seen = seen_from(to_eye, latitude, w);
  float held = largest(held_around(map, column_in(map, theta, seen.turn), row_in(map, seen.phi)));
  float slack = kClearlyNearerPx * 2.0 * kPi / float(map.width) / max(1e-9, length(to_eye));
  return held > seen.inverse * (1.0 + tolerance) + slack;
}
