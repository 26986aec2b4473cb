// What the camera shows of the panorama around the viewpoint.

precision highp sampler2D;

in vec2 place;

uniform sampler2D panorama;
uniform sampler2D compared_panorama;
uniform float divider;          // of a comparison: the compared panorama up to here, then this view
uniform float vignette;         // 0 none to 1
uniform mat3 world_from_camera;
uniform vec4 projection;        // focal lengths x, y and shifts x, y of clip coordinates

out vec4 colour;

void main() {
  vec2 clip = 2.0 * place - 1.0;
  vec3 ray = world_from_camera * vec3((clip + projection.zw) / projection.xy, -1.0);
  vec2 at = vec2(arc_tangent(ray.x, ray.z) / (2.0 * kPi) + 0.5,
                 0.5 - arc_tangent(ray.y, length(ray.xz)) / kPi);
  bool is_compared = place.x < divider;
  colour = is_compared ? texture(compared_panorama, at) : texture(panorama, at);
  if (!is_compared) colour.rgb *= 1.0 - vignette * smoothstep(0.45, 0.95, length(clip));
}
