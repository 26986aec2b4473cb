#include "calibrate/import/gps_table.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/test_error.h"

namespace raywalk::calibrate {
namespace {

using ::testing::HasSubstr;

constexpr double kMajor = 6378137.0;
constexpr double kFlat = 1.0 / 298.257223563;

GeodeticPlace place(double latitude_deg, double longitude_deg, double altitude_m) {
  return {radians_from_degrees(latitude_deg), radians_from_degrees(longitude_deg), altitude_m};
}

TEST(EarthFixed, MeetsTheEllipsoidsAxes) {
  EXPECT_LT((earth_fixed_m(place(0, 0, 0)) - Eigen::Vector3d(kMajor, 0, 0)).norm(), 1e-8);
  EXPECT_LT((earth_fixed_m(place(0, 90, 10)) - Eigen::Vector3d(0, kMajor + 10, 0)).norm(), 1e-8);
  EXPECT_LT((earth_fixed_m(place(90, 0, 0)) - Eigen::Vector3d(0, 0, kMajor * (1 - kFlat))).norm(),
            1e-8);
}

// Steps of 1e-6 degrees, to the closed radii of curvature of the meridian and across it.
TEST(EarthFixed, StepsAreThoseOfTheRadiiOfCurvature) {
  const double squared = kFlat * (2.0 - kFlat);
  for (const double latitude : {-63.0, 0.0, 48.1, 89.0}) {
    const double sine = std::sin(radians_from_degrees(latitude));
    const double across = kMajor / std::sqrt(1 - squared * sine * sine);
    const double meridian = across * (1 - squared) / (1 - squared * sine * sine);
    const GeodeticPlace here = place(latitude, 11.5, 0);
    const Eigen::Matrix3d local = earth_from_east_north_up(here).transpose();
    const double step = radians_from_degrees(1e-4);
    const Eigen::Vector3d north =
        local * (earth_fixed_m(place(latitude + 1e-4, 11.5, 0)) - earth_fixed_m(here));
    const Eigen::Vector3d east =
        local * (earth_fixed_m(place(latitude, 11.5001, 0)) - earth_fixed_m(here));
    EXPECT_NEAR(north.y(), meridian * step, 1e-4);
    EXPECT_NEAR(north.x(), 0.0, 1e-6);
    EXPECT_NEAR(east.x(), across * std::cos(radians_from_degrees(latitude)) * step, 1e-4);
  }
}

// 1 km away the chord is exact to far less than a millimetre: on the equator it is 2 a sin(angle /
// 2), and its end lies below the tangent plane by a (1 - cos angle).
TEST(GpsTable, IsExactOverAKilometre) {
  const double angle = 1000.0 / kMajor;
  const std::string text = fmt::format(
      "file,latitude_deg,longitude_deg,altitude_m,heading_deg\na.jpg,0,0,0,0\nb.jpg,0,{:.15f},0,"
      "90\n",
      degrees_from_radians(angle));
  const ImportedPoses poses = gps_of_text(text, "gps.csv");
  ASSERT_EQ(poses.frames.size(), 2U);
  EXPECT_TRUE(poses.metric && poses.upright);
  EXPECT_EQ(poses.frames[0].pose.position_m.norm(), 0.0);
  const Eigen::Vector3d far = poses.frames[1].pose.position_m;
  EXPECT_NEAR(far.x(), kMajor * std::sin(angle), 1e-6);
  EXPECT_NEAR(far.y(), -kMajor * (1 - std::cos(angle)), 1e-6);
  EXPECT_NEAR(far.z(), 0.0, 1e-9);
  // It looks to its own east, which points below the first place's by the angle between them.
  const Eigen::Vector3d ahead = poses.frames[1].pose.world_from_camera.col(2);
  EXPECT_LT((ahead - Eigen::Vector3d(std::cos(angle), -std::sin(angle), 0)).norm(), 1e-12);
}

TEST(GpsTable, TurnsClockwiseFromNorthAndLowersTheRightSide) {
  const ImportedPoses poses = gps_of_text(
      "file,latitude_deg,longitude_deg,altitude_m,heading_deg,pitch_deg,roll_deg\n"
      "a.jpg,48,11,500,90,0,0\nb.jpg,48,11,502,0,10,5\n",
      "gps.csv");
  EXPECT_NEAR(poses.frames[0].pose.world_from_camera.col(2).x(), 1.0, 1e-12);  // ahead is east
  const Eigen::Matrix3d second = poses.frames[1].pose.world_from_camera;
  EXPECT_NEAR(second.col(2).y(), std::sin(radians_from_degrees(10)), 1e-12);
  EXPECT_LT(second.col(0).y(), -0.08);
  EXPECT_NEAR(poses.frames[1].pose.position_m.y(), 2.0, 1e-8);
}

TEST(GpsTable, WithWrongUnitsOrColumnsIsRefused) {
  const auto error_for = [](const std::string& text) {
    return error_of([&] { gps_of_text(text, "gps.csv"); });
  };
  const std::string head = "file,latitude_deg,longitude_deg,altitude_m,heading_deg\n";
  EXPECT_THAT(error_for(head), HasSubstr("lists no frames"));
  EXPECT_THAT(error_for(head + "a,4812345,11,0,0\n"), HasSubstr("gps.csv:2: latitude_deg"));
  EXPECT_THAT(error_for(head + "a,48,11,0,0\nb,48,13,0,0\n"), HasSubstr("gps.csv:3: is 149 km"));
  EXPECT_THAT(error_for("file,latitude_deg,longitude_deg,altitude_m\na,1,1,1\n"),
              HasSubstr("heading_deg"));
}

}  // namespace
}  // namespace raywalk::calibrate
