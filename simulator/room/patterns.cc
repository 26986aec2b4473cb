// The patterns of surfaces. Their arguments are those of albedo_at (surface.h).
#include <algorithm>
#include <cmath>

#include "core/geometry/sphere.h"
#include "simulator/room/noise.h"
#include "simulator/room/surface.h"

namespace raywalk::simulator {
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

// Hairline cracks: the zero intersections of a noise.
float cracks(const Eigen::Vector2f& at, float footprint, std::uint32_t seed) {
  constexpr float kHalfWidth = 0.003F;  // room units
  const float field = fractal_noise(at, {0.7F, 4, 0.55F}, footprint, seed);
  // The noise has a slope of about 3 per room unit at its zero intersections.
  return soft_stripe(field / 3.0F, kHalfWidth, std::max(footprint, kHalfWidth));
}

// Signed distance to the nearest multiple of `period`.
float from_nearest(float x, float period) { return x - period * std::round(x / period); }

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
  // Veins: the zero intersections of a noise, different for every tile.
  const auto own = surface.seed + 31U * static_cast<std::uint32_t>(x.index) +
                   977U * static_cast<std::uint32_t>(y.index);
  const float field = fractal_noise(at, {0.35F, 6, 0.6F}, footprint, own);
  const float vein = soft_stripe(field, 0.035F, std::max(5.0F * footprint, 0.05F));
  const float cloud = fractal_noise(at, {0.12F, 5, 0.65F}, footprint, own + 64);
  const Color stone = ground * (1.0F + 0.3F * cloud) * (1.0F - 0.45F * vein);
  return mix(stone, Color(0.3F, 0.29F, 0.27F), grout).cwiseMax(0.02F);
}

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

Color plain_albedo(const Surface& surface, const Eigen::Vector2f& /*at*/, float /*footprint*/) {
  return surface.base;
}

Color picture_albedo(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  return surface.picture->at(at.cwiseQuotient(surface.extent), footprint / surface.extent.x());
}

Color black(const Surface& /*surface*/, const Eigen::Vector2f& /*at*/, float /*footprint*/) {
  return Color::Zero();
}

struct PatternEntry {
  const char* name;
  Color (*albedo)(const Surface& surface, const Eigen::Vector2f& at, float footprint);
};

// In the order of Pattern.
constexpr std::array<PatternEntry, kPatterns.size()> kPatternTable{{{"plain", plain_albedo},
                                                                    {"plaster", plaster_albedo},
                                                                    {"bricks", brick_albedo},
                                                                    {"wallpaper", wallpaper_albedo},
                                                                    {"boards", board_albedo},
                                                                    {"tiles", tile_albedo},
                                                                    {"wood", wood_albedo},
                                                                    {"fabric", fabric_albedo},
                                                                    {"rug", rug_albedo},
                                                                    {"book", book_albedo},
                                                                    {"leaf", leaf_albedo},
                                                                    {"painting", painting_albedo},
                                                                    {"picture", picture_albedo},
                                                                    {"lamp", lamp_emission},
                                                                    {"sky", black},
                                                                    {"mirror", black},
                                                                    {"glass", black}}};

const PatternEntry& entry_of(Pattern pattern) {
  return kPatternTable[static_cast<std::size_t>(pattern)];
}

}  // namespace

const char* name_of(Pattern pattern) { return entry_of(pattern).name; }

Color albedo_at(const Surface& surface, const Eigen::Vector2f& at, float footprint) {
  return entry_of(surface.pattern).albedo(surface, at, footprint);
}

Color mean_albedo(const Surface& surface) {
  constexpr int kSide = 12;
  Color sum = Color::Zero();
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const Eigen::Vector2f share((static_cast<float>(i) + 0.5F) / kSide,
                                  (static_cast<float>(j) + 0.5F) / kSide);
      sum += albedo_at(surface, share.cwiseProduct(surface.extent), 0.02F);
    }
  }
  return sum / static_cast<float>(kSide * kSide);
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

}  // namespace raywalk::simulator
