
uniform vec4 projection;        // focal lengths x, y and shifts x, y of clip coordinates
uniform mat3 worldFromCamera;

out vec3 ray;  // in the world, not of unit length
out vec2 place;

void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  ray = worldFromCamera * vec3((corner + projection.zw) / projection.xy, -1.0);
  place = 0.5 * corner + 0.5;
  gl_Position = vec4(corner, 1.0, 1.0);
}
