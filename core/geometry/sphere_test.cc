#include "core/geometry/sphere.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "core/geometry/eye_circle.h"
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

TEST(WrapAngle, HoldsTheLowerEndAndNotTheUpper) {
  EXPECT_EQ(wrap_angle(0.0), 0.0);
  EXPECT_EQ(wrap_angle(kPi), -kPi);
  EXPECT_EQ(wrap_angle(-kPi), -kPi);
  EXPECT_EQ(wrap_angle(kTwoPi), 0.0);
  EXPECT_EQ(wrap_angle(1.5), 1.5);
  EXPECT_NEAR(wrap_angle(3.0 * kHalfPi), -kHalfPi, kTolerance);
  EXPECT_NEAR(wrap_angle(-3.0 * kHalfPi), kHalfPi, kTolerance);
}

TEST(WrapAngle, StaysInRangeAndKeepsTheDirectionForAnyTurns) {
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

TEST(Direction, KeepsItsDigitsBesideThePole) {
  // asin(y) would return exactly pi / 2 here.
  const SphereAngles angles = angles_from_direction({0.0, 1.0, 1e-9});
  EXPECT_NEAR(kHalfPi - angles.phi_rad, 1e-9, 1e-15);
}

TEST(Direction, HasLongitudeZeroAtThePoles) {
  for (const double x : {0.0, -0.0}) {
    for (const double z : {0.0, -0.0}) {
      EXPECT_EQ(angles_from_direction({x, 2.0, z}).theta_rad, 0.0);
      EXPECT_EQ(angles_from_direction({x, 2.0, z}).phi_rad, kHalfPi);
      EXPECT_EQ(angles_from_direction({x, -2.0, z}).phi_rad, -kHalfPi);
    }
  }
}

TEST(Direction, BackwardsIsAlwaysTheLowerEndOfTheRange) {
  EXPECT_EQ(angles_from_direction({0.0, 0.0, -1.0}).theta_rad, -kPi);
  EXPECT_EQ(angles_from_direction({-0.0, 0.0, -1.0}).theta_rad, -kPi);
}

TEST(Pixel, CentresAreHalfAPixelInside) {
  constexpr PanoramaSize size{360, 180};
  const SphereAngles first = angles_from_pixel({0.0, 0.0}, size);
  EXPECT_NEAR(degrees_from_radians(first.theta_rad), -179.5, 1e-12);
  EXPECT_NEAR(degrees_from_radians(first.phi_rad), 89.5, 1e-12);
  const SphereAngles last = angles_from_pixel({359.0, 179.0}, size);
  EXPECT_NEAR(degrees_from_radians(last.theta_rad), 179.5, 1e-12);
  EXPECT_NEAR(degrees_from_radians(last.phi_rad), -89.5, 1e-12);
}

TEST(Pixel, CentreAndBordersAreExact) {
  constexpr PanoramaSize size{4096, 2048};
  EXPECT_EQ(angles_from_pixel({2047.5, 1023.5}, size).theta_rad, 0.0);
  EXPECT_EQ(angles_from_pixel({2047.5, 1023.5}, size).phi_rad, 0.0);
  EXPECT_EQ(angles_from_pixel({-0.5, -0.5}, size).theta_rad, -kPi);
  EXPECT_EQ(angles_from_pixel({-0.5, -0.5}, size).phi_rad, kHalfPi);
  EXPECT_EQ(angles_from_pixel({-0.5, 2047.5}, size).phi_rad, -kHalfPi);
  // The right border is the left one.
  EXPECT_EQ(angles_from_pixel({4095.5, 0.0}, size).theta_rad, -kPi);
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

TEST(Attitude, YawTurnsTheCentreTowardsX) {
  const double a = 0.3;
  expect_near(world_from_camera({.yaw_rad = a}) * Vector3d::UnitZ(),
              {std::sin(a), 0.0, std::cos(a)});
}

TEST(Attitude, PitchRaisesTheCentre) {
  const double a = 0.3;
  expect_near(world_from_camera({.pitch_rad = a}) * Vector3d::UnitZ(),
              {0.0, std::sin(a), std::cos(a)});
}

TEST(Attitude, RollTipsUpTowardsTheRight) {
  const double a = 0.3;
  expect_near(world_from_camera({.roll_rad = a}) * Vector3d::UnitY(),
              {std::sin(a), std::cos(a), 0.0});
}

TEST(Attitude, RollsFirstThenPitchesThenYaws) {
  const Attitude attitude{.yaw_rad = 0.7, .pitch_rad = -0.4, .roll_rad = 0.2};
  const Eigen::Matrix3d expected = world_from_camera({.yaw_rad = 0.7}) *
                                   world_from_camera({.pitch_rad = -0.4}) *
                                   world_from_camera({.roll_rad = 0.2});
  EXPECT_LT((world_from_camera(attitude) - expected).norm(), kTolerance);
}

TEST(Attitude, IsAProperRotation) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Matrix3d rotation =
        world_from_camera({angle(random), angle(random), angle(random)});
    EXPECT_LT((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm(), kTolerance);
    EXPECT_NEAR(rotation.determinant(), 1.0, kTolerance);
  }
}

TEST(AttitudeFromRotation, InvertsWorldFromCameraUpToTheZenith) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> angle(-kPi, kPi), exponent(-12.0, 0.0);
  for (int i = 0; i < 2000; ++i) {
    // Half of the pitches lie near the zenith or the nadir, down to 1e-12 rad from it.
    double pitch = 0.5 * angle(random);
    if (i % 2 == 0) pitch = std::copysign(kHalfPi - std::pow(10.0, exponent(random)), pitch);
    const Eigen::Matrix3d rotation = world_from_camera({angle(random), pitch, angle(random)});
    const Eigen::Matrix3d again = world_from_camera(attitude_from_world_from_camera(rotation));
    EXPECT_LT((again - rotation).norm(), 1e-11) << "pitch " << pitch;
  }
}

TEST(AttitudeFromRotation, GivesTheAnglesThatPosesCsvHolds) {
  const Attitude attitude = attitude_from_world_from_camera(world_from_camera({0.3, -0.2, 0.1}));
  EXPECT_NEAR(attitude.yaw_rad, 0.3, kTolerance);
  EXPECT_NEAR(attitude.pitch_rad, -0.2, kTolerance);
  EXPECT_NEAR(attitude.roll_rad, 0.1, kTolerance);
}

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

}  // namespace
}  // namespace raywalk
