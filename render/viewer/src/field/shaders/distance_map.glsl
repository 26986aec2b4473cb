// A station's distance map as a surface around the viewpoint (vertex shaders of distance_pass.ts).
//
// A vertex stands for a pixel: the point station + direction / omega. Relative to the viewpoint and
// scaled by omega it is direction + omega (station - viewpoint), finite for infinitely far points
// too. Interpolated like this, omega is exact on planes: the scaled point and omega are homogeneous
// coordinates, and any combination of those of three points lies in their plane.

uniform int layers[MAX_MAPS];
uniform vec3 stationFromView[MAX_MAPS];  // station - viewpoint
uniform mat3 cameraFromWorld;            // to right, up, backwards
uniform vec4 projection;                 // focal lengths x, y and shifts x, y of clip coordinates

vec3 scaledPoint;  // of the current vertex
float omegaFromStation;
int mapRank;  // of the maps, the nearest first
int mapLayer;

vec3 directionOf(int column, int row) {
  ivec2 size = textureSize(omegaMaps, 0).xy;
  float theta = (float(column) + 0.5) / float(size.x) * 2.0 * PI - PI;
  // The rows before the first and after the last are the poles.
  float phi = clamp(0.5 - (float(row) + 0.5) / float(size.y), -0.5, 0.5) * PI;
  return vec3(cos(phi) * sin(theta), sin(phi), cos(phi) * cos(theta));
}

// Inverse distance of a pixel's point from the viewpoint.
float omegaFromView(int column, int row) {
  float omega = omegaAt(mapLayer, column, row);
  return omega / max(1e-9, length(directionOf(column, row) + omega * stationFromView[mapRank]));
}

void placeVertex(int map, int column, int row) {
  mapRank = map;
  mapLayer = layers[map];
  omegaFromStation = omegaAt(mapLayer, column, row);
  scaledPoint = directionOf(column, row) + omegaFromStation * stationFromView[map];
  vec3 seen = cameraFromWorld * scaledPoint;
  gl_Position = vec4(projection.xy * seen.xy + projection.zw * seen.z, 0.0, -seen.z);
}
