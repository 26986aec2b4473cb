#include "calibrate/lens/lens_features.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/lens/lens_test_camera.h"

namespace raywalk::calibrate {
namespace {

constexpr PanoramaSize kFeaturePicture{640, 320};

// Blurred bright dots on grey, at subpixel positions.
cv::Mat dots_at(const std::vector<PixelPosition>& places) {
  constexpr double kSigma_px = 2.5;
  cv::Mat picture(kFeaturePicture.height, kFeaturePicture.width, CV_8UC3);
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      double level = 70.0;
      for (const PixelPosition& place : places) {
        const double square = (u - place.u) * (u - place.u) + (v - place.v) * (v - place.v);
        level += 150.0 * std::exp(-0.5 * square / (kSigma_px * kSigma_px));
      }
      picture.at<cv::Vec3b>(v, u) = cv::Vec3b::all(cv::saturate_cast<uchar>(level));
    }
  }
  return picture;
}

double nearest_px(const LensFeatures& found, PixelPosition place, bool back) {
  double nearest = 1e9;
  for (const LensFeature& feature : found.features) {
    if (feature.back != back) continue;
    nearest = std::min(nearest, std::hypot(feature.seen.u - place.u, feature.seen.v - place.v));
  }
  return nearest;
}

TEST(LensFeaturesTest, FeaturesHaveTheRightPositionAndLensUnlessMasked) {
  const DualFisheyeCamera camera = plain_camera(kFeaturePicture);
  const std::vector<PixelPosition> places{{100.3, 120.6}, {170.8, 200.1}, {450.4, 90.5}};
  const cv::Mat picture = dots_at(places);
  const LensFeatures found = find_lens_features({picture, picture}, camera, {});
  EXPECT_LT(nearest_px(found, places[0], false), 0.05);
  EXPECT_LT(nearest_px(found, places[1], false), 0.05);
  EXPECT_LT(nearest_px(found, places[2], true), 0.05);
  EXPECT_EQ(found.descriptors.rows, static_cast<int>(found.features.size()));
  cv::Mat mask(picture.size(), CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, 99, 320)).setTo(0);  // beside the first
  mask(cv::Rect(449, 89, 3, 3)).setTo(0);  // within the third
  const LensFeatures unmasked = find_lens_features({picture, picture, mask}, camera, {});
  EXPECT_GT(nearest_px(unmasked, places[0], false), 5.0);
  EXPECT_LT(nearest_px(unmasked, places[1], false), 0.05);
  EXPECT_GT(nearest_px(unmasked, places[2], true), 5.0);
}

TEST(LensFeaturesTest, TheNadirAndTheRimAreExcluded) {
  const DualFisheyeCamera camera = plain_camera(kFeaturePicture);
  const PixelPosition middle = camera.layout.front.centre;
  const double rim_px = 0.5 * kFeaturePicture.height * 0.99;
  const PixelPosition below{middle.u + 3.0, middle.v + 0.8 * rim_px};  // 76 degrees below the axis
  const PixelPosition at_rim{middle.u - rim_px + 2.0, middle.v};
  const cv::Mat picture = dots_at({below, at_rim});
  const LensFeatures all = find_lens_features({picture, picture}, camera, {});
  EXPECT_LT(nearest_px(all, below, false), 0.1);
  EXPECT_GT(nearest_px(all, at_rim, false), 5.0);
  FeatureOptions options;
  options.ignore_below_rad = radians_from_degrees(20.0);
  EXPECT_GT(nearest_px(find_lens_features({picture, picture}, camera, options), below, false), 5.0);
}

}  // namespace
}  // namespace raywalk::calibrate
