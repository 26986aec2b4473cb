#include "simulator/room/noise.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace raywalk::simulator {
namespace {

// Odd constants that propagate changes of x, y or the seed into all upper bits.
constexpr std::uint32_t kStepX = 0x8da6b343U, kStepY = 0xd8163841U, kStepSeed = 0xcb1ab31fU;

// In [0, 1). Two rounds of multiplication and shifts mix well enough visually; called four times
// per octave, so it must be fast.
float unit_hash(std::uint32_t steps) {
  std::uint32_t hash = (steps ^ (steps >> 16)) * 0x7feb352dU;
  hash = (hash ^ (hash >> 15)) * 0x846ca68bU;
  return static_cast<float>(static_cast<std::int32_t>(hash >> 8)) * 0x1p-24F;
}

std::uint32_t lattice_steps(int x, int y, std::uint32_t seed) {
  return static_cast<std::uint32_t>(x) * kStepX + static_cast<std::uint32_t>(y) * kStepY +
         seed * kStepSeed;
}

// Faster than std::floor; only for values within the range of int.
int floor_to_int(float x) {
  const int towards_zero = static_cast<int>(x);
  return towards_zero - (static_cast<float>(towards_zero) > x ? 1 : 0);
}

float lerp(float a, float b, float share) { return a + share * (b - a); }

}  // namespace

float cell_value(int column, int row, std::uint32_t seed) {
  return unit_hash(lattice_steps(column, row, seed));
}

float value_noise(float x, float y, std::uint32_t seed) {
  const int column = floor_to_int(x), row = floor_to_int(y);
  const float fx = x - static_cast<float>(column), fy = y - static_cast<float>(row);
  // 3 f^2 - 2 f^3 has zero slope at both ends, so the noise is smooth across lattice lines.
  const float sx = fx * fx * (3.0F - 2.0F * fx), sy = fy * fy * (3.0F - 2.0F * fy);
  const std::uint32_t steps = lattice_steps(column, row, seed);
  const float bottom = lerp(unit_hash(steps), unit_hash(steps + kStepX), sx);
  const float top = lerp(unit_hash(steps + kStepY), unit_hash(steps + kStepX + kStepY), sx);
  return 2.0F * lerp(bottom, top, sy) - 1.0F;
}

float fractal_noise(const Eigen::Vector2f& at, const Octaves& octaves, float footprint,
                    std::uint32_t seed) {
  float wavelength = octaves.wavelength;
  float amplitude = 1.0F;
  float sum = 0.0F;
  for (int i = 0; i < octaves.count; ++i) {
    const float fade = std::clamp(wavelength / footprint - 1.0F, 0.0F, 1.0F);
    if (fade <= 0.0F) break;
    const float frequency = 1.0F / wavelength;
    sum +=
        amplitude * fade *
        value_noise(at.x() * frequency, at.y() * frequency, seed + static_cast<std::uint32_t>(i));
    amplitude *= octaves.persistence;
    wavelength *= 0.5F;
  }
  // The first octave alone reaches 1; higher persistence adds more.
  return sum * std::sqrt(1.0F - octaves.persistence * octaves.persistence);
}

float soft_step(float x, float footprint) { return std::clamp(x / footprint + 0.5F, 0.0F, 1.0F); }

float soft_stripe(float x, float half_width, float footprint) {
  return soft_step(x + half_width, footprint) - soft_step(x - half_width, footprint);
}

}  // namespace raywalk::simulator
