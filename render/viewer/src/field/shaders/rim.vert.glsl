// Pixels next to a silhouette (silhouette_pixels.ts) as points as large as they look: a surface ends
// half a pixel beyond the middle of its last pixel.

in float pixel;  // counted through the rows

out vec3 point;
out float omega;
flat out int rank;
flat out int torn;
flat out float omegaBehind;

uniform int map;
uniform vec2 pixelsPerRadian;  // of the view's middle, and the largest point that can be drawn

void main() {
  ivec2 size = textureSize(omegaMaps, 0).xy;
  placeVertex(map, int(pixel) % size.x, int(pixel) / size.x);
  float distance = length(scaledPoint);
  float angle = 2.0 * PI / float(size.x) / max(1e-6, distance);
  gl_PointSize = clamp(angle * pixelsPerRadian.x * distance / max(1e-6, gl_Position.w), 1.0,
                       pixelsPerRadian.y);
  point = scaledPoint;
  omega = omegaFromStation;
  rank = map;
  torn = 0;
  omegaBehind = 0.0;
}
