#include "calibrate/grid/panorama_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/geometry/sphere.h"

namespace raywalk::calibrate {
namespace {

// Views of 100 degrees: 90 would tile the sphere, the overlap covers the neighbourhoods that
// descriptors of features at the edges need.
constexpr double kHalfView_rad = radians_from_degrees(50.0);
constexpr int kLargestView_px = 768;
constexpr int kFeaturesPerView = 350;

// The best similarity of the features in `b` to one of `a`, and the second best at another place.
struct Similarity {
  int best = -1;
  float first = -1.0F;
  float second = -1.0F;
};

// RootSIFT descriptors (Hellinger kernel; Arandjelovic and Zisserman 2012) with Lowe's ratio test
// (Lowe 2004).
Similarity best_similarity(const PanoramaFeatures& from,
                           const std::vector<Eigen::Vector3d>& from_common, int index,
                           const PanoramaFeatures& to,
                           const std::vector<Eigen::Vector3d>& to_common, double gate_cos) {
  Similarity found;
  const Eigen::Vector3d& direction = from_common[static_cast<size_t>(index)];
  const auto descriptor = from.descriptors.row(index);
  // SIFT may find one place several times, with different orientations or sizes.
  constexpr double kSamePlace_rad = radians_from_degrees(0.3);
  const double same_cos = std::cos(kSamePlace_rad);
  for (int i = 0; i < static_cast<int>(to_common.size()); ++i) {
    const Eigen::Vector3d& other = to_common[static_cast<size_t>(i)];
    if (direction.dot(other) < gate_cos) continue;
    const float similarity = descriptor.dot(to.descriptors.row(i));
    const bool same_place =
        found.best >= 0 && other.dot(to_common[static_cast<size_t>(found.best)]) > same_cos;
    if (similarity > found.first) {
      if (!same_place) found.second = found.first;
      found.first = similarity;
      found.best = i;
    } else if (!same_place && similarity > found.second) {
      found.second = similarity;
    }
  }
  return found;
}

// |x - y|^2 = 2 - 2 x.y for unit vectors.
bool passes_ratio_test(const Similarity& similarity) {
  constexpr float kRatio = 0.8F;
  return similarity.best >= 0 &&
         1.0F - similarity.first < kRatio * kRatio * (1.0F - similarity.second);
}

std::vector<Eigen::Vector3d> turned(const std::vector<Eigen::Vector3d>& bearings,
                                    const Eigen::Matrix3d& rotation) {
  std::vector<Eigen::Vector3d> result(bearings.size());
  std::transform(bearings.begin(), bearings.end(), result.begin(),
                 [&](const Eigen::Vector3d& bearing) { return rotation * bearing; });
  return result;
}

}  // namespace

FeatureFinder::FeatureFinder(PanoramaSize size) {
  for (const Attitude& axis :
       {Attitude{0, 0, 0}, Attitude{kHalfPi, 0, 0}, Attitude{kPi, 0, 0}, Attitude{-kHalfPi, 0, 0},
        Attitude{0, kHalfPi, 0}, Attitude{0, -kHalfPi, 0}}) {
    views_.push_back(make_view(axis, size));
  }
}

FeatureFinder::View FeatureFinder::make_view(const Attitude& axis, PanoramaSize size) {
  // At least the panorama's resolution (pixels per radian) everywhere: that of a perspective view
  // is lowest in the middle, where it equals the focal length.
  const double native_px = size.width / kTwoPi;
  View view{.camera_from_view = world_from_camera(axis)};
  view.size_px = std::min(kLargestView_px,
                          static_cast<int>(std::ceil(2.0 * native_px * std::tan(kHalfView_rad))));
  view.focal_px = 0.5 * view.size_px / std::tan(kHalfView_rad);
  view.pixels.reserve(static_cast<size_t>(view.size_px) * static_cast<size_t>(view.size_px));
  for (int v = 0; v < view.size_px; ++v) {
    for (int u = 0; u < view.size_px; ++u) {
      view.pixels.push_back(pixel_from_angles(angles_from_direction(view.direction(u, v)), size));
    }
  }
  return view;
}

Eigen::Vector3d FeatureFinder::View::direction(double u, double v) const {
  const double centre = 0.5 * (size_px - 1);
  return (camera_from_view * Eigen::Vector3d((u - centre) / focal_px, (centre - v) / focal_px, 1))
      .normalized();
}

cv::Mat FeatureFinder::picture_of(const View& view, const PanoramaSampler& panorama) {
  cv::Mat grey(view.size_px, view.size_px, CV_8UC1);
  for (size_t i = 0; i < view.pixels.size(); ++i) {
    const cv::Vec3f bgr = panorama.at(view.pixels[i]);
    grey.at<uchar>(static_cast<int>(i)) =
        cv::saturate_cast<uchar>(0.114F * bgr[0] + 0.587F * bgr[1] + 0.299F * bgr[2]);
  }
  return grey;
}

// Whether the mask allows the feature's whole neighbourhood: its middle and a ring at the radius of
// its descriptor (three times the size of the feature in SIFT).
bool FeatureFinder::allowed(const cv::Mat& mask, const View& view, const cv::KeyPoint& point) {
  if (mask.empty()) return true;
  const auto valid = [&](double u, double v) {
    return mask.at<uchar>(nearest_pixel(view.direction(u, v), mask.size())) != 0;
  };
  if (!valid(point.pt.x, point.pt.y)) return false;
  constexpr int kAround = 8;
  for (int i = 0; i < kAround; ++i) {
    const double angle = i * kTwoPi / kAround;
    const double radius = 1.5 * static_cast<double>(point.size);
    if (!valid(point.pt.x + radius * std::cos(angle), point.pt.y + radius * std::sin(angle))) {
      return false;
    }
  }
  return true;
}

// Views overlap: a feature belongs to the one whose axis it is nearest to.
bool FeatureFinder::belongs_to(const View& view, const Eigen::Vector3d& direction) {
  return direction.dot(view.camera_from_view.col(2)) >= direction.cwiseAbs().maxCoeff() - 1e-12;
}

PanoramaFeatures FeatureFinder::find(const cv::Mat& panorama, const cv::Mat& mask) const {
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(kFeaturesPerView);
  const PanoramaSampler sampler(panorama);
  PanoramaFeatures features;
  std::vector<cv::Mat> rows;
  for (const View& view : views_) {
    std::vector<cv::KeyPoint> points;
    cv::Mat descriptors;
    sift->detectAndCompute(picture_of(view, sampler), cv::noArray(), points, descriptors);
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d bearing = view.direction(points[i].pt.x, points[i].pt.y);
      if (!belongs_to(view, bearing) || !allowed(mask, view, points[i])) continue;
      features.bearings.push_back(bearing);
      rows.push_back(descriptors.row(static_cast<int>(i)).clone());
    }
  }
  const int length = sift->descriptorSize();
  features.descriptors.resize(static_cast<Eigen::Index>(rows.size()), length);
  for (size_t i = 0; i < rows.size(); ++i) {
    const Eigen::Map<const Eigen::RowVectorXf> row(rows[i].ptr<float>(), length);
    const float sum = std::max(1e-12F, row.lpNorm<1>());
    features.descriptors.row(static_cast<Eigen::Index>(i)) = (row / sum).cwiseSqrt();
  }
  return features;
}

std::vector<FeaturePair> match_features(const PanoramaFeatures& a,
                                        const Eigen::Matrix3d& common_from_a,
                                        const PanoramaFeatures& b,
                                        const Eigen::Matrix3d& common_from_b, double gate_rad) {
  const std::vector<Eigen::Vector3d> a_common = turned(a.bearings, common_from_a);
  const std::vector<Eigen::Vector3d> b_common = turned(b.bearings, common_from_b);
  const double gate_cos = std::cos(gate_rad);
  std::vector<FeaturePair> pairs;
  for (int i = 0; i < static_cast<int>(a_common.size()); ++i) {
    const Similarity there = best_similarity(a, a_common, i, b, b_common, gate_cos);
    if (!passes_ratio_test(there)) continue;
    const Similarity back = best_similarity(b, b_common, there.best, a, a_common, gate_cos);
    if (back.best == i && passes_ratio_test(back)) pairs.push_back({i, there.best});
  }
  return pairs;
}

}  // namespace raywalk::calibrate
