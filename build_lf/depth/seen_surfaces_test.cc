#include "build_lf/depth/seen_surfaces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "build_lf/depth/inverse_distance_map.h"

namespace raywalk::build_lf {
namespace {

constexpr PanoramaSize kSize{256, 128};

// Inverse distances from `at_m` to the inside of a sphere of radius 1 m about the origin.
float sphere_omega(const Eigen::Vector3d& direction, const Eigen::Vector3d& at_m) {
  const double along = at_m.dot(direction);
  return static_cast<float>(1.0 / (-along + std::sqrt(along * along + 1.0 - at_m.squaredNorm())));
}

Eigen::Vector3d direction_of(int theta, int phi) {
  return direction_from_angles(angles_from_pixel({double(theta), double(phi)}, kSize));
}

std::vector<float> sphere_map(const Eigen::Vector3d& at_m) {
  std::vector<float> omega;
  for (int theta = 0; theta < kSize.width; ++theta) {
    for (int phi = 0; phi < kSize.height; ++phi) {
      omega.push_back(sphere_omega(direction_of(theta, phi), at_m));
    }
  }
  return omega;
}

TEST(SeenSurfacesTest, AreWhereTheOtherStationSeesThem) {
  const Eigen::Vector3d from_m(0.1, 0.0, -0.2);
  const Eigen::Vector3d to_m(-0.15, 0.05, 0.1);
  const auto seen = seen_surfaces(sphere_map(from_m), kSize, PixelDirections(kSize),
                                  (to_m - from_m).cast<float>());
  size_t found = 0;
  for (int theta = 0; theta < kSize.width; ++theta) {
    for (int phi = 0; phi < kSize.height; ++phi) {
      const float omega = seen[pixel_index(theta, phi, kSize)];
      if (omega < 0.0f) continue;  // no point fell into this pixel
      ++found;
      // Within half a pixel, on a sphere whose inverse distance changes by less than 1/m per
      // radian.
      ASSERT_NEAR(omega, sphere_omega(direction_of(theta, phi), to_m), kTwoPi / kSize.width);
    }
  }
  EXPECT_GT(found, seen.size() / 2);
}

TEST(SeenSurfacesTest, ShowTheNearestAndLeaveOutWhatIsNone) {
  std::vector<float> omega(size_t(kSize.width) * kSize.height, -1.0f);
  const auto none = seen_surfaces(omega, kSize, PixelDirections(kSize), {0.3f, 0.0f, 0.0f});
  EXPECT_EQ(std::count(none.begin(), none.end(), -1.0f), std::ptrdiff_t(none.size()));
  // Infinitely far points stay in their pixels wherever the station is.
  std::fill(omega.begin(), omega.end(), 0.0f);
  const auto far = seen_surfaces(omega, kSize, PixelDirections(kSize), {0.3f, 0.0f, 0.0f});
  EXPECT_EQ(far, omega);
  // 1 m to the right of the map's station; from 0.5 m behind that it hides what is far behind it.
  const size_t right = pixel_index(3 * kSize.width / 4, kSize.height / 2, kSize);
  omega[right] = 1.0f;
  const auto hidden = seen_surfaces(omega, kSize, PixelDirections(kSize), {-0.5f, 0.0f, 0.0f});
  EXPECT_NEAR(hidden[right], 1.0 / 1.5, 1e-3);
}

}  // namespace
}  // namespace raywalk::build_lf
