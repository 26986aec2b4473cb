// Band-limited procedural noise in the plane.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace raywalk::simulator {

// Value noise: smooth, in [-1, 1], with an independent value at every integer position.
float value_noise(float x, float y, std::uint32_t seed);

// A random value in [0, 1) for the cell (column, row) of a pattern.
float cell_value(int column, int row, std::uint32_t seed);

// A sum of octaves of value noise, each with half the wavelength of the one before.
struct Octaves {
  float wavelength = 1.0F;  // of the first octave
  int count = 6;
  float persistence = 0.6F;  // amplitude of an octave relative to the one before
};

// Approximately in [-1, 1]. To avoid aliasing, an octave fades out while its wavelength falls from
// two pixel footprints (the Nyquist limit) to one.
float fractal_noise(const Eigen::Vector2f& at, const Octaves& octaves, float footprint,
                    std::uint32_t seed);

// The mean over the pixel of a step at x = 0 from 0 to 1: a ramp as wide as the footprint.
float soft_step(float x, float footprint);

// The mean over the pixel of a stripe |x| < half_width. Its contrast falls as the footprint exceeds
// it, so that thin gaps do not alias in the distance.
float soft_stripe(float x, float half_width, float footprint);

}  // namespace raywalk::simulator
