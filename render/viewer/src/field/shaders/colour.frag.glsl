// The colours of a panorama around the viewpoint, as the engine finds them (core/view/shaders): a
// pixel's point is looked up in the stations around where its ray crosses the lines in front and
// behind, unless their maps show something clearly nearer there.

uniform usampler2D distances;        // bits of inverse distances
uniform usampler2D quarters;         // of each quarter at an edge its surface; 0: no edge
uniform sampler2D plan;              // [source][column]: layers of two stations, share of the
                                     // second, share of the line; a share of 0: no line
uniform sampler2D stations;          // [fact][layer]: position and picture (0 none, 1 coarse,
                                     // 2 fine); whether distances are there
uniform sampler2DArray pictures;     // fine
uniform sampler2DArray coarse_pictures;
uniform vec3 viewpoint;
uniform ivec2 output_size;
uniform bool corrected;              // by distances; else the vertical cut
uniform int sources;                 // rows of the plan that are read
uniform int fill_layers[MAX_FILL];   // stations for what no line sees, nearest first
uniform int fill_count;
uniform mat3 world_from_camera;      // from right, up, backwards
uniform vec4 projection;             // focal lengths x, y and shifts x, y of clip coordinates

out vec4 colour;

const vec3 kNothing = vec3(0.25);  // where no station shows anything

float inverse_at(int column, int row) {
  return uintBitsToFloat(texelFetch(distances, ivec2(column, row), 0).r);
}

MapPlace station_of(int layer) {
  vec3 position = texelFetch(stations, ivec2(layer, 0), 0).xyz;
  return MapPlace(vec4(position - viewpoint, 0.0), layer, distance_size.x, distance_size.y);
}

vec3 picture_at(int layer, float theta, float phi) {
  vec3 at = vec3(theta / (2.0 * kPi) + 0.5, 0.5 - phi / kPi, float(layer));
  bool is_fine = texelFetch(stations, ivec2(layer, 0), 0).w > 1.5;
  return is_fine ? texture(pictures, at).rgb : texture(coarse_pictures, at).rgb;
}

// A point that a column shows.
struct Point {
  float theta;
  vec2 latitude;
  float inverse;
};
Point point_in(ivec2 at) {  // a pixel of the distances
  return Point(theta_of(float(at.x), distance_size.x),
               latitude_of(float(at.y), distance_size.y), inverse_at(at.x, at.y));
}

Seen seen_by(MapPlace station, Point point) {
  vec3 to_eye = to_eye_from(station.from_centre.xyz, point.theta);
  return seen_from(to_eye, point.latitude, point.inverse);
}

bool is_hidden(MapPlace station, Point point) {
  return corrected && texelFetch(stations, ivec2(station.layer, 1), 0).x > 0.5 &&
      hides(station, point.theta, point.latitude, point.inverse);
}

// What the lines of a column show.
struct Mixed {
  vec4 seen;     // by the stations that see the point: colours times shares, and the shares
  vec4 unseen;   // by the others
  bool is_seen;  // by the nearest station of a line
};

// `judged`: what stations must see to show the point.
Mixed mix_lines(int column, Point point, Point judged) {
  Mixed mixed = Mixed(vec4(0.0), vec4(0.0), false);
  for (int row = 0; row < sources; ++row) {
    vec4 line = texelFetch(plan, ivec2(column, row), 0);
    if (line.w <= 0.0) continue;
    for (int which = 0; which < 2; ++which) {
      float part = which == 0 ? 1.0 - line.z : line.z;
      if (part <= 0.0) continue;
      MapPlace station = station_of(int(which == 0 ? line.x : line.y));
      Seen seen = seen_by(station, point);
      vec3 shown = picture_at(station.layer, point.theta + seen.turn, seen.phi);
      if (is_hidden(station, judged)) {
        mixed.unseen += line.w * part * vec4(shown, 1.0);
        continue;
      }
      mixed.seen += line.w * part * vec4(shown, 1.0);
      mixed.is_seen = mixed.is_seen || part >= 0.5;
    }
  }
  return mixed;
}

// A point that no line sees, from the first station that does: best away from nearer surfaces.
vec3 filled(Point point, Mixed mixed) {
  int just_sees = -1;
  for (int i = 0; i < fill_count; ++i) {
    MapPlace station = station_of(fill_layers[i]);
    Seen seen = seen_by(station, point);
    vec2 held = look_up(station, point.theta, seen);
    float occludes = seen.inverse * (1.0 + tolerance);
    if (held.x < 0.0 || held.x > occludes) continue;
    if (just_sees < 0 || held.y <= occludes) just_sees = station.layer;
    if (held.y <= occludes) break;
  }
  if (just_sees >= 0) {
    Seen seen = seen_by(station_of(just_sees), point);
    return picture_at(just_sees, point.theta + seen.turn, seen.phi);
  }
  vec4 all = mixed.seen + mixed.unseen;
  return all.a > 0.0 ? all.rgb / all.a : kNothing;
}

// The inverse distance of a place beside the middle of a pixel, on the same surface.
float inverse_between(ivec2 at, vec2 beside) {
  ivec2 other = ivec2((at.x + (beside.x < 0.0 ? -1 : 1) + distance_size.x) % distance_size.x,
                      clamp(at.y + (beside.y < 0.0 ? -1 : 1), 0, distance_size.y - 1));
  float w = inverse_at(at.x, at.y);
  vec2 change = vec2(inverse_at(other.x, at.y), inverse_at(at.x, other.y)) - w;
  if (is_step(w, w + change.x)) change.x = 0.0;
  if (is_step(w, w + change.y)) change.y = 0.0;
  return w + dot(abs(beside), change);
}

// A quarter of a pixel of the distances, seen `offset` of an output pixel from the middle of one.
vec4 quarter_colour(int column, ivec2 at, int quarter, vec2 pixel) {
  Surface surface = unpacked_surface(texelFetch(quarters, at, 0)[quarter]);
  ivec2 around = at + ivec2(int(surface.around & 3u), int(surface.around >> 2)) - 1;
  around.x = (around.x + distance_size.x) % distance_size.x;
  around.y = clamp(around.y, 0, distance_size.y - 1);
  Point point = Point(theta_of(pixel.x, output_size.x), latitude_of(pixel.y, output_size.y),
                      surface.inverse);
  vec4 seen = mix_lines(column, point, point_in(around)).seen;
  return seen.a > 1e-6 ? vec4(seen.rgb / seen.a, 1.0) : vec4(0.0);
}

// At an edge a pixel is the mean of this and of its quarters: of all four where the panorama is
// about as fine as the distances, else of the one that it lies in.
vec3 with_edge(int column, ivec2 at, vec2 beside, vec2 pixel, vec3 middle) {
  vec4 sum = vec4(0.0);
  if (2 * output_size.y < 3 * distance_size.y) {
    for (int quarter = 0; quarter < 4; ++quarter) {
      sum += quarter_colour(column, at, quarter, pixel + quarter_offset(quarter));
    }
  } else {
    int quarter = (beside.x < 0.0 ? 0 : 2) + (beside.y < 0.0 ? 0 : 1);
    sum = quarter_colour(column, at, quarter, pixel);
  }
  return sum.a == 0.0 ? middle : 0.5 * (middle + sum.rgb / sum.a);
}

// Whether the camera shows a direction, or what is up to two pixels beside it.
bool is_shown(vec3 direction) {
  vec3 seen = direction * world_from_camera;  // by the transpose, its inverse
  vec2 clip = projection.xy * seen.xy + projection.zw * seen.z;
  vec2 pixels = 4.0 * kPi / float(output_size.x) * projection.xy / max(-seen.z, 0.05);
  return seen.z < 0.0 && all(lessThan(abs(clip), -seen.z + pixels));
}

void main() {
  vec2 pixel = gl_FragCoord.xy - 0.5;
  float theta = theta_of(pixel.x, output_size.x);
  vec2 latitude = latitude_of(pixel.y, output_size.y);
  if (!is_shown(vec3(latitude.y * sin(theta), latitude.x, latitude.y * cos(theta)))) discard;
  int column = int(gl_FragCoord.x) * textureSize(plan, 0).x / output_size.x;
  vec2 in_distances = gl_FragCoord.xy * vec2(distance_size) / vec2(output_size) - 0.5;
  ivec2 at = clamp(ivec2(floor(in_distances + 0.5)), ivec2(0), distance_size - 1);
  vec2 beside = in_distances - vec2(at);
  // A vertical cut shows what is infinitely far.
  Point point = Point(theta, latitude, corrected ? inverse_between(at, beside) : 0.0);
  Mixed mixed = mix_lines(column, point, point_in(at));
  vec3 shown = mixed.is_seen ? mixed.seen.rgb / mixed.seen.a : filled(point, mixed);
  bool is_at_edge = corrected && texelFetch(quarters, at, 0).x != 0u;
  colour = vec4(is_at_edge ? with_edge(column, at, beside, pixel, shown) : shown, 1.0);
}
