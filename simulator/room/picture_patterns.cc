#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"
#include "simulator/room/noise.h"
#include "simulator/room/patterns.h"

namespace raywalk::capture {
namespace {

constexpr int kShapes = 7;

Color paint(int number, std::uint32_t seed) {
  const Color pure(cell_value(number, 11, seed), cell_value(number, 12, seed),
                   cell_value(number, 13, seed));
  // Limits the saturation, as of oil paint.
  return 0.65F * mix(pure.cwiseProduct(pure), Color(0.3F, 0.27F, 0.22F), 0.4F);
}

// Coverage of the pixel by a disc (even numbers) or a slanted bar (odd numbers); positions and
// sizes are relative to the picture's height.
float shape_cover(int number, const Eigen::Vector2f& at, float aspect, float footprint,
                  std::uint32_t seed) {
  const Eigen::Vector2f centre(aspect * cell_value(number, 1, seed), cell_value(number, 2, seed));
  const Eigen::Vector2f from = at - centre;
  const float size = 0.05F + 0.16F * cell_value(number, 3, seed);
  if (number % 2 == 0) return soft_step(size - from.norm(), footprint);
  const float turn = static_cast<float>(kPi) * cell_value(number, 4, seed);
  const float along = from.x() * std::cos(turn) + from.y() * std::sin(turn);
  const float across = from.y() * std::cos(turn) - from.x() * std::sin(turn);
  return soft_stripe(along, 2.2F * size, footprint) * soft_stripe(across, 0.3F * size, footprint);
}

}  // namespace

Color painting_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const float height = surface.extent.y();
  const Eigen::Vector2f relative = at / height;
  const float blur = footprint / height;
  const std::uint32_t seed = surface.seed;
  Color color = mix(surface.base, surface.accent, std::clamp(relative.y(), 0.0F, 1.0F));
  for (int ridge = 0; ridge < 3; ++ridge) {
    const auto own = seed + 300U + 20U * static_cast<std::uint32_t>(ridge);
    const float skyline = 0.62F - 0.2F * static_cast<float>(ridge) +
                          0.22F * fractal_noise({relative.x(), 0.5F}, {0.6F, 6, 0.55F}, blur, own);
    color = mix(color, paint(20 + ridge, seed), soft_step(skyline - relative.y(), blur));
  }
  for (int number = 0; number < kShapes; ++number) {
    const float cover = shape_cover(number, relative, surface.extent.x() / height, blur, seed);
    color = mix(color, paint(number, seed), cover);
  }
  const float brush = fractal_noise(relative, {0.15F, 5, 0.7F}, blur, seed + 400);
  return (color * (1.0F + 0.35F * brush)).cwiseMax(0.01F);
}

Color sky_light(const Eigen::Vector3d& direction, float pixel_rad, std::uint32_t seed) {
  const auto up = static_cast<float>(direction.y());
  const Eigen::Vector2f level(static_cast<float>(direction.x()), static_cast<float>(direction.z()));
  // Noise on the unit circle, which has no seam in longitude.
  const Eigen::Vector2f compass = level / std::max(level.norm(), 1e-6F);
  const float ridge = 0.04F + 0.05F * fractal_noise(compass, {0.5F, 7, 0.5F}, pixel_rad, seed + 7);
  const Color air =
      mix(Color(0.72F, 0.78F, 0.84F), Color(0.20F, 0.42F, 0.80F), std::sqrt(std::max(up, 0.0F)));
  // Clouds lie on a plane overhead and fade into haze towards the horizon.
  const float height = std::max(up, 0.05F);
  const float density =
      fractal_noise(level / height, {1.6F, 7, 0.6F}, pixel_rad / (height * height), seed);
  const float cover = std::clamp(1.6F * density + 0.35F, 0.0F, 1.0F);
  const Color sky = mix(air, Color(1.0F, 0.97F, 0.93F), cover);
  // Two noises, as each is stretched where the azimuth is along the other coordinate.
  const float trees = fractal_noise({compass.x(), up}, {0.06F, 5, 0.8F}, pixel_rad, seed + 30) +
                      fractal_noise({compass.y(), up}, {0.06F, 5, 0.8F}, pixel_rad, seed + 40);
  const Color land = Color(0.10F, 0.15F, 0.06F) * (1.0F + 0.5F * trees);
  return mix(sky, land, soft_step(ridge - up, std::max(pixel_rad, 0.001F)));
}

}  // namespace raywalk::capture
