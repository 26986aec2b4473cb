flat in uint drawn;
flat in ivec2 beside;
flat in float side;

out uint written;

void main() {
  ivec2 from_middle = abs(ivec2(gl_PointCoord * side) - ivec2(side) / 2);
  if (from_middle.x > beside.x || from_middle.y > beside.y) discard;
  written = drawn;
}
