#include "calibrate/poses/matching_faces.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raywalk::calibrate {
namespace {

constexpr int kMatchedFace_px = 64;

DualFisheyeLayout two_lenses() {
  DualFisheyeLayout lenses;
  lenses.front_position_m = {0.001, 0.002, 0.006};
  lenses.back_position_m = {-0.001, 0.0, -0.004};
  return lenses;
}

TEST(MatchingFaces, LieEachInOneLensAndMeetAtFrontSidesAndBack) {
  const DualFisheyeLayout lenses = two_lenses();
  const auto faces = panorama_faces(lenses);
  int front = 0;
  for (const PanoramaFace& face : faces) {
    const bool is_front = face.camera_from_face.col(2).z() > 0;
    front += is_front ? 1 : 0;
    EXPECT_EQ(face.centre_m, is_front ? lenses.front_position_m : lenses.back_position_m);
    for (const double x : {0.0, static_cast<double>(kMatchedFace_px)}) {
      for (const double y : {0.0, 0.5 * kMatchedFace_px, static_cast<double>(kMatchedFace_px)}) {
        const double z = direction_of(face, kMatchedFace_px, {x, y}).z();
        EXPECT_GE(is_front ? z : -z, -1e-12);
      }
    }
  }
  EXPECT_EQ(front, 2);
  EXPECT_EQ(panorama_faces(std::nullopt)[2].centre_m.norm(), 0.0);
}

TEST(MatchingFaces, AreAsLargeAsThePanoramaDemandsWithinLimits) {
  EXPECT_EQ(default_face_px(256), 384);
  EXPECT_EQ(default_face_px(1024), 512);
  EXPECT_EQ(default_face_px(4096), 768);
}

TEST(OverlappingFaces, AreTheSameInCamerasThatLookTheSameWay) {
  const auto faces = panorama_faces(std::nullopt);
  const Eigen::Matrix3d first = world_from_camera({0.1, 0.0, 0.05});
  const Eigen::Matrix3d second = world_from_camera({-0.1, 0.1, 0.0});
  const std::vector<FacePair> pairs = overlapping_faces(faces, first, second);
  ASSERT_EQ(pairs.size(), 4U);
  for (const FacePair& pair : pairs) EXPECT_EQ(pair.first, pair.second);
}

TEST(OverlappingFaces, FollowARotatedCamera) {
  const auto faces = panorama_faces(std::nullopt);
  const Eigen::Matrix3d ahead = Eigen::Matrix3d::Identity();
  const auto to_right = overlapping_faces(faces, ahead, world_from_camera({kHalfPi, 0, 0}));
  ASSERT_EQ(to_right.size(), 4U);
  for (const FacePair& pair : to_right) {
    const Eigen::Vector3d first = faces[pair.first].camera_from_face.col(2);
    const Eigen::Vector3d second =
        world_from_camera({kHalfPi, 0, 0}) * faces[pair.second].camera_from_face.col(2);
    EXPECT_NEAR(first.dot(second), 1.0, 1e-12);
  }
  // Half way between two faces, both overlap by half.
  EXPECT_EQ(overlapping_faces(faces, ahead, world_from_camera({0.5 * kHalfPi, 0, 0})).size(), 8U);
}

}  // namespace
}  // namespace raywalk::calibrate
