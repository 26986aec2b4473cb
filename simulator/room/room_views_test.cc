// Rendered views of a furnished room are consistent with its geometry.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/base/median.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector3d;

constexpr PanoramaSize kViewSize{512, 256};

// Bilinear; wraps at the seam, uses the border mode at the poles.
cv::Vec3d sample(const cv::Mat& picture, PixelPosition at) {
  const int u0 = static_cast<int>(std::floor(at.u)), v0 = static_cast<int>(std::floor(at.v));
  cv::Vec3d sum(0, 0, 0);
  for (int dv = 0; dv < 2; ++dv) {
    for (int du = 0; du < 2; ++du) {
      const int u = (u0 + du + picture.cols) % picture.cols;
      const int v = std::clamp(v0 + dv, 0, picture.rows - 1);
      const double weight =
          (du == 1 ? at.u - u0 : 1.0 - (at.u - u0)) * (dv == 1 ? at.v - v0 : 1.0 - (at.v - v0));
      sum += weight * cv::Vec3d(picture.at<cv::Vec3b>(v, u));
    }
  }
  return sum;
}

double mean_difference(const cv::Vec3d& a, const cv::Vec3d& b) {
  return (std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2])) / 3.0;
}

class RoomViewsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { room_ = new VirtualRoom({.scene = {.file = "study"}}); }
  static void TearDownTestSuite() {
    delete room_;
    room_ = nullptr;
  }

  static const VirtualRoom* room_;
};
const VirtualRoom* RoomViewsTest::room_ = nullptr;

struct View {
  CameraPose pose;
  cv::Mat picture;
  cv::Mat distance;
};

// `source` warped to `target` by its distances; only points visible in both.
std::vector<double> differences(const View& target, const View& source, bool reproject) {
  std::vector<double> found;
  const Eigen::Matrix3d target_rotation = world_from_camera(target.pose.attitude);
  const Eigen::Matrix3d source_rotation = world_from_camera(source.pose.attitude);
  for (int v = 20; v < kViewSize.height - 20; ++v) {
    for (int u = 0; u < kViewSize.width; ++u) {
      const PixelPosition pixel{static_cast<double>(u), static_cast<double>(v)};
      const double distance = target.distance.at<float>(v, u);
      if (std::isinf(distance)) continue;
      const Vector3d point =
          target.pose.position_m +
          distance * (target_rotation * direction_from_angles(angles_from_pixel(pixel, kViewSize)));
      const Vector3d from = source.pose.position_m;
      const PixelPosition seen = pixel_from_angles(
          angles_from_direction(source_rotation.transpose() * (point - from)), kViewSize);
      const int near_u =
          (static_cast<int>(std::lround(seen.u)) + kViewSize.width) % kViewSize.width;
      const int near_v = std::clamp(static_cast<int>(std::lround(seen.v)), 0, kViewSize.height - 1);
      const double true_distance = (point - from).norm();
      if (std::abs(source.distance.at<float>(near_v, near_u) - true_distance) >
          0.02 * true_distance) {
        continue;
      }
      found.push_back(mean_difference(sample(source.picture, reproject ? seen : pixel),
                                      cv::Vec3d(target.picture.at<cv::Vec3b>(v, u))));
    }
  }
  return found;
}

TEST_F(RoomViewsTest, ViewWarpedByItsDistancesIsTheOtherView) {
  const auto view_from = [&](const CameraPose& pose) {
    return View{pose, room_->render(PanoramaRays(kViewSize), pose),
                room_->distance_map(pose, kViewSize)};
  };
  const View centre = view_from({});
  const View moved = view_from({{0.25, -0.05, 0.3}, {0.4, 0.1, -0.15}});
  const std::vector<double> reprojected = differences(centre, moved, true);
  ASSERT_GT(reprojected.size(), static_cast<std::size_t>(kViewSize.width * kViewSize.height / 2));
  EXPECT_LT(median(reprojected), 2.5);
  // Without the warp the difference is large.
  EXPECT_GT(median(differences(centre, moved, false)), 15.0);
}

TEST_F(RoomViewsTest, FisheyeAndPanoramaShowTheSameInEveryDirection) {
  const CameraPose pose{{-0.1, 0.02, 0.15}, {0.7, -0.2, 0.1}};
  DualFisheyeLayout layout = simple_dual_fisheye({768, 384});
  layout.front.k = {0.02, -0.005, 0.001, -0.0002};
  layout.front.focal_px *= 0.97;
  layout.back_attitude = {kPi + 0.01, 0.02, -0.03};
  const cv::Mat frame = room_->render(DualFisheyeRays(layout, {768, 384}), pose);
  const cv::Mat panorama = room_->render(PanoramaRays(kViewSize), pose);
  const Eigen::Matrix3d front_from_back = world_from_camera(layout.back_attitude);
  std::vector<double> front, back;
  for (int v = 16; v < kViewSize.height - 16; v += 2) {
    for (int u = 0; u < kViewSize.width; u += 2) {
      const PixelPosition pixel{static_cast<double>(u), static_cast<double>(v)};
      const Vector3d direction = direction_from_angles(angles_from_pixel(pixel, kViewSize));
      const cv::Vec3d expected(panorama.at<cv::Vec3b>(v, u));
      if (const auto at = project(layout.front, direction); at && direction.z() > 0.1) {
        front.push_back(mean_difference(sample(frame, *at), expected));
      }
      const Vector3d in_back = front_from_back.transpose() * direction;
      if (const auto at = project(layout.back, in_back); at && in_back.z() > 0.1) {
        back.push_back(mean_difference(sample(frame, *at), expected));
      }
    }
  }
  ASSERT_GT(front.size(), 2000U);
  ASSERT_GT(back.size(), 2000U);
  EXPECT_LT(median(front), 4.0);
  EXPECT_LT(median(back), 4.0);
  EXPECT_EQ(frame.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(frame.at<cv::Vec3b>(383, 767), cv::Vec3b(0, 0, 0));
}

TEST(DualFisheyeTest, BackLensLooksBackFromItsPosition) {
  DualFisheyeLayout layout = simple_dual_fisheye({400, 200});
  layout.back_position_m = {0, 0, -0.02};
  const DualFisheyeRays rays(layout, {400, 200});
  // Parts 7 and 8 of 16 are on either side of a pixel's centre; the image centre is between two
  // pixels.
  const auto front = rays.at_part(100 * kPixelParts, 100 * kPixelParts);
  const auto back = rays.at_part(300 * kPixelParts, 100 * kPixelParts);
  ASSERT_TRUE(front && back);
  EXPECT_GT(front->direction.z(), 0.9999);
  EXPECT_LT(back->direction.z(), -0.9999);
  EXPECT_EQ(front->origin_m, Vector3d(0, 0, 0));
  EXPECT_EQ(back->origin_m, Vector3d(0, 0, -0.02));
  // To the right in the back lens's image is the camera's left.
  EXPECT_LT(rays.at_part(350 * kPixelParts, 100 * kPixelParts)->direction.x(), -0.5);
  EXPECT_FALSE(rays.at_part(0, 0));
}

TEST(DualFisheyeTest, NonMonotonicAndNonFiniteLensesAreRefused) {
  DualFisheyeLayout layout = simple_dual_fisheye({400, 200});
  layout.back.k = {-0.3, 0, 0, 0};
  EXPECT_THROW(DualFisheyeRays(layout, {400, 200}), Error);
  layout.back.k = {0, std::nan(""), 0, 0};
  EXPECT_THROW(DualFisheyeRays(layout, {400, 200}), Error);
}

}  // namespace
}  // namespace raywalk::simulator
