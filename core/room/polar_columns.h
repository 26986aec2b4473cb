// Rows near the poles of a panorama, and where they are stored.
//
// Towards the poles the columns of a panorama converge until one output pixel covers hundreds of
// them. Views interpolate rows there between columns up to 16 apart (PolarColumns). In the columns
// themselves these rows are a few bytes at both ends of every second to sixteenth column, so that a
// view would read a page of the disk for each. A line volume therefore holds them a second time,
// closed up (PolarPart): 5 to 6 % more bytes, of which a view reads all that it touches.
//
// Plain structs only: the kernels, which are compiled for several processors, include this.
#pragma once

#include <cstdint>

namespace raywalk {

// Samples within rows[k] rows of a pole are interpolated between columns 2 << k apart, at multiples
// of that. rows falls with k; 0 disables a level.
struct PolarColumns {
  static constexpr int kMaxDoublings = 4;
  int rows[kMaxDoublings] = {};
};

// log2 of the distance between the columns that a sample with upper row `upper` is interpolated
// from.
constexpr int polar_doublings(const PolarColumns& polar, int upper, int height) {
  const int below = height - 2 - upper;
  const int from_pole = upper < below ? upper : below;
  int doublings = 0;
  for (const int rows : polar.rows) doublings += from_pole < rows ? 1 : 0;
  return doublings;
}

// Where the pixels of a station's rays are: row `upper` of column u, a multiple of 2^doublings, is
//   (u >> doublings) * stride[doublings] + 3 * upper + start
// bytes from the first ray, where start is south[doublings] in the lower half, else north. Eight
// levels fill a vector register; five are used.
struct RayLayout {
  static constexpr int kLevels = 8;
  PolarColumns polar{};
  std::int32_t stride[kLevels] = {};
  std::int32_t north[kLevels] = {};
  std::int32_t south[kLevels] = {};
};

constexpr bool is_southern(int upper, int height) { return height - 2 - upper < upper; }

constexpr std::int32_t ray_offset(const RayLayout& layout, int doublings, int u, int upper,
                                  int height) {
  return (u >> doublings) * layout.stride[doublings] + 3 * upper +
         (is_southern(upper, height) ? layout.south[doublings] : layout.north[doublings]);
}

}  // namespace raywalk
