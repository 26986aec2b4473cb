// What follows DRAW, a pixel each: REFINE, FILL and EDGES. Inverse distances are stored as their
// bits: every device draws into whole numbers, not every one into floating-point pictures.

uniform usampler2D before;  // what the step before has drawn

float inverse_at(int column, int row) {
  return uintBitsToFloat(texelFetch(before, ivec2(column, row), 0).r);
}

#ifdef REFINE
out uint bits;

uint drawn_at(int column, int row) {
  int margin = margin_of(distance_size), width = distance_size.x;
  uint drawn = texelFetch(before, ivec2(column + margin, row), 0).r;
  int again = column < margin ? column + width : column >= width - margin ? column - width : column;
  return max(drawn, texelFetch(before, ivec2(again + margin, row), 0).r);
}

void main() { bits = floatBitsToUint(refined_inverse(int(gl_FragCoord.x), int(gl_FragCoord.y))); }
#endif

#ifdef FILL
out uint bits;

float refined_at(int column, int row) { return inverse_at(column, row); }

void main() { bits = floatBitsToUint(filled_inverse(int(gl_FragCoord.x), int(gl_FragCoord.y))); }
#endif

#ifdef EDGES
out uvec4 surfaces;  // of each quarter; 0: no edge

void main() {
  int column = int(gl_FragCoord.x), row = int(gl_FragCoord.y);
  uvec4 found = uvec4(0u);
  bool any = is_edge(column, row);
  for (int quarter = 0; any && quarter < 4; ++quarter) {
    found[quarter] = packed_surface(quarter_at(column, row, quarter));
  }
  surfaces = found;
}
#endif
