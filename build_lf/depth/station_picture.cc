#include "build_lf/depth/station_picture.h"

#include <algorithm>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/panorama/transposed_border.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

// Border for filters and upsampling, pixels. Images are transposed here (station_image.h).
constexpr int kBorder = 16;

// (luminance - local mean) / (local deviation + noise floor), scaled to 8 bits around 128. The
// window is as small as a mean allows, so that near objects do not spread beyond their edges. The
// noise floor, a few levels, keeps sensor noise from being amplified.
cv::Mat detail_of(const cv::Mat& colours) {
  constexpr double kNeighbourhoodPx = 1.0;
  constexpr double kNoiseFloor = 4.0;
  constexpr double kLevelsPerDeviation = 60.0;
  cv::Mat luminance;
  cv::cvtColor(colours, luminance, cv::COLOR_RGB2GRAY);
  luminance.convertTo(luminance, CV_32F);
  cv::Mat mean;
  cv::Mat mean_square;
  cv::GaussianBlur(luminance, mean, {}, kNeighbourhoodPx);
  cv::GaussianBlur(luminance.mul(luminance), mean_square, {}, kNeighbourhoodPx);
  cv::Mat deviation;
  cv::sqrt(cv::max(mean_square - mean.mul(mean), 0.0), deviation);
  cv::Mat detail = (luminance - mean) / (deviation + kNoiseFloor);
  detail.convertTo(detail, CV_8U, kLevelsPerDeviation, 128.0);
  return cv::max(detail, static_cast<double>(kInvalidDetail + 1));
}

// Colours relative to their local means, so that exposures need not agree.
cv::Mat level(const cv::Mat& colours) {
  constexpr double kSigmaPx = 6.0;
  constexpr double kDarkLevels = 4.0;  // keeps noise in the dark small
  constexpr double kMeanLevel = 100.0;
  cv::Mat values, mean, result;
  colours.convertTo(values, CV_32F);
  values += cv::Scalar::all(kDarkLevels);
  cv::GaussianBlur(values, mean, {}, kSigmaPx);
  cv::divide(values, mean, values, kMeanLevel);
  values.convertTo(result, CV_8U);
  return result;
}

// Margin that keeps masked pixels out of the high-pass filter of the detail.
constexpr int kMaskMarginPx = 3;

// `valid` has the orientation of station images.
void invalidate(const cv::Mat& valid, cv::Mat* samples) {
  if (valid.empty()) return;
  cv::Mat enlarged;
  cv::resize(valid, enlarged, samples->size(), 0, 0, cv::INTER_NEAREST);
  cv::Mat invalid = enlarged == 0;
  samples->setTo(cv::Scalar(0, 0, 0, kInvalidDetail), invalid);
}

}  // namespace

StationPicture make_station_picture(const Room& room, StationIndex station, PanoramaSize map_size,
                                    const GainField& gains, const cv::Mat& valid, bool levelled,
                                    std::pmr::memory_resource* memory) {
  cv::Mat colours = station_image(room, station, map_size);
  apply_gains(gains, &colours);
  colours = with_border(colours, kBorder);
  if (levelled) colours = level(colours);
  cv::Mat samples;
  std::vector<cv::Mat> channels;
  cv::split(colours, channels);
  channels.push_back(detail_of(colours));
  cv::merge(channels, samples);
  cv::Mat enlarged;
  cv::resize(samples, enlarged, {}, kSamplesPerPixel, kSamplesPerPixel, cv::INTER_LINEAR);
  const cv::Rect inner(kBorder * kSamplesPerPixel, kBorder * kSamplesPerPixel,
                       map_size.height * kSamplesPerPixel, map_size.width * kSamplesPerPixel);
  samples = enlarged(inner).clone();
  if (!valid.empty()) invalidate(valid.t(), &samples);
  invalidate(station_validity(room, station, map_size, kMaskMarginPx), &samples);
  StationPicture picture{
      .size = {inner.height, inner.width},
      .samples = std::pmr::vector<MatchingSample>(samples.total(), memory),
  };
  std::memcpy(picture.samples.data(), samples.data, samples.total() * sizeof(MatchingSample));
  picture.all_valid = std::all_of(picture.samples.begin(), picture.samples.end(), is_valid);
  return picture;
}

}  // namespace raywalk::build_lf
