#include <algorithm>
#include <cmath>

#include "simulator/room/noise.h"
#include "simulator/room/patterns.h"

namespace raywalk::capture {
namespace {

// Signed distance to the nearest multiple of `period`.
float from_nearest(float x, float period) { return x - period * std::round(x / period); }

}  // namespace

Color wood_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  // Grain is noise stretched eight times along the trunk and distorted by a slower noise.
  const float bend = value_noise(3.0F * at.x(), 3.0F * at.y(), surface.seed + 40);
  const Eigen::Vector2f stretched(0.125F * at.x(), at.y() + 0.02F * bend);
  const float grain = fractal_noise(stretched, {0.06F, 5, 0.8F}, footprint, surface.seed);
  const float pores =
      fractal_noise({0.3F * at.x(), at.y()}, {0.03F, 3, 0.8F}, footprint, surface.seed + 20);
  const float dark = std::clamp(0.38F + 0.55F * grain + 0.22F * pores, 0.0F, 1.0F);
  return mix(surface.base, surface.accent, dark);
}

Color fabric_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const float stripe =
      soft_stripe(from_nearest(at.x(), surface.period), 0.2F * surface.period, footprint);
  const float thin =
      soft_stripe(from_nearest(at.y(), surface.period), 0.06F * surface.period, footprint);
  const float weave = fractal_noise(at, {0.05F, 5, 0.9F}, footprint, surface.seed);
  const Color dyed = mix(surface.base, surface.accent, std::max(stripe, 0.7F * thin));
  return (dyed * (1.0F + 0.3F * weave)).cwiseMax(0.02F);
}

Color rug_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const Eigen::Vector2f to_rim = at.cwiseMin(surface.extent - at);
  const float rim = std::min(to_rim.x(), to_rim.y());
  const float border = soft_stripe(rim - 0.11F, 0.035F, footprint);
  const float field = soft_step(rim - 0.2F, footprint);
  const float across = from_nearest(at.x(), surface.period),
              along = from_nearest(at.y(), 1.4F * surface.period);
  const float diamond = 0.42F * surface.period - std::abs(across) - 0.7F * std::abs(along);
  const float pattern = field * (soft_step(diamond, footprint) -
                                 0.6F * soft_step(diamond - 0.18F * surface.period, footprint));
  const float pile = fractal_noise(at, {0.06F, 5, 0.9F}, footprint, surface.seed);
  const Color dyed = mix(surface.base, surface.accent, std::clamp(border + pattern, 0.0F, 1.0F));
  return (dyed * (1.0F + 0.35F * pile)).cwiseMax(0.015F);
}

Color book_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const float height = surface.extent.y();
  const float low = 0.12F + 0.1F * cell_value(0, 0, surface.seed);
  const float bands = soft_stripe(at.y() - low * height, 0.02F * height, footprint) +
                      soft_stripe(at.y() - (1.0F - low) * height, 0.02F * height, footprint);
  // An illegible title: blocks of random darkness as tall as letters.
  const float letter = 0.05F * height;
  const int line = static_cast<int>(std::floor(at.y() / letter));
  const bool titled = at.y() > 0.35F * height && at.y() < 0.75F * height;
  const float off_centre = std::abs(at.x() / surface.extent.x() - 0.5F);
  const float ink = titled && off_centre < 0.28F && footprint < letter
                        ? cell_value(line, 1, surface.seed + 1)
                        : 0.0F;
  const float worn = fractal_noise(at, {0.08F, 4, 0.7F}, footprint, surface.seed + 2);
  const Color cloth = mix(surface.base, surface.accent, std::clamp(bands + ink, 0.0F, 1.0F));
  return (cloth * (1.0F + 0.22F * worn)).cwiseMax(0.015F);
}

Color leaf_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const float off_axis = std::abs(at.x() - 0.5F * surface.extent.x());
  const float middle = soft_stripe(off_axis, 0.04F * surface.extent.x(), footprint);
  const float side =
      soft_stripe(from_nearest(at.y() - off_axis, 0.03F), 0.003F, std::max(footprint, 0.002F));
  const float mottle = fractal_noise(at, {0.07F, 3, 0.6F}, footprint, surface.seed);
  const Color green = surface.base * (1.0F + 0.35F * mottle);
  return mix(green, surface.accent, std::clamp(middle + 0.4F * side, 0.0F, 1.0F)).cwiseMax(0.01F);
}

Color lamp_emission(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const float rib = soft_stripe(from_nearest(at.y(), surface.period), 0.09F * surface.period,
                                std::max(footprint, 0.05F * surface.period));
  const float paper = fractal_noise(at, {0.1F, 4, 0.6F}, footprint, surface.seed);
  return surface.base * (1.0F - 0.35F * rib) * (1.0F + 0.12F * paper);
}

}  // namespace raywalk::capture
