// Pass 3 on a graphics card: the quarters of pixels at edges of the distances (quarters.glsl).

layout(local_size_x = 8, local_size_y = 8) in;

// Of a pixel at an edge bit 8, and from bit 16 on 4 bits of each quarter (Surface::around).
layout(std430, binding = 3) buffer Fills { uint fills[]; };
layout(std430, binding = 4) writeonly buffer Quarters { vec4 quarters[]; };  // inverse distances

uniform ivec2 edge_columns;  // of the distances: the first, and their number

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);  // x: row, y: column
  if (at.x >= distance_size.y || at.y >= edge_columns.y) return;
  at.y = (edge_columns.x + at.y) % distance_size.x;
  if (!is_edge(at.y, at.x)) return;
  uint edge = 1u << 8;
  vec4 inverse;
  for (int quarter = 0; quarter < 4; ++quarter) {
    Surface surface = quarter_at(at.y, at.x, quarter);
    inverse[quarter] = surface.inverse;
    edge |= surface.around << (16 + 4 * quarter);
  }
  int pixel = at.y * distance_size.y + at.x;
  quarters[pixel] = inverse;
  fills[pixel] |= edge;
}
