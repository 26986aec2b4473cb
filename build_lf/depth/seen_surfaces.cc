#include "build_lf/depth/seen_surfaces.h"

#include <algorithm>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/located_points.h"

namespace raywalk::build_lf {

std::vector<float> seen_surfaces(std::span<const float> inverse, PanoramaSize size,
                                 const PixelDirections& directions,
                                 const Eigen::Vector3f& towards_m) {
  std::vector<float> seen(inverse.size(), -1.0f);
  const auto rows = static_cast<size_t>(size.height);
  LocatedPoints points(rows);
  for (int theta = 0; theta < size.width; ++theta) {
    const std::span<const float> column = inverse.subspan(pixel_index(theta, 0, size), rows);
    // The point at 1 / inverse along the ray, relative to the other station, times inverse.
    for (size_t phi = 0; phi < rows; ++phi) {
      points.set(phi, directions.of(theta, static_cast<int>(phi)) - column[phi] * towards_m);
    }
    points.locate(rows, size);
    for (size_t phi = 0; phi < rows; ++phi) {
      if (column[phi] < 0.0f) continue;
      float& nearest = seen[points.pixel(phi)];
      nearest = std::max(nearest, column[phi] / points.length(phi));
    }
  }
  return seen;
}

}  // namespace raywalk::build_lf
