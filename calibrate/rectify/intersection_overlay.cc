#include "calibrate/rectify/intersection_overlay.h"

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/panorama/panorama_sampler.h"

namespace raywalk::calibrate {
namespace {

template <typename Pixel>
cv::Mat cut(const cv::Mat& panorama, const HorizonWindow& window) {
  cv::Mat piece(window.height, window.width, panorama.type());
  for (int v = 0; v < window.height; ++v) {
    for (int u = 0; u < window.width; ++u) {
      piece.at<Pixel>(v, u) =
          panorama.at<Pixel>(wrapped_pixel(window.left + u, window.top + v, panorama.size()));
    }
  }
  return piece;
}

// Empty if everything is valid.
cv::Mat cut_valid(const cv::Mat& valid, const HorizonWindow& window) {
  return valid.empty() ? cv::Mat() : cut<uchar>(valid, window);
}

cv::Mat grey(const cv::Mat& picture) {
  cv::Mat levels;
  cv::cvtColor(picture, levels, cv::COLOR_BGR2GRAY);
  return levels;
}

// Texture as the sum of a picture's horizontal and vertical differences.
double texture_of(const cv::Mat& levels, const cv::Mat& valid) {
  cv::Mat along, down;
  cv::Sobel(levels, along, CV_32F, 1, 0);
  cv::Sobel(levels, down, CV_32F, 0, 1);
  return cv::norm(along, cv::NORM_L1, valid) + cv::norm(down, cv::NORM_L1, valid);
}

}  // namespace

std::optional<IntersectionPair> nearest_pair(const CaptureSet& set,
                                             const LineIntersection& intersection,
                                             const FramePoses& poses) {
  std::optional<IntersectionPair> nearest;
  double least_m = std::numeric_limits<double>::infinity();
  for (const int a : set.lines[static_cast<std::size_t>(intersection.along_x)].frames) {
    for (const int b : set.lines[static_cast<std::size_t>(intersection.along_z)].frames) {
      const auto& first = poses[static_cast<std::size_t>(a)];
      const auto& second = poses[static_cast<std::size_t>(b)];
      if (!first || !second) continue;
      const double distance_m = (first->position_m - second->position_m).norm();
      if (distance_m >= least_m) continue;
      least_m = distance_m;
      nearest = IntersectionPair{a, b};
    }
  }
  return nearest;
}

HorizonWindow most_textured_window(const cv::Mat& panorama, const cv::Mat& valid) {
  const int width = panorama.cols / 4, height = std::max(1, panorama.rows * 2 / 9);
  HorizonWindow best;
  double most = -1.0;
  constexpr int kDirections = 8;
  for (int i = 0; i < kDirections; ++i) {
    const HorizonWindow window{i * panorama.cols / kDirections, width, (panorama.rows - height) / 2,
                               height};
    const double structure =
        texture_of(grey(cut<cv::Vec3b>(panorama, window)), cut_valid(valid, window));
    if (structure <= most) continue;
    most = structure;
    best = window;
  }
  return best;
}

Overlay overlay_of(const cv::Mat& first, const cv::Mat& second, const HorizonWindow& window,
                   const cv::Mat& valid) {
  const cv::Mat red = grey(cut<cv::Vec3b>(first, window)),
                cyan = grey(cut<cv::Vec3b>(second, window)), compared = cut_valid(valid, window);
  Overlay overlay;
  cv::merge(std::vector<cv::Mat>{cyan, cyan, red}, overlay.picture);
  const double pixels = compared.empty() ? static_cast<double>(red.total())
                                         : static_cast<double>(cv::countNonZero(compared));
  overlay.difference_levels = cv::norm(red, cyan, cv::NORM_L2, compared) / std::sqrt(pixels);
  return overlay;
}

}  // namespace raywalk::calibrate
