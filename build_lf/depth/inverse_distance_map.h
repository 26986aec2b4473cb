// The inverse distances of one station, in world axes.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {

// Index of a pixel in the vectors of a map.
inline std::size_t pixel_index(int theta, int phi, PanoramaSize size) {
  return static_cast<std::size_t>(theta) * static_cast<std::size_t>(size.height) +
         static_cast<std::size_t>(phi);
}

// Inverse distances are along the ray, 1/m; 0 is infinitely far. Parallax is proportional to them,
// so their errors are those visible in a rendered view.
struct InverseDistanceMap {
  StationIndex station;
  Eigen::Vector3d position_m{0, 0, 0};
  PanoramaSize size;
  std::vector<float> inverse;            // [theta][phi], 0 or larger
  std::vector<std::uint8_t> confidence;  // [theta][phi], 0 unknown to 255 certain
};

}  // namespace raywalk::build_lf
