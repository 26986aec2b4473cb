// The geometry that all passes on a graphics card share (core/view/column_geometry.h). Images of a
// view, of maps and of stations are indexed [theta][phi].

precision highp float;
precision highp int;
precision highp sampler2DArray;
precision highp usampler2DArray;

uniform ivec2 distance_size;  // of the view's distances
uniform float tolerance;      // surface_tolerance() of them
uniform float eye_radius_m;   // EyeCircle

const float kPi = 3.14159265358979;

float theta_of(float u, int width) { return (u + 0.5) / float(width) * 2.0 * kPi - kPi; }
float phi_of(float v, int rows) { return 0.5 * kPi - (v + 0.5) / float(rows) * kPi; }

// Sine and cosine of a row's latitude.
vec2 latitude_of(float v, int rows) {
  float phi = phi_of(v, rows);
  return vec2(sin(phi), cos(phi));
}

// fast_atan2 (core/geometry/fast_math.h), so that every driver computes the same.
float arc_tangent(float y, float x) {
  float ax = abs(x), ay = abs(y);
  float t = min(ax, ay) / max(max(ax, ay), 1.17549435e-38);
  float t2 = t * t, t4 = t2 * t2;
  float low = (0.999996112 - 0.333173681 * t2) + (0.198078155 - 0.132333417 * t2) * t4;
  float high = (0.0796236641 - 0.0336042128 * t2) + 0.0068117906 * t4;
  float angle = (low + high * t4 * t4) * t;
  angle = ay > ax ? 0.5 * kPi - angle : angle;
  angle = x < 0.0 ? kPi - angle : angle;
  return y < 0.0 ? -angle : angle;
}

// A displacement in the frame of the column in direction theta: ahead, aside and up.
vec3 in_column(vec3 d, float theta) {
  float s = sin(theta), c = cos(theta);
  return vec3(d.x * s + d.z * c, d.x * c - d.z * s, d.y);
}

// From a place to the eye of a column, in the column's frame; the place is `from_centre` away from
// the view's centre.
vec3 to_eye_from(vec3 from_centre, float theta) {
  return in_column(-from_centre, theta) - vec3(0.0, eye_radius_m, 0.0);
}

// The point at inverse distance w in a row of a column, as a place sees it (SeenPoint).
struct Seen {
  float turn, phi;  // to the right of the column, and up
  float inverse;    // its inverse distance from the place
  float nearing;    // its distance from the place by that from the eye
};
Seen seen_from(vec3 to_eye, vec2 latitude, float w) {
  float ahead = latitude.y + w * to_eye.x, aside = w * to_eye.y, up = latitude.x + w * to_eye.z;
  float plan = sqrt(ahead * ahead + aside * aside);
  float nearing = sqrt(plan * plan + up * up) + 1e-30;
  return Seen(arc_tangent(aside, ahead), arc_tangent(up, plan), w / nearing, nearing);
}
