// A flat picture, resampled from the part of a panorama that it shows (core/view/flat_view.h).

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 6) writeonly buffer Flat { uint flat_picture[]; };  // bgr
layout(std430, binding = 7) readonly buffer Picture { uint counts[8]; uint picture[]; };

uniform ivec2 flat_size, part_size;             // width and height
uniform vec3 first_ray, right_step, down_step;  // of the first pixel, and on to the next ones
uniform float middle_u, middle_v;               // of longitude and latitude 0, in the part
uniform float panorama_width;
uniform bool is_whole, is_cubic;  // is_whole: the part has all columns

vec3 colour_at(int column, int row) {
  int u = is_whole ? (column + part_size.x) % part_size.x : clamp(column, 0, part_size.x - 1);
  uint bgr = picture[clamp(row, 0, part_size.y - 1) * part_size.x + u];
  return vec3(bgr & 255u, bgr >> 8 & 255u, bgr >> 16 & 255u);
}

// Of four pixels one after the other, between the middle two: as cv::remap weighs them.
vec4 weights(float t) {
  if (!is_cubic) return vec4(0.0, 1.0 - t, t, 0.0);
  const float a = -0.75;
  float far = 2.0 - t, near = 1.0 + t;
  vec4 w;
  w[0] = ((a * near - 5.0 * a) * near + 8.0 * a) * near - 4.0 * a;
  w[1] = ((a + 2.0) * t - (a + 3.0)) * t * t + 1.0;
  w[3] = ((a * far - 5.0 * a) * far + 8.0 * a) * far - 4.0 * a;
  w[2] = 1.0 - w[0] - w[1] - w[3];
  return w;
}

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
  if (at.x >= flat_size.x || at.y >= flat_size.y) return;
  vec3 ray = first_ray + float(at.x) * right_step + float(at.y) * down_step;
  float per_radian = panorama_width / (2.0 * kPi);
  float u = middle_u + arc_tangent(ray.x, ray.z) * per_radian;
  // The part has more columns on either side than the picture shows.
  u += u < -0.5 ? panorama_width : 0.0;
  float v = middle_v - arc_tangent(ray.y, length(ray.xz)) * per_radian;
  vec4 across = weights(fract(u)), down = weights(fract(v));
  vec3 sum = vec3(0.0);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      if (across[i] * down[j] == 0.0) continue;
      sum += across[i] * down[j] * colour_at(int(floor(u)) - 1 + i, int(floor(v)) - 1 + j);
    }
  }
  uvec3 level = uvec3(clamp(sum, 0.0, 255.0) + 0.5);
  flat_picture[at.y * flat_size.x + at.x] = level.x | level.y << 8 | level.z << 16;
}
