#include "core/geometry/panorama_pixels.h"

#include <gtest/gtest.h>

namespace raywalk {
namespace {

constexpr PanoramaSize kSize{64, 32};

// Bilinear interpolation of the directions of the pixel centres.
Eigen::Vector3d interpolated_direction(PixelPosition position) {
  const PixelsAround around = pixels_around(position, kSize);
  Eigen::Vector3d sum(0, 0, 0);
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      const PixelPosition centre{double(around.column[i]), double(around.row[j])};
      sum += around.weight(i, j) * direction_from_angles(angles_from_pixel(centre, kSize));
    }
  }
  return sum;
}

TEST(WrappedColumn, GoesRound) {
  EXPECT_EQ(wrapped_column(-1, 8), 7);
  EXPECT_EQ(wrapped_column(0, 8), 0);
  EXPECT_EQ(wrapped_column(8, 8), 0);
  EXPECT_EQ(wrapped_column(-17, 8), 7);
}

TEST(PixelsAround, AtACentreThatPixelCountsAlone) {
  const PixelsAround around = pixels_around({63.0, 5.0}, kSize);
  EXPECT_EQ(around.nearest_column(), 63);
  EXPECT_EQ(around.nearest_row(), 5);
  EXPECT_EQ(around.weight(0, 0), 1.0);
}

TEST(PixelsAround, SpanTheSeam) {
  for (const double u : {-0.25, 63.75}) {
    const PixelsAround around = pixels_around({u, 5.0}, kSize);
    EXPECT_EQ(around.column, (std::array{63, 0})) << u;
    EXPECT_EQ(around.nearest_column(), 0) << u;
    EXPECT_EQ(around.part_u, 0.75) << u;
  }
}

TEST(PixelsAround, EndAtThePoles) {
  EXPECT_EQ(pixels_around({3.0, -0.5}, kSize).row, (std::array{0, 0}));
  EXPECT_EQ(pixels_around({3.0, 31.5}, kSize).row, (std::array{31, 31}));
}

TEST(PixelsAround, InterpolateEveryDirection) {
  const double pixel_rad = kTwoPi / kSize.width;
  for (double phi = -90.0; phi <= 90.0; phi += 1.5) {
    for (double theta = -180.0; theta < 180.0; theta += 2.25) {
      const SphereAngles angles{radians_from_degrees(theta), radians_from_degrees(phi)};
      const PixelPosition position = pixel_from_angles(angles, kSize);
      const PixelsAround around = pixels_around(position, kSize);
      double sum = 0.0;
      for (std::size_t i = 0; i < 2; ++i) {
        for (std::size_t j = 0; j < 2; ++j) sum += around.weight(i, j);
      }
      EXPECT_NEAR(sum, 1.0, 1e-12);
      // Half a row at a pole, where the row next to it stands for the pole.
      EXPECT_LT((interpolated_direction(position) - direction_from_angles(angles)).norm(),
                0.51 * pixel_rad)
          << theta << " " << phi;
    }
  }
}

}  // namespace
}  // namespace raywalk
