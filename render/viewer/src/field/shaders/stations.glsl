// What all shaders know of stations. Included first.
//
// Lengths are metres, omega is inverse distance (1/m, 0: infinitely far), angles are radians, vectors
// are in Raywalk's world: x right, y up, z forward. A station's panorama has its middle column at +z.

precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
precision highp usampler2DArray;

const float PI = 3.14159265358979;

uniform usampler2DArray omegaMaps;  // [layer][row][column], steps of omegaStep
uniform float omegaStep;
uniform float surfaceTolerance;

// Longitude and latitude of a direction of any length.
vec2 anglesOf(vec3 direction) {
  return vec2(atan(direction.x, direction.z), atan(direction.y, length(direction.xz)));
}

// Where a direction is in a panorama, in [0, 1] from its left and its top.
vec2 panoramaPlace(vec3 direction) {
  vec2 angles = anglesOf(direction);
  return vec2(angles.x / (2.0 * PI) + 0.5, 0.5 - angles.y / PI);
}

float omegaAt(int layer, int column, int row) {
  ivec2 size = textureSize(omegaMaps, 0).xy;
  int wrapped = (column + size.x) % size.x;
  int inside = clamp(row, 0, size.y - 1);
  return float(texelFetch(omegaMaps, ivec3(wrapped, inside, layer), 0).r) * omegaStep;
}

// Whether two neighbouring pixels are on different surfaces.
bool isSilhouette(float a, float b) { return abs(a - b) > surfaceTolerance * max(a, b); }
