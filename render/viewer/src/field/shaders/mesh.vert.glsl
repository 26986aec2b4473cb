// The surface between neighbouring pixels. Vertex ids count columns + 1 per row, from the zenith's
// row on; the last vertex of each triangle is the upper left one of its four, so that what it
// outputs flat tells of all four.

out vec3 point;
out float omega;
flat out int rank;
flat out int torn;           // between different surfaces
flat out float omegaBehind;  // of the farthest of the four, from the viewpoint

void main() {
  ivec2 size = textureSize(omegaMaps, 0).xy;
  int column = gl_VertexID % (size.x + 1);
  int row = gl_VertexID / (size.x + 1) - 1;
  placeVertex(gl_InstanceID, column, row);
  point = scaledPoint;
  omega = omegaFromStation;
  rank = mapRank;
  float right = omegaAt(mapLayer, column + 1, row);
  float below = omegaAt(mapLayer, column, row + 1);
  float across = omegaAt(mapLayer, column + 1, row + 1);
  torn = isSilhouette(omega, right) || isSilhouette(omega, below) || isSilhouette(right, across) ||
      isSilhouette(below, across) ? 1 : 0;
  omegaBehind = min(min(omegaFromView(column, row), omegaFromView(column + 1, row)),
                    min(omegaFromView(column, row + 1), omegaFromView(column + 1, row + 1)));
}
