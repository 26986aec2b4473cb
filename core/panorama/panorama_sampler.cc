#include "core/panorama/panorama_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raywalk {
namespace {

// Rows and columns that cubic interpolation reads beyond each border.
constexpr int kSampleBorder = 2;

// Catmull-Rom weights of the samples at -1, 0, 1, 2 for a position t in [0, 1): the cubic through
// the inner two whose slopes there are the central differences.
std::array<float, 4> cubic_weights(float t) {
  return {t * (-0.5F + t * (1.0F - 0.5F * t)), 1.0F + t * t * (-2.5F + 1.5F * t),
          t * (0.5F + t * (2.0F - 1.5F * t)), t * t * (-0.5F + 0.5F * t)};
}

cv::Mat picture_with_border(const cv::Mat& image) {
  cv::Mat bordered(image.rows + 2 * kSampleBorder, image.cols + 2 * kSampleBorder, image.type());
  for (int v = 0; v < bordered.rows; ++v) {
    for (int u = 0; u < bordered.cols; ++u) {
      bordered.at<cv::Vec3b>(v, u) =
          image.at<cv::Vec3b>(wrapped_pixel(u - kSampleBorder, v - kSampleBorder, image.size()));
    }
  }
  return bordered;
}

}  // namespace

cv::Point wrapped_pixel(int u, int v, cv::Size size) {
  if (v < 0 || v >= size.height) {
    v = v < 0 ? -1 - v : 2 * size.height - 1 - v;
    u += size.width / 2;
  }
  return {((u % size.width) + size.width) % size.width, std::clamp(v, 0, size.height - 1)};
}

PanoramaSampler::PanoramaSampler(const cv::Mat& panorama)
    : size_{panorama.cols, panorama.rows}, bordered_(picture_with_border(panorama)) {}

cv::Vec3f PanoramaSampler::at(PixelPosition position) const {
  const int u = static_cast<int>(std::floor(position.u));
  const int v = static_cast<int>(std::floor(position.v));
  const std::array<float, 4> across = cubic_weights(static_cast<float>(position.u - u));
  const std::array<float, 4> down = cubic_weights(static_cast<float>(position.v - v));
  cv::Vec3f sum(0, 0, 0);
  for (int row = 0; row < 4; ++row) {
    const cv::Vec3b* pixels =
        bordered_.ptr<cv::Vec3b>(v - 1 + row + kSampleBorder) + u - 1 + kSampleBorder;
    cv::Vec3f along(0, 0, 0);
    for (int column = 0; column < 4; ++column) {
      along += across[static_cast<size_t>(column)] * cv::Vec3f(pixels[column]);
    }
    sum += down[static_cast<size_t>(row)] * along;
  }
  return sum;
}

}  // namespace raywalk
