#include "simulator/room/dolly.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/panorama/srgb.h"
#include "simulator/room/dual_fisheye.h"

namespace raywalk::capture {
namespace {

constexpr PanoramaSize kDollySize{720, 360};
constexpr double kFloor_m = 1.2;

DollySettings reaching(double reach_deg) { return {true, reach_deg}; }

// Coverage of the pixel at an angle from the nadir.
float share_at(const DollyView& view, double theta_deg, double from_nadir_deg) {
  const PixelPosition pixel = pixel_from_angles(
      {radians_from_degrees(theta_deg), radians_from_degrees(from_nadir_deg - 90.0)}, kDollySize);
  return view.share().at<float>(cvRound(pixel.v), cvRound(pixel.u) % kDollySize.width);
}

TEST(DollyTest, CoversTheNadirUpToItsReach) {
  const PanoramaRays camera(kDollySize);
  for (const double reach_deg : {12.0, 20.0, 40.0}) {
    const DollyView view(camera, reaching(reach_deg), kFloor_m);
    for (const double theta_deg : {0.0, 90.0, -90.0}) {
      for (double angle_deg = 1.0; angle_deg < reach_deg - 1.0; angle_deg += 1.0) {
        EXPECT_EQ(share_at(view, theta_deg, angle_deg), 1.0F) << reach_deg << " " << angle_deg;
      }
      EXPECT_EQ(share_at(view, theta_deg, reach_deg + 1.0), 0.0F) << reach_deg;
    }
    // A corner of the square: as far out as its edges, times sqrt(2).
    const double corner_deg =
        degrees_from_radians(std::atan(std::sqrt(2.0) * std::tan(radians_from_degrees(reach_deg))));
    EXPECT_EQ(share_at(view, 45.0, corner_deg - 1.5), 1.0F);
    EXPECT_EQ(cv::countNonZero(view.share().rowRange(0, 240)), 0) << "30 degrees and more up";
  }
}

TEST(DollyTest, LooksTheSameFromAnyHeight) {
  const PanoramaRays camera(kDollySize);
  const DollyView low(camera, reaching(20.0), 0.5), high(camera, reaching(20.0), 2.0);
  EXPECT_EQ(cv::norm(low.share(), high.share(), cv::NORM_INF), 0.0);
}

TEST(DollyTest, BothLensesSeeHalfOfIt) {
  const PanoramaSize frame{400, 200};
  const DollyView view(DualFisheyeRays(simple_dual_fisheye(frame), frame), reaching(20.0),
                       kFloor_m);
  for (const int centre : {100, 300}) {
    EXPECT_EQ(view.share().at<float>(187, centre), 1.0F);
    EXPECT_EQ(view.share().at<float>(100, centre), 0.0F);
    EXPECT_EQ(view.share().at<float>(10, centre), 0.0F);
  }
}

// Compositing is linear in light, so results over white and black differ by the uncovered share.
TEST(DollyTest, CompositesInLinearLightByCoverage) {
  const DollyView view(PanoramaRays(kDollySize), reaching(20.0), kFloor_m);
  cv::Mat black(kDollySize.height, kDollySize.width, CV_8UC3, cv::Scalar::all(0.0));
  cv::Mat grey(black.size(), CV_8UC3, cv::Scalar::all(150.0));
  view.cover(&black);
  view.cover(&grey);
  int partly = 0;
  for (int v = 0; v < kDollySize.height; ++v) {
    for (int u = 0; u < kDollySize.width; ++u) {
      const double share = view.share().at<float>(v, u);
      if (share > 0.0 && share < 1.0) ++partly;
      for (int channel = 0; channel < 3; ++channel) {
        const double behind = black.at<cv::Vec3b>(v, u)[channel];
        const double mixed = srgb_level_from_linear(linear_from_srgb_level(behind) +
                                                    (1.0 - share) * linear_from_srgb_level(150.0));
        // Rounding of the black picture's levels has most effect where they are darkest.
        EXPECT_NEAR(grey.at<cv::Vec3b>(v, u)[channel], mixed, share == 1.0 ? 0.01 : 1.6);
      }
    }
  }
  EXPECT_GT(partly, 500) << "edges are smooth";
}

// Features must be found on it, as on a real dolly that moves with the camera.
TEST(DollyTest, IsTextured) {
  const DollyView view(PanoramaRays(kDollySize), reaching(20.0), kFloor_m);
  cv::Mat picture(kDollySize.height, kDollySize.width, CV_8UC3, cv::Scalar::all(0.0));
  view.cover(&picture);
  cv::Scalar mean, deviation;
  cv::meanStdDev(picture, mean, deviation, view.share() == 1.0);
  EXPECT_GT(deviation[1], 10.0);
}

TEST(DollyTest, OtherPicturesAndCamerasBelowTheFloorAreRefused) {
  const PanoramaRays camera(kDollySize);
  EXPECT_THROW(DollyView(camera, reaching(20.0), 0.0), Error);
  const DollyView view(camera, reaching(20.0), kFloor_m);
  cv::Mat small(100, 200, CV_8UC3), grey(kDollySize.height, kDollySize.width, CV_8UC1);
  EXPECT_THROW(view.cover(&small), Error);
  EXPECT_THROW(view.cover(&grey), Error);
}

}  // namespace
}  // namespace raywalk::capture
