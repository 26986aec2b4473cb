#include "calibrate/rectify/levels_under_gain.h"

#include <algorithm>

#include "core/panorama/srgb.h"

namespace raywalk::calibrate {

LevelsUnderGain::LevelsUnderGain(const LightGain& gain) {
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < table_[c].size(); ++i) {
      const double level = static_cast<double>(i) / kStepsPerLevel;
      table_[c][i] =
          static_cast<float>(srgb_level_from_linear(gain[c] * linear_from_srgb_level(level)));
    }
  }
}

cv::Vec3f LevelsUnderGain::operator()(const cv::Vec3f& levels) const {
  cv::Vec3f changed;
  for (int c = 0; c < 3; ++c) {
    const auto& table = table_[static_cast<std::size_t>(2 - c)];
    const float at = std::clamp(levels[c], 0.0f, 255.0f) * kStepsPerLevel;
    const auto below = static_cast<std::size_t>(at);
    const float share = at - static_cast<float>(below);
    changed[c] = table[below] + share * (table[below + 1] - table[below]);
  }
  return changed;
}

}  // namespace raywalk::calibrate
