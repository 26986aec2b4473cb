// Pixels next to a silhouette as points as large as they look: a surface ends half a pixel beyond the
// middle of its last pixel.

out vec3 point;
out float omega;
flat out int rank;
flat out int torn;
flat out float omegaBehind;

uniform vec2 pixelsPerRadian;  // of the view's middle, and the largest point that can be drawn

void main() {
  ivec2 size = textureSize(omegaMaps, 0).xy;
  int column = gl_VertexID % size.x;
  int row = gl_VertexID / size.x;
  placeVertex(column, row);
  bool rim = false;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      rim = rim || isSilhouette(omegaFromStation, omegaAt(mapLayer, column + i, row + j));
    }
  }
  if (!rim || gl_Position.w <= 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  float distance = length(scaledPoint);
  float pixel = 2.0 * PI / float(size.x) / max(1e-6, distance);
  gl_PointSize = clamp(pixel * pixelsPerRadian.x * distance / max(1e-6, gl_Position.w), 1.0,
                       pixelsPerRadian.y);
  point = scaledPoint;
  omega = omegaFromStation;
  rank = gl_InstanceID;
  torn = 0;
  omegaBehind = 0.0;
}
