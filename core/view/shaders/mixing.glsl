// Pass 4 on a graphics card: the samples of the stations, mixed (core/view/station_mixing.h), one
// invocation per pixel. What is said there of weights, edges and fills holds here; names are the
// same. Images of a view and of stations are indexed [theta][phi].
//
// A pixel that needs a search through distance maps is left to the processor (kUndecided).

precision highp float;
precision highp int;
precision highp sampler2DArray;

layout(local_size_x = 8, local_size_y = 8) in;

// What is the same in all rows of an output column (MixedColumn).
struct Column {
  int first_read, reads;
  int nearest, other;  // columns of the distances
  float right;         // how far right of the nearest one
  float captured;      // its place in the stations, W to 2 W
  uint flags;
  uint beside;  // of each source 8 bits: its image in the columns to the left and right of nearest
  vec4 eye_m;   // from the view's centre
  int first_edge, edges;
  int unused_0, unused_1;
};
// kEmpty: no line serves it; kJudged: many samples are judged by each other.
const uint kMasked = 1u, kEmpty = 2u, kHasTrust = 4u, kJudged = 8u;

struct Read {
  vec4 to_eye;  // ahead, aside and up in the column's frame, metres; the share where reliable
  float unreliable, after_part;
  int layer;   // of `stations`
  int source;  // of the column
  int image;   // of `occluded`; -1: nothing is occluded
  uint before, after;
  int unused;
};

struct Edge {
  int row;
  float inverse[4];  // of the quarters: upper left, lower left, upper right, lower right
  uint surface;      // of each quarter 4 bits: 1 + right, 1 + down
};

layout(std430, binding = 0) readonly buffer Columns { Column columns[]; };
layout(std430, binding = 1) readonly buffer Reads { Read reads[]; };
layout(std430, binding = 2) readonly buffer Edges { Edge edges[]; };
// Inverse distances, 1/m, and how far they can be relied on, where columns have kHasTrust.
layout(std430, binding = 3) readonly buffer Distances { float distances[]; };
// Bytes, four images of what is occluded, and the stations to fill from.
layout(std430, binding = 4) readonly buffer Occluded { uint occluded_words[]; };
// bgr, and how the pixel was read in the highest byte.
layout(std430, binding = 5) writeonly buffer Picture { uint picture[]; };

uniform sampler2DArray stations;  // x: row, y: column; rgb, and in a whether it may be used
uniform ivec2 captured;           // width and height of the stations
uniform ivec2 output_size, distance_size;
uniform int first_column, first_row;  // of the output, where the picture begins
uniform ivec4 part;  // of the picture: first column, their number; its width and height
uniform bool is_initial, is_cubic;
uniform float tolerance;    // surface_tolerance() of the distances
uniform vec4 fill_m[64];    // of stations to fill from: position from the view's centre, layer

const float kPi = 3.14159265358979;
const uint kRead = 0u, kFilled = 1u, kUnread = 2u, kUndecided = 3u, kOfNoLine = 4u;
const uint kNoStation = 255u, kReadUnseen = 254u, kOccludedInView = 0x80u;
const int kImages = 4;

float inverse_at(int theta, int row) { return distances[theta * distance_size.y + row]; }
float trust_at(int theta, int row) {
  return distances[distance_size.x * distance_size.y + theta * distance_size.y + row];
}
uint byte_of(int image, int theta, int row) {
  int at = (image * distance_size.x + theta) * distance_size.y + row;
  return occluded_words[at >> 2] >> (8 * (at & 3)) & 255u;
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

// Where a station sees the point at inverse distance w in a direction: pixels to the right of the
// column, and the row.
vec2 place_of(vec3 to_eye, float sin_phi, float cos_phi, float w) {
  float ahead = cos_phi + w * to_eye.x, aside = w * to_eye.y, up = sin_phi + w * to_eye.z;
  float turn = arc_tangent(aside, ahead);
  float phi = arc_tangent(up, sqrt(ahead * ahead + aside * aside));
  return vec2(turn * float(captured.x) / (2.0 * kPi),
              (0.5 * kPi - phi) * float(captured.y) / kPi - 0.5);
}

vec4 catmull_rom(float t) {
  float t2 = t * t, t3 = t2 * t;
  return vec4(-0.5 * t3 + t2 - 0.5 * t, 1.5 * t3 - 2.5 * t2 + 1.0,
              -1.5 * t3 + 2.0 * t2 + 0.5 * t, 0.5 * t3 - 0.5 * t2);
}

// The sample at a place, levels 0 to 1, and the least a of the pixels that it reads.
vec4 sample_station(int layer, float u, float v) {
  float x = u < 0.0 ? u + float(captured.x) : u;
  float y = clamp(v, 0.0, float(captured.y - 1));
  int left = int(x), row = is_cubic ? int(y) : min(int(y), captured.y - 2);
  vec4 across = vec4(0.0, 1.0 - fract(x), fract(x), 0.0);
  vec4 down = vec4(0.0, 1.0 - (y - float(row)), y - float(row), 0.0);
  if (is_cubic) {
    across = catmull_rom(fract(x));
    down = catmull_rom(y - float(row));
  }
  int begin = is_cubic ? 0 : 1, end = is_cubic ? 4 : 3;
  vec3 sum = vec3(0.0);
  float usable = 1.0;
  for (int i = begin; i < end; ++i) {
    int column = (left - 1 + i + captured.x) % captured.x;
    for (int j = begin; j < end; ++j) {
      int at = clamp(row - 1 + j, 0, captured.y - 1);
      vec4 pixel = texelFetch(stations, ivec3(at, column, layer), 0);
      sum += across[i] * down[j] * pixel.rgb;
      usable = min(usable, pixel.a);
    }
  }
  return vec4(sum, usable);
}

// Samples that are mixed: colours times weights, and the weights.
#ifdef KEEP_SAMPLES
// Of many, those count less that contradict the others (mean_of() in sampler.cc).
vec4 kept[72];
int kept_count;
bool are_judged;
#endif
vec4 mixed_sum;

void begin_mixing() {
  mixed_sum = vec4(0.0);
#ifdef KEEP_SAMPLES
  kept_count = 0;
#endif
}

void add_sample(Read read, float weight, vec2 place, float column) {
  vec4 s = sample_station(read.layer, place.x + column, place.y);
  // In an initial view what moved is shown all the same.
  if (s.a < (is_initial ? 0.25 : 0.75)) return;
  mixed_sum += weight * vec4(s.rgb, 1.0);
#ifdef KEEP_SAMPLES
  if (kept_count < 72) kept[kept_count++] = vec4(s.rgb, weight);
#endif
}

vec3 mixed_colour() {
  if (mixed_sum.a <= 0.0) return vec3(0.0);
  vec3 mean = mixed_sum.rgb / mixed_sum.a;
#ifdef KEEP_SAMPLES
  for (int step = 0; step < 2 && are_judged && kept_count >= 6; ++step) {
    vec4 sum = vec4(0.0);
    for (int k = 0; k < kept_count; ++k) {
      vec3 d = (kept[k].rgb - mean) * (255.0 / 40.0);
      float far = 1.0 + dot(d, d);
      sum += kept[k].a / (far * far) * vec4(kept[k].rgb, 1.0);
    }
    mean = sum.rgb / sum.a;
  }
#endif
  return mean;
}

uint packed_colour(vec3 rgb, uint how) {
  uvec3 level = uvec3(clamp(rgb * 255.0, 0.0, 255.0) + 0.5);
  return level.b | level.g << 8 | level.r << 16 | how << 24;
}

// How much a station counts that sees a point so far (seen_part(), add_share()).
float weight_of(Read read, uint occluded, float doubt) {
  float hidden = (occluded & read.before) != 0u ? 1.0 - read.after_part : 0.0;
  hidden += (occluded & read.after) != 0u ? read.after_part : 0.0;
  float seen = (occluded & kOccludedInView) != 0u ? 0.0 : 1.0 - hidden;
  float share = mix(read.to_eye.w, read.unreliable, doubt);
  return share * (seen + (1.0 - seen) * (doubt + 1e-8));
}

float part_of(float weight, float total) {
  float part = weight / max(total, 1e-12);
  return part < 1e-5 ? 0.0 : part;
}

float same_surface(float a, float b) { return abs(a - b) > tolerance * max(a, b) ? 0.0 : 1.0; }

float inverse_between(Column c, int row) {
  float a = inverse_at(c.nearest, row), b = inverse_at(c.other, row);
  return a + abs(c.right) * same_surface(a, b) * (b - a);
}

vec2 tame(vec2 change) {  // columns jump behind a station
  float wild = float(captured.x) / 8.0;
  return vec2(abs(change.x) > wild ? 0.0 : change.x, abs(change.y) > wild ? 0.0 : change.y);
}

float phi_of(float row, int rows) { return 0.5 * kPi - (row + 0.5) / float(rows) * kPi; }

// The pixel from the stations of its lines.
void mix_lines(Column c, int row_of_distances, float down) {
  // Places are interpolated between two rows of the distances.
  int r = row_of_distances, last = distance_size.y - 1;
  int beside = down < 0.0 ? r - 1 : r + 1;
  bool beyond = beside < 0 || beside > last;  // go on as between this row and the next one
  if (beyond) beside = r == 0 ? min(1, last) : r - 1;
  float w = inverse_between(c, r), w_beside = inverse_between(c, beside);
  float towards = abs(down) * same_surface(w, w_beside) * (beyond ? -1.0 : 1.0);
  float phi = phi_of(float(r), distance_size.y), phi_beside = phi_of(float(beside), distance_size.y);
  vec2 here = vec2(sin(phi), cos(phi)), there = vec2(sin(phi_beside), cos(phi_beside));
  float doubt = (c.flags & kHasTrust) != 0u ? 1.0 - trust_at(c.nearest, r) : 0.0;
  float total = 0.0;
  for (int i = 0; i < c.reads; ++i) {
    Read read = reads[c.first_read + i];
    total += weight_of(read, read.image < 0 ? 0u : byte_of(read.image, c.nearest, r), doubt);
  }
  begin_mixing();
  for (int i = 0; i < c.reads; ++i) {
    Read read = reads[c.first_read + i];
    float weight =
        part_of(weight_of(read, read.image < 0 ? 0u : byte_of(read.image, c.nearest, r), doubt), total);
    if (c.reads == 1) weight = 1.0;  // what it does not see is filled
    if (weight == 0.0) continue;
    vec2 place = place_of(read.to_eye.xyz, here.x, here.y, w);
    if (towards != 0.0) place += towards * tame(place_of(read.to_eye.xyz, there.x, there.y, w_beside) - place);
    add_sample(read, weight, place, c.captured);
  }
}

void mix_initial(Column c, int row) {
  float v = (float(row) + 0.5) * float(captured.y) / float(output_size.y) - 0.5;
  begin_mixing();
  for (int i = 0; i < c.reads; ++i) {
    Read read = reads[c.first_read + i];
    add_sample(read, read.to_eye.w, vec2(0.0, v), c.captured);
  }
}

// A quarter of a pixel of the distances, `offset` output pixels from the middle of a pixel; a: 1
// where stations see its surface.
vec4 quarter_colour(Column c, Edge edge, int quarter, int row, vec2 offset) {
  float at = float(row) + offset.y;
  int r = clamp(int(floor((at + 0.5) * float(distance_size.y) / float(output_size.y))), 0,
                distance_size.y - 1);
  int surface = int(edge.surface >> (8 * quarter));
  int right = (surface & 15) - 1, down = (surface >> 4 & 15) - 1;
  int seen_row = clamp(r + down, 0, distance_size.y - 1);
  int seen_column = (c.nearest + right + distance_size.x) % distance_size.x;
  float doubt = (c.flags & kHasTrust) != 0u ? 1.0 - trust_at(c.nearest, r) : 0.0;
  float phi = phi_of(at, output_size.y), turn = offset.x / float(output_size.x) * 2.0 * kPi;
  float w = edge.inverse[quarter], total = 0.0;
  begin_mixing();
  for (int pass = 0; pass < 2; ++pass) {
    float sum = 0.0;
    for (int i = 0; i < c.reads; ++i) {
      Read read = reads[c.first_read + i];
      int image = read.image, theta = c.nearest;
      uint other = c.beside >> (8 * read.source + (right < 0 ? 0 : 4)) & 15u;
      if (right != 0 && other < 4u) {
        image = int(other);
        theta = seen_column;
      }
      float weight = weight_of(read, image < 0 ? 0u : byte_of(image, theta, seen_row), doubt);
      sum += weight;
      if (pass == 0 || part_of(weight, total) == 0.0) continue;
      vec3 to_eye = vec3(read.to_eye.x * cos(turn) + read.to_eye.y * sin(turn),
                         read.to_eye.y * cos(turn) - read.to_eye.x * sin(turn), read.to_eye.z);
      add_sample(read, part_of(weight, total), place_of(to_eye, sin(phi), cos(phi), w),
                 c.captured + offset.x * float(captured.x) / float(output_size.x));
    }
    total = sum;
  }
  if (total < 1e-6 || mixed_sum.a == 0.0) return vec4(0.0);
  return vec4(mixed_colour(), 1.0);
}

// The edge in a row of a column of the distances, or -1.
int find_edge(Column c, int row) {
  int begin = c.first_edge, end = c.first_edge + c.edges;
  while (begin < end) {
    int middle = (begin + end) / 2;
    if (edges[middle].row < row) begin = middle + 1; else end = middle;
  }
  return begin < c.first_edge + c.edges && edges[begin].row == row ? begin : -1;
}

vec3 with_edge(Column c, Edge edge, int row, vec3 colour) {
  vec4 sum = vec4(0.0);
  float per_distance = float(output_size.y) / float(distance_size.y);
  if (per_distance < 1.5) {
    for (int quarter = 0; quarter < 4; ++quarter) {
      vec2 offset = vec2(quarter < 2 ? -0.25 : 0.25, (quarter & 1) == 0 ? -0.25 : 0.25);
      sum += quarter_colour(c, edge, quarter, row, offset);
    }
  } else {
    bool upper = (float(row) + 0.5) / per_distance - 0.5 < float(edge.row);
    sum = quarter_colour(c, edge, (c.right < 0.0 ? 0 : 2) + (upper ? 0 : 1), row, vec2(0.0));
  }
  return sum.a == 0.0 ? colour : 0.5 * (colour + sum.rgb / sum.a);
}

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (at.x >= part.y || at.y >= part.w) return;
  Column c = columns[part.x + at.x];
  int row = first_row + at.y;
  uint how = kRead;
  vec3 colour;
#ifdef KEEP_SAMPLES
  are_judged = (c.flags & kJudged) != 0u;
#endif
  if (is_initial) {
    mix_initial(c, row);
    colour = mixed_colour();
    if (c.reads == 0 || mixed_sum.a == 0.0) how = kUnread;
  } else {
    float at_distances =
        (float(row) + 0.5) * float(distance_size.y) / float(output_size.y) - 0.5;
    int r = clamp(int(floor(at_distances + 0.5)), 0, distance_size.y - 1);
    uint fill = byte_of(kImages, c.nearest, r);
    bool from_lines = fill == 0u || fill == kReadUnseen;
    if (fill == kNoStation) {
      colour = vec3(0.0);
      how = kUnread;
    } else if (from_lines) {
      mix_lines(c, r, at_distances - float(r));
      colour = mixed_colour();
      if ((c.flags & kMasked) != 0u && mixed_sum.a == 0.0) how = kUndecided;
    } else {
      vec4 station = fill_m[fill - 1u];
      vec3 d = c.eye_m.xyz - station.xyz;
      float phi = phi_of(float(row), output_size.y);
      float theta = (float(part.x + at.x + first_column) + 0.5) / float(output_size.x) * 2.0 * kPi - kPi;
      vec3 to_eye = vec3(d.x * sin(theta) + d.z * cos(theta), d.x * cos(theta) - d.z * sin(theta), d.y);
      vec2 place = place_of(to_eye, sin(phi), cos(phi), inverse_at(c.nearest, r));
      vec4 s = sample_station(int(station.w), place.x + c.captured, place.y);
      colour = s.rgb;
      how = s.a > 0.75 ? kFilled : s.a > 0.25 ? kUndecided : kUnread;
      if (how == kUnread) colour = vec3(0.0);
    }
    int edge = c.reads == 0 ? -1 : find_edge(c, r);
    if (edge >= 0) colour = with_edge(c, edges[edge], row, colour);
  }
  if ((c.flags & kEmpty) != 0u) how |= kOfNoLine;
  picture[at.y * part.z + part.x + at.x] = packed_colour(colour, how);
}
