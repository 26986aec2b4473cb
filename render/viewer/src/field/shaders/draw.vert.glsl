// Draws a pixel of each map as a point where the viewpoint sees it. Beside the picture of the
// distances lie margins: what points at the seam cover there is on the other side.

flat out uint drawn;
flat out ivec2 beside;  // pixels that are covered on either side, above and below
flat out float side;    // of the point

void main() {
  MapPlace map = map_places[gl_InstanceID];
  int column = gl_VertexID % map.width, row = gl_VertexID / map.width;
  float half_px = 0.5 * float(distance_size.x) / float(map.width);
  DrawnPoint point = point_seen(map, float(column), latitude_of(float(row), map.rows),
                                held_in(map, column, row), half_px);
  gl_Position = vec4(2.0);  // outside
  if (point.inverse < 0.0) return;
  drawn = floatBitsToUint(point.inverse) + 1u;
  beside = ivec2(point.across, point.down);
  side = float(2 * max(point.across, point.down) + 1);
  vec2 size = vec2(distance_size + ivec2(2 * margin_of(distance_size), 0));
  vec2 middle = vec2(point.column + margin_of(distance_size), point.row) + 0.5;
  float depth = 1.0 / (1.0 + point.inverse);  // the nearest stays
  gl_Position = vec4(2.0 * middle / size - 1.0, 2.0 * depth - 1.0, 1.0);
  gl_PointSize = side;
}
