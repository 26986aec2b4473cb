// Features (SIFT, Lowe 2004) of the pictures of a dual-fisheye camera, each known by the lens that
// saw it.
//
// They are found in the fisheye pictures as they are: nothing is interpolated, and both lenses
// stretch what lies in their common ring alike, so that its features match.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/files/lens_file.h"

namespace raywalk::calibrate {

struct LensFeature {
  PixelPosition seen{};  // pixels of its picture
  bool back = false;
};

struct LensFeatures {
  std::vector<LensFeature> features{};
  cv::Mat descriptors{};  // CV_32FC1, a row per feature, of unit length
};

// A station's pictures: front and back are the same where the camera gives one file.
struct LensPictures {
  cv::Mat front{};  // CV_8UC3
  cv::Mat back{};
};

// Up to `most_per_lens` features of each lens, spread over its image circle, none within
// `ignore_below_rad` of straight down (`down` in the camera's frame) and none so near the circle's
// rim that its neighbourhood crosses it.
struct FeatureOptions {
  int most_per_lens = 2500;
  double ignore_below_rad = 0.0;
  Eigen::Vector3d down{0, -1, 0};
};
LensFeatures find_lens_features(const LensPictures& pictures, const DualFisheyeCamera& camera,
                                const FeatureOptions& options);

}  // namespace raywalk::calibrate
