// The quarters of pixels at edges of the distances (core/view/edges.h), shared with the page of
// exported rooms.

float inverse_at(int column, int row);  // of the distances

struct Surface {
  float inverse;
  uint around;  // of the pixel around that it is in: 1 + right and, 2 bits higher, 1 + down
};

float inverse_around(int column, int row) {
  int wrapped = (column + distance_size.x) % distance_size.x;
  return inverse_at(wrapped, clamp(row, 0, distance_size.y - 1));
}

bool is_edge(int column, int row) {
  float w = inverse_at(column, row);
  return is_step(w, inverse_around(column - 1, row)) ||
      is_step(w, inverse_around(column + 1, row)) || is_step(w, inverse_around(column, row - 1)) ||
      is_step(w, inverse_around(column, row + 1));
}

// Pixels from the middle of a pixel to that of a quarter: upper left, lower left, upper right,
// lower right.
vec2 quarter_offset(int quarter) {
  return vec2(quarter < 2 ? -0.25 : 0.25, (quarter & 1) == 0 ? -0.25 : 0.25);
}

// The surface of a quarter: of the nearest and the farthest around, the first that a map shows.
Surface quarter_at(int column, int row, int quarter) {
  Surface own = Surface(inverse_at(column, row), 5u), near = own, far = own;
  for (int i = 0; i < 9; ++i) {
    float other = inverse_around(column + i / 3 - 1, row + i % 3 - 1);
    uint around = uint(i / 3 | (i % 3) << 2);
    if (other > near.inverse) near = Surface(other, around);
    if (other < far.inverse) far = Surface(other, around);
  }
  vec2 offset = quarter_offset(quarter);
  float theta = theta_of(float(column) + offset.x, distance_size.x);
  vec2 latitude = latitude_of(float(row) + offset.y, distance_size.y);
  for (int i = 0; i < gathered; ++i) {
    vec2 held = look_up_point(map_places[i], theta, latitude, near.inverse);
    if (held.y >= 0.5) return Surface(held.x, near.around);
    held = look_up_point(map_places[i], theta, latitude, far.inverse);
    if (held.y >= 0.5) return Surface(held.x, far.around);
  }
  return own;
}
