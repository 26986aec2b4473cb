#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/files/image_file.h"
#include "core/panorama/srgb.h"
#include "simulator/room/surface.h"

namespace raywalk::simulator {
namespace {

cv::Mat linear_picture(const cv::Mat& levels) {
  cv::Mat linear(levels.size(), CV_32FC3);
  for (int row = 0; row < levels.rows; ++row) {
    for (int column = 0; column < levels.cols; ++column) {
      for (int channel = 0; channel < 3; ++channel) {
        linear.at<cv::Vec3f>(row, column)[channel] =
            static_cast<float>(linear_from_srgb_level(levels.at<cv::Vec3b>(row, column)[channel]));
      }
    }
  }
  return linear;
}

}  // namespace

Texture::Texture(const std::filesystem::path& file) : levels_{linear_picture(read_picture(file))} {
  while (std::min(levels_.back().cols, levels_.back().rows) > 1) {
    const cv::Size half(levels_.back().cols / 2, levels_.back().rows / 2);
    cv::Mat smaller;
    cv::resize(levels_.back(), smaller, half, 0, 0, cv::INTER_AREA);
    levels_.push_back(smaller);
  }
}

Color Texture::at(const Eigen::Vector2f& at, float footprint) const {
  const float pixels = footprint * static_cast<float>(levels_.front().cols);
  const auto last = static_cast<long>(levels_.size()) - 1;
  const auto level = std::clamp(std::lround(std::log2(std::max(pixels, 1.0F))), 0L, last);
  const cv::Mat& picture = levels_[static_cast<std::size_t>(level)];
  const float x = (at.x() - std::floor(at.x())) * static_cast<float>(picture.cols) - 0.5F;
  const float y = (std::ceil(at.y()) - at.y()) * static_cast<float>(picture.rows) - 0.5F;
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  const auto pixel = [&](int right, int down) {
    const auto& bgr = picture.at<cv::Vec3f>((row + down + picture.rows) % picture.rows,
                                            (column + right + picture.cols) % picture.cols);
    return Color(bgr[2], bgr[1], bgr[0]);
  };
  const float fx = x - static_cast<float>(column), fy = y - static_cast<float>(row);
  return mix(mix(pixel(0, 0), pixel(1, 0), fx), mix(pixel(0, 1), pixel(1, 1), fx), fy);
}

}  // namespace raywalk::simulator
