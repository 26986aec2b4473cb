#include "calibrate/rectify/compared_panorama.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/geometry/sphere.h"
#include "core/panorama/panorama_sampler.h"
#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

// Wide enough to see the parallax between stations, narrow enough to average noise.
constexpr int kWidth_px = 512;
// The border around a panorama for interpolation.
constexpr int kBorder_px = 1;
// Levels outside are clipped or dominated by noise and rounding.
constexpr int kDarkest = 10;
constexpr int kBrightest = 250;

cv::Mat reduced(const cv::Mat& picture) {
  if (picture.cols <= kWidth_px) return picture;
  cv::Mat small;
  cv::resize(picture, small, {kWidth_px, kWidth_px / 2}, 0.0, 0.0, cv::INTER_AREA);
  return small;
}

// 255 where every channel is usable and the mask, if there is one, leaves the whole pixel.
cv::Mat usable_pixels(const cv::Mat& levels, const cv::Mat& mask) {
  cv::Mat usable;
  cv::inRange(levels, cv::Scalar::all(kDarkest), cv::Scalar::all(kBrightest), usable);
  return mask.empty() ? usable : cv::Mat(usable & (reduced(mask) == 255));
}

const std::array<double, 256>& light_of_levels() {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> light{};
    for (std::size_t i = 0; i < light.size(); ++i) {
      light[i] = linear_from_srgb_level(static_cast<double>(i));
    }
    return light;
  }();
  return table;
}

}  // namespace

ComparedPanorama::ComparedPanorama(const cv::Mat& panorama, const cv::Mat& mask, bool own_mask,
                                   const FramePose& pose)
    : position_m_(pose.position_m), camera_from_world_(pose.world_from_camera.transpose()) {
  const cv::Mat levels = reduced(panorama);
  cv::Mat grey;
  cv::transform(levels, grey, cv::Matx13f(1.0F / 3.0F, 1.0F / 3.0F, 1.0F / 3.0F));
  width_ = levels.cols;
  levels_ = with_wrapped_border(levels, kBorder_px);
  grey_ = with_wrapped_border(grey, kBorder_px);
  usable_ = with_wrapped_border(usable_pixels(levels, mask), kBorder_px);
  if (own_mask) hidden_ = with_wrapped_border(reduced(mask) != 255, kBorder_px);
  find_texture();
}

double ComparedPanorama::pixel_rad() const { return kTwoPi / width_; }

// Contrast in every direction, as at corners, is what fixes the distance of a patch; it is measured
// by the lesser eigenvalue of the mean of gradient * gradient^T (Shi and Tomasi 1994).
void ComparedPanorama::find_texture() {
  constexpr int kSobel = 3;
  constexpr double kPart_deg = 14.0;
  cv::Mat contrast;
  cv::cornerMinEigenVal(grey_, contrast, kPatchSide_px, kSobel);
  if (!hidden_.empty()) {
    // The edge of a mask is not texture.
    cv::Mat near;
    cv::dilate(hidden_, near, cv::Mat::ones(kPatchSide_px + 2, kPatchSide_px + 2, CV_8UC1));
    contrast.setTo(-1.0, near);
  }
  const int height = width_ / 2;
  const int part_px = std::max(1, static_cast<int>(kPart_deg / 360.0 * width_));
  const Eigen::Matrix3d world_from_camera = camera_from_world_.transpose();
  for (int top = 0; top < height; top += part_px) {
    const int rows = std::min(part_px, height - top);
    const double breadth = std::sin((top + 0.5 * rows) / height * kPi);
    const int parts = std::max(1, static_cast<int>(width_ * breadth / part_px));
    for (int part = 0; part < parts; ++part) {
      const int left = part * width_ / parts;
      const int right = (part + 1) * width_ / parts;
      cv::Point best;
      double most = 0.0;
      cv::minMaxLoc(contrast(cv::Rect(left + kBorder_px, top + kBorder_px, right - left, rows)),
                    nullptr, &most, nullptr, &best);
      if (!hidden_.empty() && most < 0.0) continue;
      const SphereAngles angles =
          angles_from_pixel({static_cast<double>(left + best.x), static_cast<double>(top + best.y)},
                            {width_, height});
      textured_.emplace_back(world_from_camera * direction_from_angles(angles));
    }
  }
}

ComparedPanorama::Place ComparedPanorama::place_of(const Eigen::Vector3d& direction) const {
  // In single precision, which is precise to 1e-4 pixels and faster.
  const Eigen::Vector3f seen = (camera_from_world_ * direction).cast<float>();
  const auto theta = static_cast<double>(std::atan2(seen.x(), seen.z()));
  const auto phi = static_cast<double>(
      std::atan2(seen.y(), std::sqrt(seen.x() * seen.x() + seen.z() * seen.z())));
  const PanoramaSize size{width_, width_ / 2};
  const PixelPosition at = pixel_from_angles({theta, phi}, size);
  const double u = std::clamp(at.u + kBorder_px, 0.0, size.width + 2.0 * kBorder_px - 1.001);
  const double v = std::clamp(at.v + kBorder_px, 0.0, size.height + 2.0 * kBorder_px - 1.001);
  const int col = static_cast<int>(u);
  const int row = static_cast<int>(v);
  return {row, col, static_cast<float>(u - col), static_cast<float>(v - row)};
}

bool ComparedPanorama::hidden(const Eigen::Vector3d& direction) const {
  if (hidden_.empty()) return false;
  const Place at = place_of(direction);
  return cv::countNonZero(hidden_(cv::Rect(at.col, at.row, 2, 2))) > 0;
}

float ComparedPanorama::grey(const Eigen::Vector3d& direction) const {
  const Place at = place_of(direction);
  const uchar* above = grey_.ptr(at.row) + at.col;
  const uchar* below = grey_.ptr(at.row + 1) + at.col;
  const float top = above[0] + at.right * (above[1] - above[0]);
  const float bottom = below[0] + at.right * (below[1] - below[0]);
  return top + at.below * (bottom - top);
}

bool ComparedPanorama::light(const Eigen::Vector3d& direction, Eigen::Array3d* rgb) const {
  const Place at = place_of(direction);
  const auto& light = light_of_levels();
  *rgb = Eigen::Array3d::Zero();
  for (int i = 0; i < 4; ++i) {
    const int row = at.row + i / 2;
    const int col = at.col + i % 2;
    if (usable_.at<uchar>(row, col) == 0) return false;
    const double weight =
        (i % 2 == 0 ? 1.0 - at.right : at.right) * (i / 2 == 0 ? 1.0 - at.below : at.below);
    const auto& bgr = levels_.at<cv::Vec3b>(row, col);
    *rgb += weight * Eigen::Array3d(light[bgr[2]], light[bgr[1]], light[bgr[0]]);
  }
  return true;
}

}  // namespace raywalk::calibrate
