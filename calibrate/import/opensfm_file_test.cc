#include "calibrate/import/opensfm_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/base/test_error.h"

namespace raywalk::calibrate {
namespace {

using ::testing::HasSubstr;

std::string text_of(const std::string& projection, const std::string& shots) {
  return R"([{"cameras": {"c": {"projection_type": ")" + projection +
         R"(", "width": 4096, "height": 2048}}, "shots": {)" + shots + R"(}, "points": {}}])";
}

ImportedPoses read(const std::string& shots) {
  return opensfm_of_text(text_of("spherical", shots), "hall/reconstruction.json");
}

// A camera upright at (1, 2, 3) east, north, up that looks north: its x is east, its y down, its z
// north, so that world-to-camera is (x, y, z) -> (x, -z, y): a turn by +90 degrees about x.
TEST(OpensfmFile, IsReadInItsConvention) {
  const ImportedPoses poses = read(
      R"("a.jpg": {"camera": "c", "rotation": [1.5707963267948966, 0, 0], "translation": [-1, 3, -2]})");
  ASSERT_EQ(poses.frames.size(), 1U);
  EXPECT_EQ(poses.frames[0].file, "a.jpg");
  EXPECT_LT((poses.frames[0].pose.position_m - Eigen::Vector3d(1, 3, 2)).norm(), 1e-12);
  EXPECT_LT((poses.frames[0].pose.world_from_camera - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_EQ(poses.panoramas, std::filesystem::path("hall/images"));
}

// The formulas of its documentation: every pixel's direction is ours.
TEST(OpensfmFile, ShowsEveryPixelInOurDirection) {
  const Eigen::Vector3d turn(1.2, -0.3, 0.5);
  const ImportedPoses poses =
      read(R"("a.jpg": {"camera": "c", "rotation": [1.2, -0.3, 0.5], "translation": [0, 0, 0]})");
  const Eigen::Matrix3d camera_from_world =
      Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  for (const SphereAngles ours : {SphereAngles{0.4, 0.2}, {-2.0, -1.0}, {3.0, 1.4}}) {
    // The pixel at u = lon / 2 pi, v = -lat / 2 pi from the middle, to the right and down.
    const double lon = ours.theta_rad, lat = ours.phi_rad;
    const Eigen::Vector3d camera(std::cos(lat) * std::sin(lon), -std::sin(lat),
                                 std::cos(lat) * std::cos(lon));
    const Eigen::Vector3d east_north_up = camera_from_world.transpose() * camera;
    const Eigen::Vector3d world =
        poses.frames[0].pose.world_from_camera * direction_from_angles(ours);
    EXPECT_LT(
        (world - Eigen::Vector3d(east_north_up.x(), east_north_up.z(), east_north_up.y())).norm(),
        1e-12);
  }
}

TEST(OpensfmFile, OfOtherCamerasOrDamagedIsRefused) {
  const std::string shot =
      R"("a.jpg": {"camera": "c", "rotation": [0, 0, 0], "translation": [0, 0, 0]})";
  EXPECT_THAT(error_of([&] { opensfm_of_text(text_of("perspective", shot), "r.json"); }),
              HasSubstr("'perspective' is no camera of panoramas"));
  EXPECT_THAT(error_of([&] { opensfm_of_text("[]", "r.json"); }), HasSubstr("no reconstruction"));
  EXPECT_THAT(error_of([&] { read(""); }), HasSubstr("holds no shots"));
  EXPECT_THAT(error_of([&] { read(R"("a.jpg": {"camera": "c", "rotation": [0, 0]})"); }),
              HasSubstr("rotation"));
}

}  // namespace
}  // namespace raywalk::calibrate
