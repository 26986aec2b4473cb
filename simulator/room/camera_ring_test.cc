#include "simulator/room/camera_ring.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "simulator/room/test_rooms.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::capture {
namespace {

using Eigen::Vector3d;

constexpr PanoramaSize kRingSize{120, 60};

RingSettings ring_of(int cameras, double radius_mm) {
  RingSettings ring;
  ring.cameras = cameras;
  ring.radius_mm = radius_mm;
  return ring;
}

TEST(CameraRingTest, EveryLongitudeBelongsToTheNearestCamera) {
  const RingSettings ring = ring_of(5, 100.0);
  EXPECT_EQ(ring_cameras(ring, 0.0).own, 0);
  EXPECT_EQ(ring_cameras(ring, radians_from_degrees(35.9)).own, 0);
  EXPECT_EQ(ring_cameras(ring, radians_from_degrees(35.9)).other, 1);
  EXPECT_EQ(ring_cameras(ring, radians_from_degrees(36.1)).own, 1);
  EXPECT_EQ(ring_cameras(ring, radians_from_degrees(-36.1)).own, 4);
  EXPECT_EQ(ring_cameras(ring, radians_from_degrees(-35.9)).other, 4);
  EXPECT_EQ(ring_cameras(ring, radians_from_degrees(170.0)).own, 2);
  EXPECT_EQ(ring_cameras(ring, radians_from_degrees(-170.0)).own, 3);
}

TEST(CameraRingTest, FeatheredSeamsBlendFromHalfAtTheSeamToNone) {
  RingSettings ring = ring_of(4, 0.0);
  ring.feather_deg = 10.0;
  const auto weight = [&](double theta_deg) {
    return ring_cameras(ring, radians_from_degrees(theta_deg)).other_weight;
  };
  EXPECT_NEAR(weight(45.0), 0.5, 1e-9);
  EXPECT_NEAR(weight(42.5), 0.25, 1e-9);
  EXPECT_NEAR(weight(-132.5), 0.25, 1e-9);
  EXPECT_EQ(weight(39.9), 0.0);
  ring.feather_deg = 0.0;
  EXPECT_EQ(weight(45.0), 0.0);
}

// Neighbouring cameras are 2 r sin(pi / n) apart, across the direction of their seam: what is at
// distance d there jumps by that baseline over d.
TEST(CameraRingTest, CamerasAreApartByTheChordOfTheRing) {
  constexpr int kCameras = 6;
  const RingRays rays(ring_of(kCameras, 150.0), {360, 180}, RingRays::Camera::kOwn);
  const int seam = 210 * kPixelParts;  // longitude 30 degrees
  const auto before = rays.at_part(seam - 1, 0), after = rays.at_part(seam, 0);
  const Vector3d baseline = after->origin_m - before->origin_m;
  EXPECT_NEAR(baseline.norm(), 2.0 * 0.15 * std::sin(kPi / kCameras), 1e-12);
  EXPECT_NEAR(baseline.dot(direction_from_angles({kPi / 6.0, 0.0})), 0.0, 1e-12);
}

bool same_columns(const cv::Mat& a, const cv::Mat& b, int first, int last) {
  return cv::norm(a.colRange(first, last), b.colRange(first, last), cv::NORM_INF) == 0.0;
}

// Camera 0 of 4 looks forward and sees the columns 45 to 74 of 120.
TEST(CameraRingTest, EachSectorIsSeenFromItsCamera) {
  const VirtualRoom room(empty_room(4, 1.0));
  const CameraPose pose{{0.2, 0.0, 0.1}, {}};
  const RingRays rays(ring_of(4, 120.0), kRingSize, RingRays::Camera::kOwn);
  const cv::Mat ring = room.picture_with_people(0, rays, pose);
  const CameraPose forward{pose.position_m + Vector3d(0, 0, 0.12), {}};
  const CameraPose right{pose.position_m + Vector3d(0.12, 0, 0), {}};
  EXPECT_TRUE(same_columns(ring, room.panorama(forward, kRingSize), 45, 75));
  EXPECT_TRUE(same_columns(ring, room.panorama(right, kRingSize), 75, 105));
  EXPECT_FALSE(same_columns(ring, room.panorama(pose, kRingSize), 45, 75)) << "parallax shows";
}

TEST(CameraRingTest, RingWithoutRadiusIsASingleCamera) {
  const VirtualRoom room(empty_room(4, 1.0));
  const RingRays rays(ring_of(4, 0.0), kRingSize, RingRays::Camera::kOwn);
  EXPECT_TRUE(same_columns(room.picture_with_people(0, rays, {}), room.panorama({}, kRingSize), 0,
                           kRingSize.width));
}

TEST(CameraRingTest, GainsSpreadPerCameraAndPerStation) {
  RingSettings ring = ring_of(32, 0.0);
  EXPECT_EQ(ring_gains(ring, 1, 0), std::vector<double>(32, 1.0));
  ring.gain_spread = 0.1;
  EXPECT_EQ(ring_gains(ring, 1, 0), ring_gains(ring, 1, 7)) << "the same at all stations";
  EXPECT_NE(ring_gains(ring, 1, 0), ring_gains(ring, 2, 0));
  ring.gain_spread = 0.0;
  ring.station_gain_spread = 0.12;
  double sum = 0.0, squares = 0.0;
  for (int moment = 0; moment < 40; ++moment) {
    for (const double gain : ring_gains(ring, 1, moment)) {
      sum += gain / 1280.0;
      squares += (gain - 1.0) * (gain - 1.0) / 1280.0;
    }
  }
  EXPECT_NEAR(sum, 1.0, 0.012);                 // standard error 0.0034
  EXPECT_NEAR(std::sqrt(squares), 0.12, 0.01);  // standard error 0.0024
}

TEST(CameraRingTest, LightFallsOffWithTheSquareOfTheAngle) {
  RingSettings ring = ring_of(4, 0.0);
  ring.vignetting_share = 0.4;
  const cv::Mat light = ring_light(ring, {1.0, 2.0, 1.0, 1.0}, {360, 180}, RingRays::Camera::kOwn);
  EXPECT_NEAR(light.at<float>(90, 180), 1.0, 1e-3) << "on the axis of camera 0";
  EXPECT_NEAR(light.at<float>(90, 270), 2.0, 2e-3) << "of camera 1";
  EXPECT_NEAR(light.at<float>(90, 224), 1.0 - 0.4 * 0.25, 0.01) << "at the seam, 45 degrees";
  EXPECT_NEAR(light.at<float>(0, 180), 0.6, 0.01) << "at the zenith";
}

TEST(CameraRingTest, SeamsMixTheLevelsOfBothCameras) {
  RingSettings ring = ring_of(4, 0.0);
  ring.feather_deg = 20.0;
  const cv::Mat own(60, 120, CV_8UC3, cv::Scalar::all(100)),
      other(60, 120, CV_8UC3, cv::Scalar::all(200));
  const cv::Mat panorama = stitched(ring, own, other);
  EXPECT_EQ(panorama.at<cv::Vec3b>(30, 60), cv::Vec3b::all(100));
  // Column 74 is 0.5 columns of 3 degrees before the seam.
  EXPECT_NEAR(panorama.at<cv::Vec3b>(30, 74)[0], 100.0 + 100.0 * 0.5 * (1.0 - 1.5 / 10.0), 1.0);
}

TEST(CameraRingTest, CamerasOutsideOfTheFreeSpaceAreRefused) {
  VirtualRoomSettings settings = empty_room(4, 1.0);
  settings.ring = ring_of(4, 250.0);
  EXPECT_THROW(VirtualRoom{settings}, UsageError);
}

}  // namespace
}  // namespace raywalk::capture
