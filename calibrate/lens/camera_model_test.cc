#include "calibrate/lens/camera_model.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "calibrate/lens/lens_test_camera.h"

namespace raywalk::calibrate {
namespace {

using Eigen::Vector3d;

TEST(CameraModelTest, ParametersAndLayoutAreTheSameCamera) {
  const DualFisheyeLayout truth = true_camera({1120, 560}).layout;
  const DualFisheyeLayout start = plain_camera({1120, 560}).layout;
  EXPECT_LT(imaging_difference_px(layout_of(parameters_of(truth), truth), truth), 1e-9);
  // Turned from the start: 2 degrees about the back lens's own x axis, which is a pitch downwards.
  CameraParameters parameters = parameters_of(start);
  parameters.back_pose = {radians_from_degrees(2.0), 0, 0, 0.001, 0.002, -0.01};
  const DualFisheyeLayout layout = layout_of(parameters, start);
  EXPECT_NEAR(std::fabs(layout.back_attitude.pitch_rad), radians_from_degrees(2.0), 1e-12);
  EXPECT_NEAR((layout.back_position_m - Vector3d(0.0005, 0.001, -0.005)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((layout.front_position_m + layout.back_position_m).norm(), 0.0, 1e-15);
}

TEST(CameraModelTest, ProjectsAsTheLayoutDoes) {
  const DualFisheyeLayout start = plain_camera({1120, 560}).layout;
  const DualFisheyeLayout truth = true_camera({1120, 560}).layout;
  CameraParameters parameters = parameters_of(truth);
  const CameraFrame frame = camera_frame_of(truth);
  // The same camera, with its rotation relative to the start.
  const CameraFrame from_start = camera_frame_of(start);
  CameraParameters turned = parameters;
  const Eigen::Matrix3d turn = frame.back_from_camera * from_start.back_from_camera.transpose();
  ceres::RotationMatrixToAngleAxis(turn.data(), turned.back_pose.data());
  int imaged = 0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d at = 0.5 * at_angle(0.9 * kPi * i / 200, 0.7 * i);
    for (const bool back : {false, true}) {
      const Vector3d in_lens = back
                                   ? Vector3d(frame.back_from_camera * (at - truth.back_position_m))
                                   : Vector3d(at - truth.front_position_m);
      const auto expected = project(back ? truth.back : truth.front, in_lens);
      if (!expected) continue;
      ++imaged;
      for (const auto& [its_frame, its] : {std::pair(frame, parameters), {from_start, turned}}) {
        double pixel[2];
        image_point(its_frame, back, (back ? its.back : its.front).data(), its.back_pose.data(),
                    at.data(), 1.0, pixel);
        EXPECT_NEAR(pixel[0], expected->u, 1e-9);
        EXPECT_NEAR(pixel[1], expected->v, 1e-9);
      }
    }
  }
  // The two fields of view of 194 degrees cover the sphere.
  EXPECT_GE(imaged, 200);
}

// On the axis the derivatives are those of the pinhole camera with the same focal length.
TEST(CameraModelTest, DerivativesExistOnTheAxis) {
  using Jet = ceres::Jet<double, 2>;
  const double lens[7] = {100, 50, 80, 0.1, 0, 0, 0};
  Jet parameters[7];
  for (int i = 0; i < 7; ++i) parameters[i] = Jet(lens[i]);
  const Jet direction[3] = {Jet(0.0, 0), Jet(0.0, 1), Jet(2.0)};
  Jet pixel[2];
  image_direction(parameters, direction, pixel);
  EXPECT_EQ(pixel[0].a, 100.0);
  EXPECT_NEAR(pixel[0].v[0], 40.0, 1e-12);
  EXPECT_NEAR(pixel[1].v[1], -40.0, 1e-12);
}

}  // namespace
}  // namespace raywalk::calibrate
