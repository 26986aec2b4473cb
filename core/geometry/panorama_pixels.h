// Pixels of a panorama around a position: columns go round at the seam, rows end at the poles.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/sphere.h"

namespace raywalk {

// A column in [0, width) for any column counted on across the seam.
constexpr int wrapped_column(int u, int width) { return (u % width + width) % width; }

// The 2 x 2 pixels around a position and its place between their centres.
struct PixelsAround {
  std::array<int, 2> column{};  // left and right, each in [0, width)
  std::array<int, 2> row{};     // upper and lower, each in [0, height); the same one at a pole
  double part_u = 0.0;          // from the left to the right centre, in [0, 1)
  double part_v = 0.0;          // from the upper to the lower centre, in [0, 1)

  // Of the pixel in column[i] and row[j] in bilinear interpolation; the four add up to 1.
  double weight(std::size_t i, std::size_t j) const {
    return (i == 0 ? 1.0 - part_u : part_u) * (j == 0 ? 1.0 - part_v : part_v);
  }
  int nearest_column() const { return column[part_u < 0.5 ? 0 : 1]; }
  int nearest_row() const { return row[part_v < 0.5 ? 0 : 1]; }
};

// Any position; a row beyond a pole counts as the row next to the pole.
inline PixelsAround pixels_around(PixelPosition position, PanoramaSize size) {
  const double left = std::floor(position.u), upper = std::floor(position.v);
  const int u = static_cast<int>(left), v = static_cast<int>(upper);
  return {.column = {wrapped_column(u, size.width), wrapped_column(u + 1, size.width)},
          .row = {std::clamp(v, 0, size.height - 1), std::clamp(v + 1, 0, size.height - 1)},
          .part_u = position.u - left,
          .part_v = position.v - upper};
}

}  // namespace raywalk
