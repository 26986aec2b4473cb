// Pass 4 on a graphics card: the samples of the stations, mixed (core/view/station_mixing.h), one
// invocation per pixel. What is said there of weights, edges and fills holds here; names are the
// same.

layout(local_size_x = 8, local_size_y = 8) in;

// What is the same in all rows of an output column (MixedColumn).
struct Column {
  int first_read, reads;
  int nearest, other;  // columns of the distances
  float right;         // how far right of the nearest one
  float captured;      // its place in the stations, W to 2 W
  uint flags;
  uint beside;  // of each source 8 bits: its image in the columns to the left and right of nearest
};
// kEmpty: no line serves it; kJudged: many samples are judged by each other.
const uint kMasked = 1u, kEmpty = 2u, kJudged = 4u;

struct Read {
  vec4 to_eye;  // ahead, aside and up in the column's frame, metres; the share where reliable
  float unreliable, after_part;
  int layer;   // of `stations`
  int source;  // of the column
  int image;   // of `occluded`; -1: none
  uint before, after;
  int unused;
};

// As visibility.glsl and edges.glsl write them.
layout(std430, binding = 2) readonly buffer Occluded { uint occluded[]; };
layout(std430, binding = 3) readonly buffer Fills { uint fills[]; };
layout(std430, binding = 4) readonly buffer Quarters { vec4 quarters[]; };
layout(std430, binding = 5) readonly buffer Columns { Column columns[]; };
layout(std430, binding = 6) readonly buffer Reads { Read reads[]; };
// bgr, and how the pixel was read in the highest byte. Before them bits of the stations that pixels
// are filled from, whether they are there or not, and how many pixels were read how.
layout(std430, binding = 7) buffer Picture {
  uint wanted_fills[2], counts[6];
  uint picture[];
};

uniform sampler2DArray stations;  // x: row, y: column; rgb, and in a whether it may be used
uniform ivec2 output_size;
uniform int first_column, first_row;  // of the output, where the picture begins
uniform ivec4 part;  // of the picture: first column, their number; its width and height
uniform bool is_initial, is_cubic;
uniform bool again;  // only what waits
uniform int fill_layers[64];  // of the stations that are searched; -1: not there

const uint kRead = 0u, kFilled = 1u, kUnread = 2u, kWaiting = 3u, kOfNoLine = 4u;

uint occluded_at(int image, int theta, int row) {
  if (image < 0) return 0u;  // the line is no source of that column
  return occluded[theta * distance_size.y + row] >> (8 * image) & 255u;
}

// Where a station sees a point: pixels to the right of the column, and the row.
vec2 place_of(Seen seen) {
  return vec2(seen.turn * float(captured.x) / (2.0 * kPi),
              (0.5 * kPi - seen.phi) * float(captured.y) / kPi - 0.5);
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
  float seen = seen_part(occluded, read.before, read.after, read.after_part);
  float share = mix(read.to_eye.w, read.unreliable, doubt);
  return share * (seen + (1.0 - seen) * (doubt + 1e-8));
}

float part_of(float weight, float total) {
  float part = weight / max(total, 1e-12);
  return part < 1e-5 ? 0.0 : part;
}

float same_surface(float a, float b) { return is_step(a, b) ? 0.0 : 1.0; }

float inverse_between(Column c, int row) {
  float a = inverse_at(c.nearest, row), b = inverse_at(c.other, row);
  return a + abs(c.right) * same_surface(a, b) * (b - a);
}

vec2 tame(vec2 change) {  // columns jump behind a station
  float wild = float(captured.x) / 8.0;
  return vec2(abs(change.x) > wild ? 0.0 : change.x, abs(change.y) > wild ? 0.0 : change.y);
}

// The pixel from the stations of its lines.
void mix_lines(Column c, int row_of_distances, float down) {
  // Places are interpolated between two rows of the distances.
  int r = row_of_distances, last = distance_size.y - 1;
  int beside = down < 0.0 ? r - 1 : r + 1;
  bool beyond = beside < 0 || beside > last;  // go on as between this row and the next one
  if (beyond) beside = r == 0 ? min(1, last) : r - 1;
  float w = inverse_between(c, r), w_beside = inverse_between(c, beside);
  float towards = abs(down) * same_surface(w, w_beside) * (beyond ? -1.0 : 1.0);
  vec2 here = latitude_of(float(r), distance_size.y);
  vec2 there = latitude_of(float(beside), distance_size.y);
  float doubt = 1.0 - trust_at(c.nearest, r);
  float total = 0.0;
  for (int i = 0; i < c.reads; ++i) {
    Read read = reads[c.first_read + i];
    total += weight_of(read, occluded_at(read.image, c.nearest, r), doubt);
  }
  begin_mixing();
  for (int i = 0; i < c.reads; ++i) {
    Read read = reads[c.first_read + i];
    float weight = part_of(weight_of(read, occluded_at(read.image, c.nearest, r), doubt), total);
    if (c.reads == 1) weight = 1.0;  // what it does not see is filled
    if (weight == 0.0) continue;
    vec2 place = place_of(seen_from(read.to_eye.xyz, here, w));
    if (towards != 0.0) {
      place += towards * tame(place_of(seen_from(read.to_eye.xyz, there, w_beside)) - place);
    }
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
vec4 quarter_colour(Column c, int edge_row, int quarter, int row, vec2 offset) {
  float at = float(row) + offset.y;
  int r = clamp(int(floor((at + 0.5) * float(distance_size.y) / float(output_size.y))), 0,
                distance_size.y - 1);
  int edge = c.nearest * distance_size.y + edge_row;
  int surface = int(fills[edge] >> (16 + 4 * quarter));
  int right = (surface & 3) - 1, down = (surface >> 2 & 3) - 1;
  int seen_row = clamp(r + down, 0, distance_size.y - 1);
  int seen_column = (c.nearest + right + distance_size.x) % distance_size.x;
  float doubt = 1.0 - trust_at(c.nearest, r);
  float turn = offset.x / float(output_size.x) * 2.0 * kPi;
  vec2 latitude = latitude_of(at, output_size.y);
  float w = quarters[edge][quarter];
  begin_mixing();
  for (int i = 0; i < c.reads; ++i) {
    Read read = reads[c.first_read + i];
    int image = read.image, theta = c.nearest;
    uint other = c.beside >> (8 * read.source + (right < 0 ? 0 : 4)) & 15u;
    if (right != 0 && other < 4u) {
      image = int(other);
      theta = seen_column;
    }
    float weight = weight_of(read, occluded_at(image, theta, seen_row), doubt);
    if (weight < 1e-6) continue;  // a trace: stations show something else there
    vec3 to_eye = vec3(read.to_eye.x * cos(turn) + read.to_eye.y * sin(turn),
                       read.to_eye.y * cos(turn) - read.to_eye.x * sin(turn), read.to_eye.z);
    add_sample(read, weight, place_of(seen_from(to_eye, latitude, w)),
               c.captured + offset.x * float(captured.x) / float(output_size.x));
  }
  return mixed_sum.a == 0.0 ? vec4(0.0) : vec4(mixed_colour(), 1.0);
}

vec3 with_edge(Column c, int edge_row, int row, vec3 colour) {
  vec4 sum = vec4(0.0);
  float per_distance = float(output_size.y) / float(distance_size.y);
  if (per_distance < 1.5) {
    for (int quarter = 0; quarter < 4; ++quarter) {
      sum += quarter_colour(c, edge_row, quarter, row, quarter_offset(quarter));
    }
  } else {
    bool upper = (float(row) + 0.5) / per_distance - 0.5 < float(edge_row);
    int quarter = (c.right < 0.0 ? 0 : 2) + (upper ? 0 : 1);
    sum = quarter_colour(c, edge_row, quarter, row, vec2(0.0));
  }
  return sum.a == 0.0 ? colour : 0.5 * (colour + sum.rgb / sum.a);
}

// The pixel from a station that was searched; sets how it was read.
vec3 fill_colour(Column c, int station, float theta, int row, int r, inout uint how) {
  uint bit = 1u << (station & 31);
  if ((wanted_fills[station >> 5] & bit) == 0u) atomicOr(wanted_fills[station >> 5], bit);
  how = kWaiting;
  if (fill_layers[station] < 0) return vec3(0.0);
  float w = inverse_at(c.nearest, r);
  Seen seen = seen_by_fill(station, theta, latitude_of(float(row), output_size.y), w);
  vec2 place = place_of(seen);
  vec4 s = sample_station(fill_layers[station], place.x + c.captured, place.y);
  how = kFilled;
  if (s.a > 0.75) return s.rgb;
  // What moved is shown where no other station sees the place.
  float of_distances = theta_of(float(c.nearest), distance_size.x);
  seen = seen_by_fill(station, of_distances, latitude_of(float(r), distance_size.y), w);
  MapPlace map = map_places[fill_maps.x + station];
  if (s.a > 0.25 && is_left_out(map, of_distances, seen)) return s.rgb;
  how = kUnread;
  return vec3(0.0);
}

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (at.x >= part.y || at.y >= part.w) return;
  Column c = columns[part.x + at.x];
  int row = first_row + at.y, pixel = at.y * part.z + part.x + at.x;
  if (again && (picture[pixel] >> 24 & 3u) != kWaiting) return;
  uint how = kRead;
  vec3 colour = vec3(0.0);
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
    uint fill = fills[c.nearest * distance_size.y + r];
    int station = int(fill & 255u) - 1;
    if (station < 0 || station + 1 == int(kReadUnseen)) {
      station = -1;
      mix_lines(c, r, at_distances - float(r));
      colour = mixed_colour();
      if ((c.flags & kMasked) != 0u && mixed_sum.a == 0.0) {
        station = find_fill(c.nearest, r);
        how = kUnread;
      }
    } else if (station + 1 == int(kNoStation)) {
      station = -1;
      how = kUnread;
    }
    float theta = theta_of(float(part.x + at.x + first_column), output_size.x);
    if (station >= 0) colour = fill_colour(c, station, theta, row, r, how);
    bool has_edge = c.reads > 0 && (fill >> 8 & 1u) != 0u;
    if (has_edge && how != kWaiting) colour = with_edge(c, r, row, colour);
  }
  if (how == kFilled || how == kUnread) atomicAdd(counts[how], 1u);
  if ((c.flags & kEmpty) != 0u) {
    if (how != kWaiting) atomicAdd(counts[kOfNoLine], 1u);
    how |= kOfNoLine;
  }
  picture[pixel] = packed_colour(colour, how);
}
