#include "core/evaluate/silhouettes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/evaluate/metrics.h"

namespace raywalk {
namespace {

constexpr int kReach_px = 2;
constexpr double kNoSurface_mm = 65535.0;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// With columns of the other side of the seam on both sides.
cv::Mat with_seam(const cv::Mat& image, int columns) {
  cv::Mat wider;
  cv::copyMakeBorder(image, wider, 0, 0, columns, columns, cv::BORDER_WRAP);
  return wider;
}

cv::Mat median_3x3(const cv::Mat& image) {
  cv::Mat median;
  cv::medianBlur(with_seam(image, 1), median, 3);
  return median.colRange(1, 1 + image.cols);
}

// Over the channels.
cv::Mat largest_difference(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  std::array<cv::Mat, 3> channels;
  cv::split(difference, channels.data());
  return cv::max(channels[0], cv::max(channels[1], channels[2]));
}

cv::Mat specks(const cv::Mat& view, const cv::Mat& truth) {
  return (largest_difference(view, median_3x3(view)) > 32) &
         (largest_difference(truth, median_3x3(truth)) < 16) &
         (largest_difference(view, truth) > 48);
}

double psnr_within(const cv::Mat& view, const cv::Mat& truth, const cv::Mat& mask) {
  return cv::countNonZero(mask) == 0 ? kNan : std::min(psnr_db(view, truth, mask), kMaxPsnrDb);
}

}  // namespace

cv::Mat near_silhouettes(const cv::Mat& distances_mm) {
  if (distances_mm.empty() || distances_mm.type() != CV_16UC1) {
    throw Error("silhouettes need distances of 16 bits in one channel");
  }
  cv::Mat distance;
  with_seam(distances_mm, kReach_px + 1).convertTo(distance, CV_32F);
  distance.setTo(kNoSurface_mm, distance == 0.0);
  const cv::Mat neighbours = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
  cv::Mat farthest, nearest;
  cv::dilate(distance, farthest, neighbours);
  cv::erode(distance, nearest, neighbours);
  // 1.15 = 23 / 20, exact in whole numbers.
  const cv::Mat own_20 = 20.0 * distance, own_23 = 23.0 * distance;
  const cv::Mat silhouettes = (20.0 * farthest > own_23) | (own_20 > 23.0 * nearest);
  constexpr int kSide_px = 2 * kReach_px + 1;
  cv::Mat near;
  cv::dilate(silhouettes, near, cv::Mat::ones(kSide_px, kSide_px, CV_8UC1));
  return near.colRange(kReach_px + 1, kReach_px + 1 + distances_mm.cols).clone();
}

SilhouetteScores score_silhouettes(const cv::Mat& view, const cv::Mat& truth,
                                   const cv::Mat& distances_mm, const cv::Mat& mask) {
  require_image_pair(view, truth, 1);
  if (distances_mm.size() != truth.size()) {
    throw Error("silhouettes need distances of the size of the images");
  }
  const cv::Mat near = near_silhouettes(distances_mm);
  cv::Mat counted = cv::Mat(truth.size(), CV_8UC1, cv::Scalar(255));
  if (!mask.empty()) counted = mask != 0;
  const cv::Mat counted_near = near & counted, counted_elsewhere = counted & ~near;
  const double pixels = cv::countNonZero(counted);
  if (pixels == 0.0) throw Error("cannot measure silhouettes: the mask selects no pixel");
  return {.near_psnr_db = psnr_within(view, truth, counted_near),
          .elsewhere_psnr_db = psnr_within(view, truth, counted_elsewhere),
          .near_share = cv::countNonZero(counted_near) / pixels,
          .specks_per_mpx = 1e6 * cv::countNonZero(specks(view, truth) & counted) / pixels};
}

}  // namespace raywalk
