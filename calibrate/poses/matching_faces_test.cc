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

}  // namespace
}  // namespace raywalk::calibrate
