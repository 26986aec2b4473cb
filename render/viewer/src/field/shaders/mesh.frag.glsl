// Writes inverse distances from the viewpoint. Surfaces come before what is stretched between two of
// them; of surfaces the nearest is kept, and among those that agree the one of the nearest map; of
// what is stretched the farthest, because a near object hides background.

in vec3 point;
in float omega;
flat in int rank;
flat in int torn;
flat in float omegaBehind;

uniform float nearest_m;    // distances below are taken for this one in comparing
uniform float rankPenalty;  // relative, per rank

out vec4 seen;

void main() {
  float here = torn == 1 ? omegaBehind : omega / max(1e-9, length(point));
  float compared = min(1.0, here * nearest_m);
  gl_FragDepth = torn == 1 ? 0.5 + 0.5 * compared
                           : 0.5 - 0.5 * compared * (1.0 - rankPenalty * float(rank));
  seen = vec4(here, 0.0, 0.0, 1.0);
}
