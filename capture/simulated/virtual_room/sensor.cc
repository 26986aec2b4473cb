#include "capture/simulated/virtual_room/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/simulated/virtual_room/hash_random.h"
#include "capture/simulated/virtual_room/tone.h"
#include "core/base/error.h"
#include "core/base/parallel.h"

namespace raywalk {
namespace {

// The level, not rounded, that each level becomes under the gain.
std::array<double, 256> exposed_levels(double gain) {
  std::array<double, 256> levels{};
  for (int i = 0; i < 256; ++i) {
    const double linear = std::min(gain * linear_from_srgb_level(i), 1.0);
    levels[static_cast<std::size_t>(i)] = srgb_level_from_linear(linear);
  }
  return levels;
}

}  // namespace

cv::Mat apply_sensor(const cv::Mat& image, const SensorSettings& sensor, double gain,
                     std::uint64_t key) {
  if (image.type() != CV_8UC3) throw Error("a sensor's picture must have three 8-bit channels");
  if (!(gain > 0.0)) throw Error("a sensor's gain must be positive");
  const std::array<double, 256> levels = exposed_levels(gain);
  const double dark_variance = sensor.noise_levels * sensor.noise_levels;
  const bool noisy = dark_variance > 0.0 || sensor.shot_noise > 0.0;
  cv::Mat out(image.size(), CV_8UC3);
  const int channels = 3 * image.cols;
  parallel_for(0, image.rows, 16, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      const std::uint64_t row_key = hash_bits(key, static_cast<std::uint64_t>(row));
      const auto* from = image.ptr<unsigned char>(row);
      auto* to = out.ptr<unsigned char>(row);
      NormalPair deviates;
      for (int i = 0; i < channels; ++i) {
        double level = levels[from[i]];
        if (noisy) {
          // Normal deviates come in pairs.
          if (i % 2 == 0) deviates = normal_pair(hash_bits(row_key, static_cast<std::uint64_t>(i)));
          const double sigma = std::sqrt(dark_variance + sensor.shot_noise * level);
          level += sigma * (i % 2 == 0 ? deviates.first : deviates.second);
        }
        to[i] = static_cast<unsigned char>(std::lround(std::clamp(level, 0.0, 255.0)));
      }
    }
  });
  return out;
}

}  // namespace raywalk
