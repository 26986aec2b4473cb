// Points around a station and the pixels that show them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "build_lf/depth/matching_kernels.h"
#include "core/geometry/sphere.h"

namespace raywalk::build_lf {

// Up to a fixed number of points, located all at once: unlike pixel_of() for each, that is
// vectorised. The same object is filled again and again.
class LocatedPoints {
 public:
  explicit LocatedPoints(std::size_t capacity)
      : x_(capacity), y_(capacity), z_(capacity), length_(capacity), pixel_(capacity) {}

  // A point relative to the station, in world axes, at any scale; `i` is below the capacity.
  void set(std::size_t i, const Eigen::Vector3f& point) {
    x_[i] = point.x();
    y_[i] = point.y();
    z_[i] = point.z();
  }
  // Locates the first `count` points in a panorama of `size`.
  void locate(std::size_t count, PanoramaSize size) {
    matching_kernels().locate({x_.data(), y_.data(), z_.data(), static_cast<int>(count)},
                              size.width, size.height, pixel_.data(), length_.data());
  }

  // The pixel that shows point i (pixel_index), and the point's distance, at the scale it was set.
  std::size_t pixel(std::size_t i) const { return static_cast<std::size_t>(pixel_[i]); }
  float length(std::size_t i) const { return length_[i]; }

 private:
  std::vector<float> x_, y_, z_, length_;
  std::vector<std::int32_t> pixel_;
};

}  // namespace raywalk::build_lf
