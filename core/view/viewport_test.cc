#include "core/view/viewport.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/base/error.h"
#include "core/view/test_viewport.h"

namespace raywalk {
namespace {

constexpr PanoramaSize kPanorama{1024, 512};

Viewport turned(double yaw_deg, double pitch_deg, double roll_deg, double fov_deg) {
  return looking(yaw_deg, pitch_deg, roll_deg, fov_deg, 90, 70);
}

TEST(Viewport, RejectsInvalidPictures) {
  const Viewport good = turned(0, 0, 0, 90);
  EXPECT_NO_THROW(require_viewport(good));
  EXPECT_NO_THROW(require_viewport(turned(0, 0, 0, 170)));
  for (const double fov_deg : {0.0, -1.0, 170.1, 180.0, std::nan("")}) {
    EXPECT_THROW(require_viewport(turned(0, 0, 0, fov_deg)), UsageError) << fov_deg;
  }
  for (const int side : {0, -1, 16385}) {
    Viewport bad = good;
    bad.width = side;
    EXPECT_THROW(require_viewport(bad), UsageError);
    bad = good;
    bad.height = side;
    EXPECT_THROW(require_viewport(bad), UsageError);
  }
  EXPECT_THROW(require_viewport(turned(std::numeric_limits<double>::infinity(), 0, 0, 90)),
               UsageError);
}

// All four pixels around each of its rays, for any attitude, also over the poles and across the
// seam.
TEST(ViewportProperty, PartHoldsEverySampleOfThePicture) {
  std::mt19937_64 random(5);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int n = 0; n < 400; ++n) {
    const double fov_deg = std::pow(10.0, uniform(-1.0, std::log10(170.0)));
    const double pitch_deg = n % 4 == 0 ? (n % 8 == 0 ? 90.0 : -90.0) : uniform(-90.0, 90.0);
    const Viewport viewport = turned(n % 5 == 0 ? 180.0 : uniform(-400.0, 400.0), pitch_deg,
                                     uniform(-180.0, 180.0), std::min(fov_deg, 170.0));
    const PanoramaPart part = part_shown(viewport, kPanorama);
    ASSERT_GE(part.first_column, 0);
    ASSERT_LT(part.first_column, kPanorama.width);
    ASSERT_LE(part.columns, kPanorama.width);
    for (int column = 0; column < viewport.width; ++column) {
      for (int row = 0; row < viewport.height; ++row) {
        const PixelPosition at =
            pixel_from_angles(angles_from_direction(ray_of(viewport, column, row)), kPanorama);
        const double v = std::clamp(at.v, 0.0, kPanorama.height - 1.0);
        ASSERT_GE(std::floor(v), part.rows.begin);
        ASSERT_LT(std::min(std::floor(v) + 1.0, kPanorama.height - 1.0), part.rows.end);
        if (part.columns == kPanorama.width) continue;
        const int first = static_cast<int>(std::floor(at.u)) - part.first_column;
        const int within = (first % kPanorama.width + kPanorama.width) % kPanorama.width;
        ASSERT_LT(within + 1, part.columns) << "fov " << fov_deg << " pitch " << pitch_deg;
      }
    }
  }
}

// What is not shown is not rendered.
TEST(Viewport, PartIsNotMuchLargerThanThePicture) {
  const PanoramaPart part = part_shown(turned(180.0, 0.0, 0.0, 60.0), kPanorama);
  EXPECT_NEAR(part.columns, kPanorama.width / 6.0, 10.0);
  EXPECT_NEAR(part.first_column, kPanorama.width * 11.0 / 12.0, 8.0);
  const double half_rad = std::atan(70.0 / 90.0 * std::tan(radians_from_degrees(30.0)));
  EXPECT_NEAR(part.rows.end - part.rows.begin, 2.0 * half_rad / kPi * kPanorama.height, 10.0);
}

}  // namespace
}  // namespace raywalk
