#include "build_lf/depth/station_colours.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "build_lf/depth/station_picture.h"
#include "core/panorama/transposed_border.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {

StationColours station_colours(const Room& room, StationIndex station, PanoramaSize size,
                               const GainField& gains) {
  // Levels that a camera may have clipped.
  constexpr double kDarkest = 4.0;
  constexpr double kBrightest = 250.0;
  const cv::Mat image = station_image(room, station, size);
  StationColours colours;
  colours.shown = image.clone();
  apply_gains(gains, &colours.shown);
  colours.least = colours.shown.clone();
  colours.most = colours.shown.clone();
  colours.least.reshape(1).setTo(0, image.reshape(1) <= kDarkest);
  colours.most.reshape(1).setTo(255, image.reshape(1) >= kBrightest);
  return colours;
}

cv::Mat ranges_of(const StationColours& colours) {
  cv::Mat ranges;
  cv::merge(std::vector<cv::Mat>{colours.least, colours.most}, ranges);
  return ranges;
}

cv::Mat sampled_ranges(const StationColours& colours, const cv::Mat& valid) {
  const cv::Mat half_pixel = cv::getStructuringElement(cv::MORPH_CROSS, {3, 3});
  const auto sampled = [](const cv::Mat& picture) {
    constexpr int kBorder = 8;
    cv::Mat samples;
    cv::resize(with_border(picture, kBorder), samples, {}, kSamplesPerPixel, kSamplesPerPixel,
               cv::INTER_CUBIC);
    return without_border(samples, kBorder * kSamplesPerPixel).clone();
  };
  StationColours samples{{}, sampled(colours.least), sampled(colours.most)};
  cv::erode(samples.least, samples.least, half_pixel);
  cv::dilate(samples.most, samples.most, half_pixel);
  if (!valid.empty()) {
    cv::Mat masked;
    cv::resize(valid == 0, masked, samples.least.size(), 0, 0, cv::INTER_NEAREST);
    samples.least.setTo(cv::Scalar::all(255), masked);
    samples.most.setTo(cv::Scalar::all(0), masked);
  }
  return ranges_of(samples);
}

}  // namespace raywalk::build_lf
