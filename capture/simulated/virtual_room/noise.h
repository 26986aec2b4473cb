// Band-limited noise in the plane, from which natural-looking surfaces are made.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace raywalk::capture {

// Value noise: smooth in [-1, 1], with one independent value at every whole position.
float value_noise(float x, float y, std::uint32_t seed);

// A value in [0, 1) for the cell (column, row) of a pattern.
float cell_value(int column, int row, std::uint32_t seed);

// A sum of octaves of value noise, each half as long as the one before.
struct Octaves {
  float wavelength = 1.0F;  // of the first octave
  int count = 6;
  float persistence = 0.6F;  // amplitude of an octave relative to the one before
};

// About in [-1, 1]. Octaves shorter than the pixel's footprint would only alias: an octave fades
// out while its wavelength falls from two footprints (the sampling theorem's limit) to one.
float fractal_noise(const Eigen::Vector2f& at, const Octaves& octaves, float footprint,
                    std::uint32_t seed);

// 0 below an edge at x = 0, 1 above it, with a ramp as wide as the pixel's footprint: the mean of a
// step over the pixel.
float soft_step(float x, float footprint);

// The mean over the pixel of a stripe |x| < half_width: its height falls as the footprint outgrows
// it, so that thin gaps darken evenly in the distance where they would else flicker.
float soft_stripe(float x, float half_width, float footprint);

}  // namespace raywalk::capture
