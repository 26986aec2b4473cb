// Pass 2 on a graphics card (core/view/visibility.h): a group of invocations for each column of the
// distances.

const int kLanes = 128;
layout(local_size_x = 128) in;

// A source of a column.
struct Source {
  float met_m;  // where its line is met, ahead of the eye
  int image;    // the index of the first source of its line and side; -1: there is no source
  uint wanted;  // bits of the maps that are asked
  int first_map;  // of map_places: of the first bit
  uint before, after;  // bits of the maps around its nearest station
  float after_part;
  int unused;
};
// Of each pixel 8 bits for each source: kOccludedInView, and of the maps that show it occluded.
layout(std430, binding = 2) buffer Occluded { uint occluded[]; };
// Of each pixel in the lowest 8 bits the station that it is filled from.
layout(std430, binding = 3) writeonly buffer Fills { uint fills[]; };
layout(std430, binding = 5) readonly buffer Sources { Source sources[]; };  // four of each column
// Inverse distances of the other eye of a circle; else those of this one.
layout(std430, binding = 6) readonly buffer Opposite { float opposite[]; };

uniform int first_column;  // of the distances, of the first group
uniform float above_lines_m;
uniform bool fills_empty;

// The great circle around the point A where the column meets a line: of each bin the bits of the
// inverse distance from A of the nearest point.
shared uint nearest[2 * ROWS];

struct RingPoint {
  int bin;
  float inverse;  // distance from A, 1/m
};
// The points down the column, then those up the opposite one.
RingPoint ring_point(int i, int theta, float met_m) {
  bool is_opposite = i >= ROWS;
  int row = is_opposite ? 2 * ROWS - 1 - i : i;
  int other = (theta + distance_size.x / 2) % distance_size.x;
  float w = is_opposite ? opposite[other * ROWS + row] : inverse_at(theta, row);
  vec2 latitude = latitude_of(float(row), ROWS);
  float x = (is_opposite ? -latitude.y : latitude.y) - w * met_m;
  float y = latitude.x + w * above_lines_m;
  float at = (0.5 * kPi - arc_tangent(y, x)) / kPi * float(ROWS);
  at += at < 0.0 ? float(2 * ROWS) : 0.0;
  return RingPoint(min(int(at), 2 * ROWS - 1), w / (sqrt(x * x + y * y) + 1e-30));
}

void keep(int bin, float inverse) { atomicMax(nearest[bin], floatBitsToUint(inverse)); }

// A surface nearer to A than to the eye covers more bins than it has points.
void fill_gap(RingPoint point, RingPoint before) {
  int turn = 2 * ROWS, gap = point.bin - before.bin;
  if (abs(gap) <= 1) return;
  if (is_step(point.inverse, before.inverse)) return;
  gap += gap > ROWS ? -turn : gap < -ROWS ? turn : 0;
  int towards = gap < 0 ? -1 : 1;
  for (int i = towards; i != gap && abs(i) < ROWS; i += towards) {
    keep((before.bin + i + turn) % turn, min(point.inverse, before.inverse));
  }
}

void mark_ring(int theta, int image, float met_m, int lane) {
  // From a line in front, what lies behind the eye is farther than anything on this side.
  int points = met_m > 0.0 ? ROWS : 2 * ROWS;
  for (int i = lane; i < 2 * ROWS; i += kLanes) nearest[i] = 0u;
  barrier();
  for (int i = lane; i < points; i += kLanes) {
    RingPoint point = ring_point(i, theta, met_m);
    keep(point.bin, point.inverse);
    if (i == 0 && points == ROWS) continue;
    fill_gap(point, ring_point((i + points - 1) % points, theta, met_m));
  }
  barrier();
  for (int i = lane; i < ROWS; i += kLanes) {
    RingPoint point = ring_point(i, theta, met_m);
    uint left = nearest[(point.bin + 2 * ROWS - 1) % (2 * ROWS)];
    uint right = nearest[(point.bin + 1) % (2 * ROWS)];
    float least = uintBitsToFloat(max(max(left, right), nearest[point.bin]));
    if (point.inverse < least * (1.0 - tolerance)) {
      occluded[theta * ROWS + i] |= kOccludedInView << (8 * image);
    }
  }
  barrier();
}

void main() {
  int theta = (first_column + int(gl_WorkGroupID.x)) % distance_size.x;
  int lane = int(gl_LocalInvocationID.x);
  Source of_column[4];
  for (int i = 0; i < 4; ++i) of_column[i] = sources[4 * theta + i];
  for (int row = lane; row < ROWS; row += kLanes) occluded[theta * ROWS + row] = 0u;
  for (int i = 0; i < 4; ++i) {
    Source source = of_column[i];
    bool differs = source.met_m != 0.0 || above_lines_m != 0.0;  // from what the eye sees
    if (source.image == i && differs) mark_ring(theta, i, source.met_m, lane);
  }
  bool any = of_column[0].image >= 0;
  for (int row = lane; row < ROWS; row += kLanes) {
    int pixel = theta * ROWS + row;
    uint hidden = occluded[pixel];
    vec2 latitude = latitude_of(float(row), ROWS);
    for (int i = 0; i < 4; ++i) {
      if (of_column[i].image != i) continue;
      for (int bit = 0; bit < 7; ++bit) {
        if ((of_column[i].wanted >> bit & 1u) == 0u) continue;
        MapPlace map = map_places[of_column[i].first_map + bit];
        if (hides(map, theta_of(float(theta), distance_size.x), latitude, inverse_at(theta, row))) {
          hidden |= 1u << (8 * i + bit);
        }
      }
    }
    bool seen = false;
    for (int i = 0; i < 4; ++i) {
      Source s = of_column[i];
      if (s.image < 0) continue;
      seen = seen || seen_part(hidden >> (8 * s.image), s.before, s.after, s.after_part) >= 0.5;
    }
    uint fill = 0u;
    if (!any && !fills_empty) {
      fill = kNoStation;
    } else if (!seen && !(any && trust_at(theta, row) < 0.5)) {
      int station = find_fill(theta, row);
      fill = station >= 0 ? uint(station + 1) : any ? kReadUnseen : kNoStation;
      if (station < 0) hidden = 0u;
    }
    occluded[pixel] = hidden;
    fills[pixel] = fill;
  }
}
