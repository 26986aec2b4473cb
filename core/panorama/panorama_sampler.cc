#include "core/panorama/panorama_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/geometry/panorama_pixels.h"

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

}  // namespace

cv::Point wrapped_pixel(int u, int v, cv::Size size) {
  if (v < 0 || v >= size.height) {
    v = v < 0 ? -1 - v : 2 * size.height - 1 - v;
    u += size.width / 2;
  }
  return {wrapped_column(u, size.width), std::clamp(v, 0, size.height - 1)};
}

cv::Mat with_wrapped_border(const cv::Mat& panorama, int border_px) {
  cv::Mat bordered(panorama.rows + 2 * border_px, panorama.cols + 2 * border_px, panorama.type());
  const std::size_t pixel_bytes = panorama.elemSize();
  for (int v = 0; v < bordered.rows; ++v) {
    for (int u = 0; u < bordered.cols; ++u) {
      const cv::Point from = wrapped_pixel(u - border_px, v - border_px, panorama.size());
      std::memcpy(bordered.ptr(v, u), panorama.ptr(from.y, from.x), pixel_bytes);
    }
  }
  return bordered;
}

cv::Point nearest_pixel(PixelPosition position, cv::Size size) {
  return wrapped_pixel(static_cast<int>(std::lround(position.u)),
                       static_cast<int>(std::lround(position.v)), size);
}

cv::Point nearest_pixel(const Eigen::Vector3d& direction, cv::Size size) {
  return nearest_pixel(
      pixel_from_angles(angles_from_direction(direction), {size.width, size.height}), size);
}

PanoramaSampler::PanoramaSampler(const cv::Mat& panorama)
    : size_{panorama.cols, panorama.rows},
      bordered_(with_wrapped_border(panorama, kSampleBorder)) {}

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
