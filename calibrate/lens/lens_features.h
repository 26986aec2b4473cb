// Features (SIFT, Lowe 2004) of the pictures of a dual-fisheye camera.
//
// They are detected in the fisheye pictures directly, without resampling. Both lenses distort
// their overlap alike, so its features match.
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

// A station's pictures: front and back are the same for a camera with one file.
struct LensPictures {
  cv::Mat front{};  // CV_8UC3
  cv::Mat back{};
  cv::Mat mask{};  // CV_8UC1 of their size, 0 = masked; empty: nothing is
};

// Up to `most_per_lens` features of each lens, spread over its image circle, none within
// `ignore_below_rad` of `down` (camera's frame) and none whose neighbourhood crosses the rim of the
// circle or touches what is masked.
struct FeatureOptions {
  int most_per_lens = 2500;
  double ignore_below_rad = 0.0;
  Eigen::Vector3d down{0, -1, 0};
};
LensFeatures find_lens_features(const LensPictures& pictures, const DualFisheyeCamera& camera,
                                const FeatureOptions& options);

}  // namespace raywalk::calibrate
