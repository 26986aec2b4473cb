#include "simulator/room/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/panorama/srgb.h"
#include "simulator/room/cameras.h"
#include "simulator/room/hash_random.h"

namespace raywalk::simulator {
namespace {

// Maps each level to its level under a gain, not rounded.
class Exposure {
 public:
  explicit Exposure(double gain) {
    for (int i = 0; i < 256; ++i) {
      const auto at = static_cast<std::size_t>(i);
      linear_[at] = gain * linear_from_srgb_level(i);
      levels_[at] = srgb_level_from_linear(std::min(linear_[at], 1.0));
    }
  }

  double level(unsigned char from) const { return levels_[from]; }
  double level(unsigned char from, float light) const {
    return srgb_level_from_linear(std::min(light * linear_[from], 1.0));
  }

 private:
  std::array<double, 256> linear_{};
  std::array<double, 256> levels_{};
};

double falloff(const FisheyeLens& lens, PixelPosition pixel, double vignetting) {
  const auto direction = unproject(lens, pixel);
  if (!direction) return 1.0;
  const double off_axis = std::hypot(direction->x(), direction->y());
  const double share = std::atan2(off_axis, direction->z()) / lens.largest_angle_rad;
  const double square = share * share;
  return 1.0 - vignetting * 0.5 * (square + square * square);
}

}  // namespace

cv::Mat apply_sensor(const cv::Mat& image, const SensorSettings& sensor, double gain,
                     std::uint64_t key, const cv::Mat& light) {
  if (image.type() != CV_8UC3) throw Error("a sensor's picture must have three 8-bit channels");
  if (!(gain > 0.0)) throw Error("a sensor's gain must be positive");
  if (!light.empty() && (light.type() != CV_32FC1 || light.size() != image.size())) {
    throw Error("the light of a sensor's pixels must be one float per pixel");
  }
  const Exposure exposure(gain);
  const double dark_variance = sensor.noise_levels * sensor.noise_levels;
  const bool noisy = dark_variance > 0.0 || sensor.shot_noise > 0.0;
  cv::Mat out(image.size(), CV_8UC3);
  const int channels = 3 * image.cols;
  parallel_for(0, image.rows, 16, [&](int begin, int end) {
    for (int row = begin; row < end; ++row) {
      const std::uint64_t row_key = hash_bits(key, static_cast<std::uint64_t>(row));
      const auto* from = image.ptr<unsigned char>(row);
      const float* lights = light.empty() ? nullptr : light.ptr<float>(row);
      auto* to = out.ptr<unsigned char>(row);
      NormalPair deviates;
      for (int i = 0; i < channels; ++i) {
        double level =
            lights == nullptr ? exposure.level(from[i]) : exposure.level(from[i], lights[i / 3]);
        if (noisy) {
          // Normal deviates are generated in pairs.
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

cv::Mat lens_light(const DualFisheyeLayout& layout, PanoramaSize frame,
                   const LensLightSettings& settings) {
  const double back_gain = std::exp2(settings.lens_gain_ev);
  cv::Mat light(frame.height, frame.width, CV_32FC1);
  parallel_for(0, frame.height, 8, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < frame.width; ++u) {
        const PixelPosition pixel{static_cast<double>(u), static_cast<double>(v)};
        const double factor = belongs_to_front(layout, pixel)
                                  ? falloff(layout.front, pixel, settings.vignetting)
                                  : back_gain * falloff(layout.back, pixel, settings.vignetting);
        light.at<float>(v, u) = static_cast<float>(factor);
      }
    }
  });
  return light;
}

}  // namespace raywalk::simulator
