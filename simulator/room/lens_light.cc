#include "simulator/room/lens_light.h"

#include <cmath>

#include "core/base/parallel.h"
#include "simulator/room/cameras.h"

namespace raywalk::capture {
namespace {

double falloff(const FisheyeLens& lens, PixelPosition pixel, double vignetting) {
  const auto direction = unproject(lens, pixel);
  if (!direction) return 1.0;
  const double off_axis = std::hypot(direction->x(), direction->y());
  const double share = std::atan2(off_axis, direction->z()) / lens.largest_angle_rad;
  const double square = share * share;
  return 1.0 - vignetting * 0.5 * (square + square * square);
}

}  // namespace

cv::Mat lens_light(const DualFisheyeLayout& layout, PanoramaSize frame,
                   const LensLightSettings& settings) {
  require_monotonic_radius(layout.front);
  require_monotonic_radius(layout.back);
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

}  // namespace raywalk::capture
