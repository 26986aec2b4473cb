// The room must be textured enough for feature detection.
#include <gtest/gtest.h>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "simulator/room/test_rooms.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::capture {
namespace {

constexpr PanoramaSize kFeatureSize{1024, 512};
constexpr int kFace = 384;

// A face of the cube map around the camera with a field of view of 90 degrees.
cv::Mat cube_face(const cv::Mat& panorama, const Attitude& attitude) {
  const Eigen::Matrix3d rotation = world_from_camera(attitude);
  cv::Mat u(kFace, kFace, CV_32FC1), v(kFace, kFace, CV_32FC1);
  for (int row = 0; row < kFace; ++row) {
    for (int column = 0; column < kFace; ++column) {
      const Eigen::Vector3d direction((column + 0.5) / kFace * 2.0 - 1.0,
                                      1.0 - (row + 0.5) / kFace * 2.0, 1.0);
      const PixelPosition at =
          pixel_from_angles(angles_from_direction(rotation * direction), kFeatureSize);
      u.at<float>(row, column) = static_cast<float>(at.u);
      v.at<float>(row, column) = static_cast<float>(at.v);
    }
  }
  cv::Mat face;
  cv::remap(panorama, face, u, v, cv::INTER_LINEAR, cv::BORDER_WRAP);
  return face;
}

TEST(FeaturesTest, SiftFindsFeaturesInEveryDirection) {
  const auto sift = cv::SIFT::create();
  for (const int seed : {1, 2, 3}) {
    const cv::Mat panorama = VirtualRoom(furnished_room(seed)).panorama({}, kFeatureSize);
    for (const Attitude& axis :
         {Attitude{0, 0, 0}, Attitude{kHalfPi, 0, 0}, Attitude{kPi, 0, 0}, Attitude{-kHalfPi, 0, 0},
          Attitude{0, kHalfPi, 0}, Attitude{0, -kHalfPi, 0}}) {
      std::vector<cv::KeyPoint> found;
      sift->detect(cube_face(panorama, axis), found);
      EXPECT_GT(found.size(), 150U)
          << "seed " << seed << ", yaw " << axis.yaw_rad << ", pitch " << axis.pitch_rad;
    }
  }
}

}  // namespace
}  // namespace raywalk::capture
