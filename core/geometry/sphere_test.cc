#include "core/geometry/sphere.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <random>

#include "core/geometry/eye_circle.h"
#include "core/geometry/fast_math.h"
#include "core/geometry/fisheye_lens.h"
#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

using Eigen::Vector3d;

constexpr double kTolerance = 1e-14;

void expect_near(const Vector3d& actual, const Vector3d& expected) {
  EXPECT_LT((actual - expected).norm(), kTolerance)
      << "actual " << actual.transpose() << ", expected " << expected.transpose();
}

Vector3d random_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

TEST(WrapAngle, StaysInRangeWithItsLowerEndAndKeepsTheDirection) {
  EXPECT_EQ(wrap_angle(0.0), 0.0);
  EXPECT_EQ(wrap_angle(kPi), -kPi);
  EXPECT_EQ(wrap_angle(-kPi), -kPi);
  EXPECT_EQ(wrap_angle(kTwoPi), 0.0);
  EXPECT_EQ(wrap_angle(1.5), 1.5);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-1000.0, 1000.0);
  for (int i = 0; i < 10000; ++i) {
    const double a = angle(random);
    const double w = wrap_angle(a);
    EXPECT_GE(w, -kPi);
    EXPECT_LT(w, kPi);
    EXPECT_NEAR(std::sin(w), std::sin(a), 1e-12);
    EXPECT_NEAR(std::cos(w), std::cos(a), 1e-12);
  }
}

TEST(Direction, FollowsTheWorldFrame) {
  expect_near(direction_from_angles({0.0, 0.0}), Vector3d::UnitZ());
  expect_near(direction_from_angles({kHalfPi, 0.0}), Vector3d::UnitX());
  expect_near(direction_from_angles({-kHalfPi, 0.0}), -Vector3d::UnitX());
  expect_near(direction_from_angles({-kPi, 0.0}), -Vector3d::UnitZ());
  expect_near(direction_from_angles({1.0, kHalfPi}), Vector3d::UnitY());
  expect_near(direction_from_angles({1.0, -kHalfPi}), -Vector3d::UnitY());
}

TEST(Direction, RoundTripsAtAnyLength) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> exponent(-150.0, 150.0);
  for (int i = 0; i < 10000; ++i) {
    const Vector3d direction = random_direction(random);
    const SphereAngles angles = angles_from_direction(direction * std::pow(10.0, exponent(random)));
    EXPECT_GE(angles.theta_rad, -kPi);
    EXPECT_LT(angles.theta_rad, kPi);
    EXPECT_LE(std::abs(angles.phi_rad), kHalfPi);
    expect_near(direction_from_angles(angles), direction);
  }
}

TEST(Direction, IsExactAtAndBesideThePolesAndBackwards) {
  for (const double x : {0.0, -0.0}) {
    for (const double z : {0.0, -0.0}) {
      EXPECT_EQ(angles_from_direction({x, 2.0, z}).theta_rad, 0.0);
      EXPECT_EQ(angles_from_direction({x, 2.0, z}).phi_rad, kHalfPi);
      EXPECT_EQ(angles_from_direction({x, -2.0, z}).phi_rad, -kHalfPi);
    }
    EXPECT_EQ(angles_from_direction({x, 0.0, -1.0}).theta_rad, -kPi);
  }
  // asin(y) would return exactly pi / 2 here.
  EXPECT_NEAR(kHalfPi - angles_from_direction({0.0, 1.0, 1e-9}).phi_rad, 1e-9, 1e-15);
}

TEST(Pixel, CentresAreHalfAPixelInsideAndBordersAreExact) {
  constexpr PanoramaSize size{360, 180};
  for (const double sign : {-1.0, 1.0}) {
    const PixelPosition corner{179.5 + sign * 179.5, 89.5 - sign * 89.5};
    const SphereAngles angles = angles_from_pixel(corner, size);
    EXPECT_NEAR(degrees_from_radians(angles.theta_rad), sign * 179.5, 1e-12);
    EXPECT_NEAR(degrees_from_radians(angles.phi_rad), sign * 89.5, 1e-12);
  }
  EXPECT_EQ(angles_from_pixel({179.5, 89.5}, size).theta_rad, 0.0);
  EXPECT_EQ(angles_from_pixel({179.5, 89.5}, size).phi_rad, 0.0);
  EXPECT_EQ(angles_from_pixel({-0.5, -0.5}, size).theta_rad, -kPi);
  EXPECT_EQ(angles_from_pixel({-0.5, -0.5}, size).phi_rad, kHalfPi);
  EXPECT_EQ(angles_from_pixel({-0.5, 179.5}, size).phi_rad, -kHalfPi);
  // The right border is the left one.
  EXPECT_EQ(angles_from_pixel({359.5, 0.0}, size).theta_rad, -kPi);
}

TEST(Pixel, MirroredPixelsHaveExactlyMirroredAngles) {
  constexpr PanoramaSize size{1000, 500};
  for (int u = 0; u < size.width; ++u) {
    EXPECT_EQ(angles_from_pixel({1.0 * u, 0.0}, size).theta_rad,
              -angles_from_pixel({size.width - 1.0 - u, 0.0}, size).theta_rad);
  }
  for (int v = 0; v < size.height; ++v) {
    EXPECT_EQ(angles_from_pixel({0.0, 1.0 * v}, size).phi_rad,
              -angles_from_pixel({0.0, size.height - 1.0 - v}, size).phi_rad);
  }
}

TEST(Pixel, RoundTripsOverTheWholePanorama) {
  constexpr PanoramaSize size{720, 360};
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> across(-0.5, size.width - 0.5);
  std::uniform_real_distribution<double> down(-0.5, size.height - 0.5);
  for (int i = 0; i < 10000; ++i) {
    const PixelPosition pixel{across(random), down(random)};
    const PixelPosition back = pixel_from_angles(angles_from_pixel(pixel, size), size);
    EXPECT_NEAR(back.u, pixel.u, 1e-11);
    EXPECT_NEAR(back.v, pixel.v, 1e-11);
  }
}

TEST(Attitude, YawTurnsToXPitchRaisesAndRollTipsUpToTheRightInThatOrder) {
  const double a = 0.3, sine = std::sin(a), cosine = std::cos(a);
  const Eigen::Matrix3d yaw = world_from_camera({.yaw_rad = a});
  const Eigen::Matrix3d pitch = world_from_camera({.pitch_rad = a});
  const Eigen::Matrix3d roll = world_from_camera({.roll_rad = a});
  expect_near(yaw * Vector3d::UnitZ(), {sine, 0.0, cosine});
  expect_near(pitch * Vector3d::UnitZ(), {0.0, sine, cosine});
  expect_near(roll * Vector3d::UnitY(), {sine, cosine, 0.0});
  EXPECT_LT((world_from_camera({a, a, a}) - yaw * pitch * roll).norm(), kTolerance);
}

TEST(Attitude, IsAProperRotationAndReadFromItUpToTheZenith) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> angle(-kPi, kPi), exponent(-12.0, 0.0);
  for (int i = 0; i < 2000; ++i) {
    // Half of the pitches lie near the zenith or the nadir, down to 1e-12 rad from it.
    double pitch = angle(random);
    if (i % 2 == 0) pitch = std::copysign(kHalfPi - std::pow(10.0, exponent(random)), pitch);
    const Eigen::Matrix3d rotation = world_from_camera({angle(random), pitch, angle(random)});
    EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), kTolerance);
    EXPECT_NEAR(rotation.determinant(), 1.0, kTolerance);
    const Eigen::Matrix3d again = world_from_camera(attitude_from_world_from_camera(rotation));
    EXPECT_LT((again - rotation).norm(), 1e-11) << "pitch " << pitch;
  }
  const Attitude same = attitude_from_world_from_camera(world_from_camera({0.3, -0.2, 0.1}));
  EXPECT_NEAR(same.yaw_rad, 0.3, kTolerance);
  EXPECT_NEAR(same.pitch_rad, -0.2, kTolerance);
  EXPECT_NEAR(same.roll_rad, 0.1, kTolerance);
}

constexpr PanoramaSize kSize{64, 32};

TEST(PixelsAround, GoRoundAtTheSeamAndEndAtThePoles) {
  EXPECT_EQ(wrapped_column(-1, 8), 7);
  EXPECT_EQ(wrapped_column(8, 8), 0);
  EXPECT_EQ(wrapped_column(-17, 8), 7);
  const PixelsAround at_centre = pixels_around({63.0, 5.0}, kSize);
  EXPECT_EQ(at_centre.nearest_column(), 63);
  EXPECT_EQ(at_centre.nearest_row(), 5);
  EXPECT_EQ(at_centre.weight(0, 0), 1.0);
  for (const double u : {-0.25, 63.75}) {
    const PixelsAround around = pixels_around({u, 5.0}, kSize);
    EXPECT_EQ(around.column, (std::array{63, 0})) << u;
    EXPECT_EQ(around.nearest_column(), 0) << u;
    EXPECT_EQ(around.part_u, 0.75) << u;
  }
  EXPECT_EQ(pixels_around({3.0, -0.5}, kSize).row, (std::array{0, 0}));
  EXPECT_EQ(pixels_around({3.0, 31.5}, kSize).row, (std::array{31, 31}));
}

TEST(PixelsAround, InterpolateEveryDirection) {
  const double pixel_rad = kTwoPi / kSize.width;
  for (double phi = -90.0; phi <= 90.0; phi += 1.5) {
    for (double theta = -180.0; theta < 180.0; theta += 2.25) {
      const SphereAngles angles{radians_from_degrees(theta), radians_from_degrees(phi)};
      const PixelsAround around = pixels_around(pixel_from_angles(angles, kSize), kSize);
      double sum = 0.0;
      Vector3d interpolated(0, 0, 0);
      for (std::size_t i = 0; i < 2; ++i) {
        for (std::size_t j = 0; j < 2; ++j) {
          const PixelPosition centre{double(around.column[i]), double(around.row[j])};
          sum += around.weight(i, j);
          interpolated +=
              around.weight(i, j) * direction_from_angles(angles_from_pixel(centre, kSize));
        }
      }
      EXPECT_NEAR(sum, 1.0, 1e-12);
      // Half a row at a pole, where the row next to it stands for the pole.
      EXPECT_LT((interpolated - direction_from_angles(angles)).norm(), 0.51 * pixel_rad)
          << theta << " " << phi;
    }
  }
}

TEST(EyeCircle, TheLeftEyeStandsToTheLeftOfItsColumn) {
  const EyeCircle left{{1.0, 2.0, 3.0}, 0.1};
  // Ahead is +z, so that left is -x; then ahead is +x, so that left is +z.
  EXPECT_LT((left.position_m(0.0) - Eigen::Vector3d(0.9, 2.0, 3.0)).norm(), 1e-15);
  EXPECT_LT((left.position_m(kHalfPi) - Eigen::Vector3d(1.0, 2.0, 3.1)).norm(), 1e-15);
  EXPECT_LT((left.opposite().position_m(0.0) - Eigen::Vector3d(1.1, 2.0, 3.0)).norm(), 1e-15);
}

TEST(EyeCircle, FindsTheDirectionThatAPointIsSeenIn) {
  for (const double radius_m : {0.03, -0.03, 0.5, -0.5, 1e-9, 0.0}) {
    const EyeCircle eye{{0.2, 1.0, -0.3}, radius_m};
    for (double theta = -3.1; theta < 3.1; theta += 0.31) {
      for (const double phi : {-1.57, -1.0, 0.0, 0.7, 1.57}) {
        for (const double distance_m : {0.01, 1.0, 1e6}) {
          const Eigen::Vector3d point_m =
              eye.position_m(theta) + distance_m * direction_from_angles({theta, phi});
          const auto seen = eye.direction_of(point_m - eye.centre_m);
          ASSERT_TRUE(seen) << radius_m << ' ' << theta << ' ' << phi;
          // Across the ray; a point 0.01 m away almost straight up touches the circle.
          const double plan_m = distance_m * std::cos(phi);
          const double slack_m = 1e-15 * distance_m + 2e-16 / std::max(plan_m, 1e-6);
          ASSERT_NEAR(wrap_angle(seen->theta_rad - theta) * plan_m, 0.0, 1e-12 + slack_m);
          ASSERT_NEAR(seen->phi_rad, phi, 1e-9);
        }
      }
    }
  }
}

TEST(EyeCircle, DoesNotSeeWhatIsInside) {
  const EyeCircle eye{{0, 0, 0}, 0.1};
  EXPECT_FALSE(eye.direction_of({0.05, -1.0, 0.05}));
  EXPECT_FALSE(eye.direction_of({0.0, 1.0, 0.0}));
  EXPECT_TRUE(eye.direction_of({0.1, -1.0, 0.05}));
}

constexpr double kBoundRad = 5.5e-7;  // as the header promises

double error_of(float y, float x) {
  return std::fabs(static_cast<double>(fast_atan2(y, x)) -
                   std::atan2(static_cast<double>(y), static_cast<double>(x)));
}

TEST(FastAtan2, StaysWithinItsBoundForArgumentsOfEverySize) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> exponent(-37.0, 38.0);
  std::bernoulli_distribution negative(0.5);
  const auto argument = [&] {
    const double size = std::pow(10.0, exponent(random));
    return static_cast<float>(negative(random) ? -size : size);
  };
  for (int i = 0; i < 200000; ++i) {
    const float y = argument();
    const float x = argument();
    ASSERT_LT(error_of(y, x), kBoundRad) << y << ' ' << x;
  }
}

TEST(FastAtan2, StaysWithinItsBoundAllAroundTheCircle) {
  for (int i = 0; i < 400000; ++i) {
    const double angle = (i - 200000) * 1.5707963e-5;
    const auto y = static_cast<float>(std::sin(angle));
    const auto x = static_cast<float>(std::cos(angle));
    ASSERT_LT(error_of(y, x), kBoundRad) << angle;
  }
}

TEST(FastAtan2, MeetsTheAxesAndIsOddInItsFirstArgument) {
  EXPECT_EQ(fast_atan2(0.0f, 0.0f), 0.0f);
  EXPECT_EQ(fast_atan2(0.0f, 2.0f), 0.0f);
  for (const float size : {1e-30f, 1.0f, 1e30f}) {
    EXPECT_LT(error_of(0.0f, -size), kBoundRad);
    EXPECT_LT(error_of(size, 0.0f), kBoundRad);
    EXPECT_LT(error_of(-size, 0.0f), kBoundRad);
  }
  std::mt19937_64 random(4);
  std::uniform_real_distribution<float> value(-1.0f, 1.0f);
  for (int i = 0; i < 10000; ++i) {
    const float y = value(random);
    const float x = value(random);
    ASSERT_EQ(fast_atan2(-y, x), -fast_atan2(y, x));
  }
}

Vector3d at_angle(double off_axis_rad, double around_rad) {
  return {std::sin(off_axis_rad) * std::cos(around_rad),
          std::sin(off_axis_rad) * std::sin(around_rad), std::cos(off_axis_rad)};
}

TEST(FisheyeLensTest, EquidistantLensImagesAnglesInProportion) {
  const FisheyeLens lens{.centre = {200.0, 100.0}, .focal_px = 60.0};
  const auto expect_pixel = [&](const Vector3d& direction, double u, double v) {
    EXPECT_NEAR(project(lens, direction).value().u, u, 1e-12);
    EXPECT_NEAR(project(lens, direction).value().v, v, 1e-12);
  };
  expect_pixel(at_angle(0.5, 0.0), 230.0, 100.0);
  expect_pixel(at_angle(0.5, kHalfPi), 200.0, 70.0);  // v grows downwards
  expect_pixel({0, 0, 2}, 200.0, 100.0);
}

TEST(FisheyeLensTest, UnprojectInvertsProjectBeyond180Degrees) {
  std::mt19937_64 random(3);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int inverted = 0;
  for (int i = 0; i < 2000; ++i) {
    const FisheyeLens lens{.centre = {uniform(0, 1000), uniform(0, 1000)},
                           .focal_px = 50.0 * std::pow(40.0, uniform(0, 1)),
                           .k = {uniform(-0.03, 0.05), uniform(-0.004, 0.01),
                                 uniform(-0.001, 0.001), uniform(-1e-4, 1e-4)},
                           .largest_angle_rad = radians_from_degrees(105.0)};
    const Vector3d direction = at_angle(uniform(0, lens.largest_angle_rad), uniform(-kPi, kPi));
    const auto pixel = project(lens, direction);
    ASSERT_TRUE(pixel);
    const auto back = unproject(lens, *pixel);
    if (!back) continue;  // on the very rim
    EXPECT_LT((*back - direction).norm(), 1e-10);
    ++inverted;
  }
  EXPECT_GE(inverted, 1990);
}

TEST(FisheyeLensTest, RadiusIsWhereProjectPutsTheAngle) {
  const FisheyeLens lens{.k = {0.02, -0.006, 0.001, -0.0001}};
  for (double t = 0.1; t < lens.largest_angle_rad; t += 0.1) {
    const auto pixel = project(lens, at_angle(t, 0.0));
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->u, lens.focal_px * fisheye_radius(lens.k, t), 1e-12);
    // A wider floating-point type gives the same with more digits.
    EXPECT_NEAR(static_cast<double>(fisheye_radius(lens.k, static_cast<long double>(t))),
                fisheye_radius(lens.k, t), 1e-15);
  }
}

TEST(FisheyeLensTest, NothingIsSeenBeyondTheFieldOfView) {
  const FisheyeLens lens;
  EXPECT_TRUE(project(lens, at_angle(radians_from_degrees(94.9), 1.0)));
  EXPECT_FALSE(project(lens, at_angle(radians_from_degrees(95.1), 1.0)));
  const double rim = lens.focal_px * lens.largest_angle_rad;
  EXPECT_TRUE(unproject(lens, {rim - 0.01, 0}));
  EXPECT_FALSE(unproject(lens, {rim + 0.01, 0}));
}

}  // namespace
}  // namespace raywalk
