#include "core/reconstruction/nerfstudio_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "core/base/test_error.h"

namespace raywalk {
namespace {

using ::testing::HasSubstr;

constexpr PanoramaSize kSize{256, 128};

std::vector<NerfstudioFrame> two_frames() {
  return {{.file = "images/a.png", .pose = {{1, 2, 3}, Eigen::Matrix3d::Identity()}},
          {.file = "images/b.png",
           .mask = "masks/b.png",
           .pose = {{-0.1, 0.2, 1.0 / 3.0}, world_from_camera({0.3, -0.2, 0.1})}}};
}

// The direction of a pixel in nerfstudio's world, by the formulas of its generate_rays.
Eigen::Vector3d nerfstudio_ray(const nlohmann::json& document, int frame, double x, double y) {
  const double across = (x - document["cx"].get<double>()) / document["fl_x"].get<double>();
  const double up = -(y - document["cy"].get<double>()) / document["fl_y"].get<double>();
  const double theta = -kPi * across;
  const double phi = kPi * (0.5 - up);
  const Eigen::Vector3d ray(-std::sin(theta) * std::sin(phi), std::cos(phi),
                            -std::cos(theta) * std::sin(phi));
  Eigen::Matrix3d rotation;
  const nlohmann::json& matrix = document["frames"][frame]["transform_matrix"];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rotation(row, column) = matrix[row][column];
  }
  EXPECT_NEAR(rotation.determinant(), 1.0, 1e-12);
  return rotation * ray;
}

TEST(NerfstudioFile, ShowsEveryPixelInOurDirection) {
  const auto document = nlohmann::json::parse(nerfstudio_text(two_frames(), kSize, ""));
  for (int frame = 0; frame < 2; ++frame) {
    for (const PixelPosition pixel : {PixelPosition{0, 0}, {200, 40}, {127, 63}, {3, 120}}) {
      const Eigen::Vector3d ours =
          two_frames()[static_cast<std::size_t>(frame)].pose.world_from_camera *
          direction_from_angles(angles_from_pixel(pixel, kSize));
      const Eigen::Vector3d theirs = nerfstudio_ray(document, frame, pixel.u + 0.5, pixel.v + 0.5);
      // x right, y forward, z up.
      EXPECT_NEAR(theirs.x(), ours.x(), 1e-12);
      EXPECT_NEAR(theirs.y(), ours.z(), 1e-12);
      EXPECT_NEAR(theirs.z(), ours.y(), 1e-12);
    }
  }
  EXPECT_EQ(document["frames"][0]["transform_matrix"][2][3], 2.0);  // up
}

TEST(NerfstudioFile, RoundTripsExactly) {
  const auto frames =
      nerfstudio_of_text(nerfstudio_text(two_frames(), kSize, "points.ply"), "t.json");
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[1].file, "images/b.png");
  EXPECT_EQ(frames[1].mask, "masks/b.png");
  EXPECT_EQ(frames[1].pose.position_m, two_frames()[1].pose.position_m);
  EXPECT_LT((frames[1].pose.world_from_camera - two_frames()[1].pose.world_from_camera).norm(),
            1e-15);
}

std::string error_for(const std::string& model, const std::string& matrix) {
  return error_of([&] {
    nerfstudio_of_text(R"({"camera_model": ")" + model +
                           R"(", "frames": [{"file_path": "a.png", "transform_matrix": )" + matrix +
                           "}]}",
                       "transforms.json");
  });
}

TEST(NerfstudioFile, OfAnotherConventionIsRefused) {
  const std::string unit = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
  EXPECT_EQ(error_for("EQUIRECTANGULAR", unit), "no error");
  EXPECT_THAT(error_for("OPENCV", unit),
              HasSubstr("transforms.json: frames[0]: its camera_model is 'OPENCV'"));
  EXPECT_THAT(error_for("EQUIRECTANGULAR", "[[2,0,0,0],[0,2,0,0],[0,0,2,0]]"), HasSubstr("scales"));
  EXPECT_THAT(error_for("EQUIRECTANGULAR", "[[1,0,0,0],[0,1,0,0],[0,0,-1,0]]"),
              HasSubstr("mirrors"));
  EXPECT_THAT(error_for("EQUIRECTANGULAR", "[[1,0,0],[0,1,0],[0,0,1]]"),
              HasSubstr("transform_matrix"));
  EXPECT_THAT(error_of([] {
                nerfstudio_of_text(R"({"camera_angle_x": 1, "frames": [{"file_path": "a"}]})", "t");
              }),
              HasSubstr("give poses of panoramas"));
  EXPECT_THAT(error_of([] { nerfstudio_of_text(R"({"frames": []})", "t"); }),
              HasSubstr("lists no frames"));
}

}  // namespace
}  // namespace raywalk
