// Features of a panorama, as directions: SIFT (Lowe 2004) on perspective views in all directions,
// which avoids the distortion at the poles and the cut at the seam.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/panorama/panorama_sampler.h"

namespace raywalk::calibrate {

struct PanoramaFeatures {
  std::vector<Eigen::Vector3d> bearings{};  // unit, in the camera's frame
  // One row of unit length per feature; the similarity of two is their dot product.
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> descriptors{};
};

// Finds features in panoramas of one size. Safe to use from several threads at once.
class FeatureFinder {
 public:
  explicit FeatureFinder(PanoramaSize size);

  // `panorama` is CV_8UC3 of the size; `mask`, CV_8UC1 of the size or empty, is 0 where features
  // are discarded.
  PanoramaFeatures find(const cv::Mat& panorama, const cv::Mat& mask) const;

 private:
  // A perspective view and the positions of its pixels in a panorama.
  struct View {
    Eigen::Matrix3d camera_from_view = Eigen::Matrix3d::Identity();
    double focal_px = 1.0;
    int size_px = 0;
    std::vector<PixelPosition> pixels{};  // row by row

    Eigen::Vector3d direction(double u, double v) const;
  };

  static cv::Mat picture_of(const View& view, const PanoramaSampler& panorama);
  static View make_view(const Attitude& axis, PanoramaSize size);
  static bool belongs_to(const View& view, const Eigen::Vector3d& direction);

  static bool allowed(const cv::Mat& mask, const View& view, const cv::KeyPoint& point);

  std::vector<View> views_;
};

// Matches of two panoramas: mutual nearest neighbours by descriptor that pass the ratio test and
// whose bearings are at most `gate_rad` apart in the common frame.
struct FeaturePair {
  int a = 0;
  int b = 0;
};
std::vector<FeaturePair> match_features(const PanoramaFeatures& a,
                                        const Eigen::Matrix3d& common_from_a,
                                        const PanoramaFeatures& b,
                                        const Eigen::Matrix3d& common_from_b, double gate_rad);

}  // namespace raywalk::calibrate
