#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"
#include "simulator/room/noise.h"
#include "simulator/room/patterns.h"

namespace raywalk::capture {
namespace {

// A position in a pattern of equal cells: the cell and the offset from its centre.
struct CellPosition {
  int index;
  float from_centre;
};

CellPosition cell_of(float at, float side) {
  const float cell = std::floor(at / side);
  return {static_cast<int>(cell), at - (cell + 0.5F) * side};
}

// Coverage of the pixel by the joint around a cell of the given half sides.
float joint_share(float from_x, float half_x, float from_y, float half_y, float half_joint,
                  float footprint) {
  const float in_x = 1.0F - soft_stripe(from_x, half_x - half_joint, footprint);
  const float in_y = 1.0F - soft_stripe(from_y, half_y - half_joint, footprint);
  return std::clamp(in_x + in_y - in_x * in_y, 0.0F, 1.0F);
}

// Hairline cracks: the zero crossings of a noise.
float cracks(const Eigen::Vector2f& at, float footprint, std::uint32_t seed) {
  constexpr float kHalfWidth = 0.003F;  // room units
  const float field = fractal_noise(at, {0.7F, 4, 0.55F}, footprint, seed);
  // The noise has a slope of about 3 per room unit at its zero crossings.
  return soft_stripe(field / 3.0F, kHalfWidth, std::max(footprint, kHalfWidth));
}

}  // namespace

Color plaster_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const float tint = fractal_noise(at, {1.1F, 2, 0.5F}, footprint, surface.seed);
  // Trowel strokes, three times as long as wide, over grain of all scales that a pixel resolves.
  const Eigen::Vector2f slanted(0.8F * at.x() + 0.6F * at.y(), 0.8F * at.y() - 0.6F * at.x());
  const float strokes = fractal_noise({slanted.x() / 3.0F, slanted.y()}, {0.09F, 3, 0.75F},
                                      footprint, surface.seed + 30);
  const float grain = fractal_noise(at, {0.08F, 5, 0.9F}, footprint, surface.seed + 60);
  const Color color = mix(surface.base, surface.accent, std::clamp(0.5F + 0.5F * tint, 0.0F, 1.0F));
  const float relief = 1.0F + 0.22F * strokes + 0.5F * grain;
  const float dark = 0.3F * cracks(at, footprint, surface.seed + 90);
  return color * std::max(relief * (1.0F - dark), 0.05F);
}

Color brick_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const float height = 0.3F * surface.period, half_joint = 0.02F * surface.period;
  const CellPosition row = cell_of(at.y(), height);
  // Courses are offset by half a brick, with irregularities.
  const float shift =
      (row.index % 2 == 0 ? 0.0F : 0.5F) + 0.15F * (cell_value(row.index, 0, surface.seed) - 0.5F);
  const CellPosition brick = cell_of(at.x() + shift * surface.period, surface.period);
  const float wobble =
      0.02F * surface.period * fractal_noise(at, {0.08F, 2, 0.5F}, footprint, surface.seed + 5);
  const float mortar = joint_share(brick.from_centre + wobble, 0.5F * surface.period,
                                   row.from_centre + wobble, 0.5F * height, half_joint, footprint);
  const float tint = cell_value(brick.index, row.index, surface.seed + 1);
  const float shade = 0.65F + 0.6F * cell_value(brick.index, row.index, surface.seed + 2);
  const float rough = fractal_noise(at, {0.1F, 5, 0.7F}, footprint, surface.seed + 3);
  const Color clay = mix(surface.base, surface.accent, tint) * shade * (1.0F + 0.35F * rough);
  const Color joint = Color(0.55F, 0.52F, 0.47F) * (1.0F + 0.25F * rough);
  return mix(clay, joint, mortar).cwiseMax(0.02F);
}

Color wallpaper_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const auto wave = static_cast<float>(kTwoPi) / surface.period;
  const float s = wave * at.x(), t = 0.5F * wave * at.y();
  // Sums of cosines whose level lines form the bulbs and stems of a damask pattern.
  const float ogee =
      std::cos(s) * std::cos(t) + 0.35F * std::cos(2.0F * s) + 0.35F * std::cos(3.0F * t);
  const float petals = std::cos(2.0F * s + 1.5F * std::sin(2.0F * t)) * std::cos(4.0F * t);
  // The soft step at a level line needs the footprint in units of the level; its slope is about
  // `wave`.
  const float blur = std::max(wave * footprint, 0.05F);
  const float bulb = soft_step(ogee - 0.25F, blur);
  const float leaf = soft_step(petals - 0.45F, 2.0F * blur) * (1.0F - bulb);
  const float heart = soft_step(ogee - 0.95F, blur);
  const Color ground = mix(surface.base, surface.accent, 0.75F * bulb + 0.45F * leaf);
  return mix(ground, 0.5F * (surface.base + Color(0.6F, 0.5F, 0.3F)), heart);
}

Color board_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const float width = surface.period, length = 9.0F * width;
  const CellPosition row = cell_of(at.y(), width);
  const float shift = length * cell_value(row.index, 7, surface.seed);
  const CellPosition board = cell_of(at.x() + shift, length);
  const float gap = joint_share(board.from_centre, 0.5F * length, row.from_centre, 0.5F * width,
                                0.012F * width, footprint);
  Surface plank = surface;
  plank.base =
      mix(surface.base, surface.accent, cell_value(board.index, row.index, surface.seed + 1)) *
      (0.7F + 0.55F * cell_value(board.index, row.index, surface.seed + 2));
  plank.accent = 0.5F * plank.base;
  plank.seed = surface.seed + 16U * static_cast<std::uint32_t>(row.index) +
               1031U * static_cast<std::uint32_t>(board.index);
  return mix(wood_albedo(plank, at, footprint), 0.15F * surface.base, gap);
}

Color tile_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  const CellPosition x = cell_of(at.x(), surface.period), y = cell_of(at.y(), surface.period);
  const float grout = joint_share(x.from_centre, 0.5F * surface.period, y.from_centre,
                                  0.5F * surface.period, 0.012F * surface.period, footprint);
  const bool odd = (x.index + y.index) % 2 != 0;
  const Color ground = (odd ? surface.base : surface.accent) *
                       (0.8F + 0.35F * cell_value(x.index, y.index, surface.seed));
  // Veins: the zero crossings of a noise, different for every tile.
  const auto own = surface.seed + 31U * static_cast<std::uint32_t>(x.index) +
                   977U * static_cast<std::uint32_t>(y.index);
  const float field = fractal_noise(at, {0.35F, 6, 0.6F}, footprint, own);
  const float vein = soft_stripe(field, 0.035F, std::max(5.0F * footprint, 0.05F));
  const float cloud = fractal_noise(at, {0.12F, 5, 0.65F}, footprint, own + 64);
  const Color stone = ground * (1.0F + 0.3F * cloud) * (1.0F - 0.45F * vein);
  return mix(stone, Color(0.3F, 0.29F, 0.27F), grout).cwiseMax(0.02F);
}

}  // namespace raywalk::capture
