#include "core/view/exposure.h"

#include <algorithm>
#include <opencv2/core.hpp>

#include "core/panorama/transposed_border.h"

namespace raywalk {

Exposure::Exposure(const Room& room) : panorama_(room.panorama()) {
  for (const auto& line : room.gains()) {
    auto& fields = fields_.emplace_back();
    for (const GainField& field : line) {
      fields.emplace_back();
      if (raywalk::is_one(field)) continue;
      const cv::Scalar whole(field.whole[0], field.whole[1], field.whole[2]);
      cv::Mat factors =
          field.local.empty() ? cv::Mat(1, 1, CV_32FC3, cv::Scalar::all(1.0)) : field.local.clone();
      cv::multiply(factors, whole, factors);
      fields.back() = with_border(factors, 1);
    }
  }
}

cv::Vec4f Exposure::at(int line, int station, float u, float v) const {
  const cv::Mat& factors = field(line, station);
  if (factors.empty()) return {1.0f, 1.0f, 1.0f, 0.0f};
  // From the middle of a pixel to that of a patch, which is 1 more because of the border.
  const float width = static_cast<float>(panorama_.width);
  const float theta = (u + 0.5f) / width * static_cast<float>(factors.rows - 2) + 0.5f;
  const float phi =
      (v + 0.5f) / static_cast<float>(panorama_.height) * static_cast<float>(factors.cols - 2) +
      0.5f;
  const int column = std::clamp(static_cast<int>(theta), 0, factors.rows - 2);
  const int row = std::clamp(static_cast<int>(phi), 0, factors.cols - 2);
  const float right = theta - static_cast<float>(column);
  const float lower = phi - static_cast<float>(row);
  const auto between = [lower](const cv::Vec3f& a, const cv::Vec3f& b) -> cv::Vec3f {
    return a + lower * (b - a);
  };
  const auto* left_column = factors.ptr<cv::Vec3f>(column) + row;
  const auto* right_column = factors.ptr<cv::Vec3f>(column + 1) + row;
  const cv::Vec3f at_left = between(left_column[0], left_column[1]);
  const cv::Vec3f at_right = between(right_column[0], right_column[1]);
  const cv::Vec3f gain = at_left + right * (at_right - at_left);
  return {gain[0], gain[1], gain[2], 0.0f};
}

}  // namespace raywalk
