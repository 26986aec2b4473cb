// Pass 3 on a graphics card (core/view/edges.h): the quarters of pixels at edges of the distances.

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 1) readonly buffer Distances { float distances[]; };
// Of a pixel at an edge bit 8, and from bit 16 on 4 bits of each quarter: 1 + right and, 2 bits
// higher, 1 + down of the pixel around it whose surface it is on.
layout(std430, binding = 3) buffer Fills { uint fills[]; };
// Inverse distances of the quarters: upper left, lower left, upper right, lower right.
layout(std430, binding = 4) writeonly buffer Quarters { vec4 quarters[]; };

uniform ivec2 edge_columns;  // of the distances: the first, and their number

float at_pixel(int theta, int row) {
  int column = (theta + distance_size.x) % distance_size.x;
  return distances[column * distance_size.y + clamp(row, 0, distance_size.y - 1)];
}
bool is_step(float a, float b) { return abs(a - b) > tolerance * max(a, b); }

struct Surface {
  float inverse;
  uint around;  // as in fills
};

// On which of two surfaces a quarter is: the first that a map shows there.
Surface quarter_of(ivec2 at, int quarter, Surface near, Surface far, Surface own) {
  float right = quarter < 2 ? -0.25 : 0.25, down = (quarter & 1) == 0 ? -0.25 : 0.25;
  float theta = theta_of(float(at.y) + right, distance_size.x);
  vec2 latitude = latitude_of(float(at.x) + down, distance_size.y);
  for (int i = 0; i < gathered; ++i) {
    vec2 held = look_up_point(map_places[i], theta, latitude, near.inverse);
    if (held.y >= 0.5) return Surface(held.x, near.around);
    held = look_up_point(map_places[i], theta, latitude, far.inverse);
    if (held.y >= 0.5) return Surface(held.x, far.around);
  }
  return own;
}

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);  // x: row, y: column
  if (at.x >= distance_size.y || at.y >= edge_columns.y) return;
  at.y = (edge_columns.x + at.y) % distance_size.x;
  float w = at_pixel(at.y, at.x);
  if (!is_step(w, at_pixel(at.y - 1, at.x)) && !is_step(w, at_pixel(at.y + 1, at.x)) &&
      !is_step(w, at_pixel(at.y, at.x - 1)) && !is_step(w, at_pixel(at.y, at.x + 1))) {
    return;
  }
  Surface own = Surface(w, 5u), near = own, far = own;
  for (int i = 0; i < 9; ++i) {
    float other = at_pixel(at.y + i / 3 - 1, at.x + i % 3 - 1);
    uint around = uint(i / 3 | (i % 3) << 2);
    if (other > near.inverse) near = Surface(other, around);
    if (other < far.inverse) far = Surface(other, around);
  }
  int pixel = at.y * distance_size.y + at.x;
  uint edge = 1u << 8;
  vec4 inverse;
  for (int quarter = 0; quarter < 4; ++quarter) {
    Surface surface = quarter_of(at, quarter, near, far, own);
    inverse[quarter] = surface.inverse;
    edge |= surface.around << (16 + 4 * quarter);
  }
  quarters[pixel] = inverse;
  fills[pixel] |= edge;
}
