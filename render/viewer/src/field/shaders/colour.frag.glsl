// The colour of a view's pixel, as the engine finds it (core/view): the point that it shows is looked
// up in the stations around where its ray crosses the lines in front and behind, unless their own
// distances show something nearer there; the lines' shares are those of the plan.

in vec3 ray;
in vec2 place;

uniform sampler2D distances;         // omega from the viewpoint, < 0: unknown
uniform sampler2D plan;              // [source][column]: layers of two stations, share of the
                                     // second, share of the line; a share of 0: no line
uniform sampler2D stations;          // [fact][layer]: position and picture (0 none, 1 coarse, 2 fine);
                                     // whether distances are there
uniform sampler2DArray pictures;     // fine
uniform sampler2DArray coarsePictures;
uniform vec3 viewpoint;
uniform bool corrected;              // by distances; else the vertical cut
uniform int sources;                 // rows of the plan that are read
uniform int fillLayers[MAX_FILL];    // stations for what no line sees, nearest first
uniform int fillCount;
uniform float vignette;              // 0 none to 1
uniform vec3 rayAcross;              // change of `ray` over the width of the view
uniform vec3 rayUpwards;             // and over its height
uniform vec2 capturedPixel;          // its size in the middle of the view, of the view's size
uniform float divider;               // of a comparison: the panorama up to here, then this view
uniform sampler2D comparedPicture;

out vec4 colour;

const vec3 NOTHING = vec3(0.25);  // where no station shows anything
// A surface hides a point only if seen from the viewpoint both would move by at least this much
// against each other, in pixels of the maps: less is noise, and would not be painted wrongly.
const float CLEARLY_NEARER_PX = 2.0;
// Around a pixel, in captured pixels: as wide as a captured pixel, and what lies between two of them,
// are blurred (their variances add up to 1/4).
const vec2 CORNERS[4] = vec2[4](vec2(-0.5, -0.5), vec2(0.5, -0.5), vec2(-0.5, 0.5), vec2(0.5, 0.5));

vec3 pictureAt(int layer, vec3 direction) {
  vec3 at = vec3(panoramaPlace(direction), float(layer));
  float picture = texelFetch(stations, ivec2(layer, 0), 0).w;
  return picture > 1.5 ? texture(pictures, at).rgb : texture(coarsePictures, at).rgb;
}

// Whether the station's own map shows something clearly nearer than a point in its direction: in one
// of the four pixels around, because what a camera captures at a silhouette is in part the
// foreground (core/view/visibility.h).
bool isHidden(int layer, vec3 seen, float omega, vec3 fromStation) {
  if (texelFetch(stations, ivec2(layer, 1), 0).x < 0.5) return false;
  vec2 size = vec2(textureSize(omegaMaps, 0).xy);
  vec2 at = panoramaPlace(seen) * size - 0.5;
  ivec2 upper = ivec2(floor(at));
  float slack = CLEARLY_NEARER_PX * 2.0 * PI / size.x / max(1e-9, length(fromStation));
  float limit = omega / max(1e-9, length(seen)) * (1.0 + surfaceTolerance) + slack;
  return omegaAt(layer, upper.x, upper.y) > limit || omegaAt(layer, upper.x + 1, upper.y) > limit ||
      omegaAt(layer, upper.x, upper.y + 1) > limit ||
      omegaAt(layer, upper.x + 1, upper.y + 1) > limit;
}

vec3 initialColour(vec3 direction, int column) {
  vec3 sum = vec3(0.0);
  float total = 0.0;
  for (int row = 0; row < 2; ++row) {
    vec4 line = texelFetch(plan, ivec2(column, row), 0);
    if (line.w <= 0.0) continue;
    sum += line.w * mix(pictureAt(int(line.x), direction), pictureAt(int(line.y), direction), line.z);
    total += line.w;
  }
  return total > 0.0 ? sum / total : NOTHING;
}

vec3 correctedColour(vec3 direction, float omega, int column) {
  vec3 sum = vec3(0.0);
  float total = 0.0;
  vec3 hiddenSum = vec3(0.0);  // as if all stations saw the point
  float hiddenTotal = 0.0;
  for (int row = 0; row < sources; ++row) {
    vec4 line = texelFetch(plan, ivec2(column, row), 0);
    if (line.w <= 0.0) continue;
    for (int which = 0; which < 2; ++which) {
      float share = line.w * (which == 0 ? 1.0 - line.z : line.z);
      if (share <= 0.0) continue;
      int layer = int(which == 0 ? line.x : line.y);
      vec3 fromStation = viewpoint - texelFetch(stations, ivec2(layer, 0), 0).xyz;
      vec3 seen = direction + omega * fromStation;
      vec3 shown = pictureAt(layer, seen);
      hiddenSum += share * shown;
      hiddenTotal += share;
      if (isHidden(layer, seen, omega, fromStation)) continue;
      sum += share * shown;
      total += share;
    }
  }
  if (total > 0.0) return sum / total;
  for (int i = 0; i < fillCount; ++i) {
    int layer = fillLayers[i];
    vec3 fromStation = viewpoint - texelFetch(stations, ivec2(layer, 0), 0).xyz;
    vec3 seen = direction + omega * fromStation;
    if (!isHidden(layer, seen, omega, fromStation)) return pictureAt(layer, seen);
  }
  return hiddenTotal > 0.0 ? hiddenSum / hiddenTotal : NOTHING;
}

int columnOf(vec3 direction) {
  int columns = textureSize(plan, 0).x;
  return min(int(panoramaPlace(direction).x * float(columns)), columns - 1);
}

float omegaOf(vec2 at) {
  vec2 size = vec2(textureSize(distances, 0));
  return texelFetch(distances, ivec2(clamp(at * size, vec2(0.0), size - 1.0)), 0).r;
}

vec3 colourOf(vec2 at, float omega) {
  vec3 direction = normalize(ray + (at.x - place.x) * rayAcross + (at.y - place.y) * rayUpwards);
  return omega < 0.0 ? initialColour(direction, columnOf(direction))
                     : correctedColour(direction, omega, columnOf(direction));
}

// At silhouettes the mean over a captured pixel, because distances know them to a pixel only: else
// steps would be seen where a captured pixel is many pixels of the view.
vec3 softenedColour() {
  float omega = omegaOf(place);
  float omegas[4];
  bool torn = false;
  for (int i = 0; i < 4; ++i) {
    omegas[i] = omegaOf(place + CORNERS[i] * capturedPixel);
    torn = torn || isSilhouette(omega, omegas[i]);
  }
  if (!torn) return colourOf(place, omega);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < 4; ++i) sum += colourOf(place + CORNERS[i] * capturedPixel, omegas[i]);
  return 0.25 * sum;
}

void main() {
  vec3 direction = normalize(ray);
  if (place.x < divider) {
    colour = vec4(texture(comparedPicture, panoramaPlace(direction)).rgb, 1.0);
    return;
  }
  vec3 shown = corrected ? softenedColour() : initialColour(direction, columnOf(direction));
  float fromMiddle = length(2.0 * place - 1.0);
  shown *= 1.0 - vignette * smoothstep(0.45, 0.95, fromMiddle);
  colour = vec4(shown, 1.0);
}
