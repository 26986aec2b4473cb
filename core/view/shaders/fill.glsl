// Which station shows a point that the lines in use do not see (core/view/fill_stations.h).

uniform ivec2 captured;    // width and height of the stations
uniform ivec2 fill_maps;   // of map_places: the first of those that are searched, and their number
uniform bool has_trust;    // whether distances are followed by how far they can be relied on
// y: captured column, x 0: its first unmasked row and, 16 bits higher, the row after the last one.
// y: column of the panorama in which what moved is marked, x from 1: bits of its rows.
uniform usampler2DArray masks;

const uint kNoStation = 255u, kReadUnseen = 254u, kOccludedInView = 0x80u;

// How far a station sees a point (seen_part() in core/view/visibility.h).
float seen_part(uint occluded, uint before, uint after, float after_part) {
  float hidden = (occluded & before) != 0u ? 1.0 - after_part : 0.0;
  hidden += (occluded & after) != 0u ? after_part : 0.0;
  return (occluded & kOccludedInView) != 0u ? 0.0 : 1.0 - hidden;
}

float trust_at(int theta, int row) {
  if (!has_trust) return 1.0;
  return distances[distance_size.x * distance_size.y + theta * distance_size.y + row];
}

// Whether the pixels of a station that a pixel of the distances covers are unmasked: more if the
// station is nearer, and more columns towards a pole.
bool is_unmasked(MapPlace map, float theta, Seen seen) {
  if (map.masks < 0) return true;
  float radius = 0.5 + float(captured.y) / float(distance_size.y) * max(1.0, 1.0 / seen.nearing);
  float columns = min(radius / max(1e-6, cos(seen.phi)), 0.5 * float(captured.x));
  float u = (theta + seen.turn + kPi) / (2.0 * kPi) * float(captured.x) - 0.5;
  float v = (0.5 * kPi - seen.phi) / kPi * float(captured.y) - 0.5;
  int first_row = max(int(floor(v - radius)), 0);
  int last_row = min(int(ceil(v + radius)), captured.y - 1);
  for (int i = int(floor(u - columns)); i <= int(ceil(u + columns)); ++i) {
    uint rows = texelFetch(masks, ivec3(0, (i + 2 * captured.x) % captured.x, map.masks), 0).r;
    if (first_row < int(rows & 0xffffu) || last_row >= int(rows >> 16)) return false;
  }
  return true;
}

// Whether something moved in one of the pixels of a station around a point.
bool is_left_out(MapPlace map, float theta, Seen seen) {
  if (map.moved_width == 0) return false;
  float u = (theta + seen.turn + kPi) / (2.0 * kPi) * float(map.moved_width) - 0.5;
  float v = (0.5 * kPi - seen.phi) / kPi * float(map.moved_rows) - 0.5;
  for (int i = 0; i < 9; ++i) {
    int column = (int(floor(u + 0.5)) + i / 3 - 1 + 2 * map.moved_width) % map.moved_width;
    int row = int(floor(v + 0.5)) + i % 3 - 1;
    if (row < 0 || row >= map.moved_rows) continue;
    uint rows = texelFetch(masks, ivec3(1 + row / 32, column, map.masks), 0).r;
    if ((rows >> (row & 31) & 1u) != 0u) return true;
  }
  return false;
}

Seen seen_by_fill(int station, float theta, vec2 latitude, float w) {
  vec3 from_centre = map_places[fill_maps.x + station].from_centre.xyz;
  return seen_from(to_eye_from(from_centre, theta), latitude, w);
}

// The station that shows a pixel of the distances, as an index, or -1 (FillStations::find()).
int find_fill(int column, int row) {
  float theta = theta_of(float(column), distance_size.x), w = inverse_at(column, row);
  vec2 latitude = latitude_of(float(row), distance_size.y);
  bool is_unreliable = trust_at(column, row) < 0.5;
  int just_sees = -1, shows_moved = -1;
  for (int i = 0; i < (is_unreliable ? min(fill_maps.y, 2) : fill_maps.y); ++i) {
    MapPlace map = map_places[fill_maps.x + i];
    Seen seen = seen_by_fill(i, theta, latitude, w);
    if (is_unreliable) {
      if (is_unmasked(map, theta, seen)) return i;
      continue;
    }
    vec2 held = look_up(map, theta, seen);
    float occludes = seen.inverse * (1.0 + tolerance);
    if (held.x < 0.0 || held.x > occludes || !is_unmasked(map, theta, seen)) continue;
    if (is_left_out(map, theta, seen)) {
      if (shows_moved < 0) shows_moved = i;
    } else if (held.y <= occludes) {
      return i;
    } else if (just_sees < 0) {
      just_sees = i;
    }
  }
  return just_sees >= 0 ? just_sees : shows_moved;
}
