#include "calibrate/stitch/stitcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"

namespace raywalk::calibrate {
namespace {

// 255 where a sample reads only valid pixels; 0 elsewhere, also where the lens is not sampled.
cv::Mat valid_samples(const cv::Mat& mask, const LensSamples& lens, PanoramaSize size) {
  constexpr int kBorder = kFisheyeBorder;
  cv::Mat bordered, least;
  cv::copyMakeBorder(mask, bordered, kBorder, kBorder, kBorder, kBorder, cv::BORDER_REPLICATE);
  // Cubic interpolation between pixels 0 and 1 reads pixels -1 to 2.
  cv::erode(bordered, least, cv::Mat::ones(4, 4, CV_8UC1), {1, 1});
  cv::Mat valid(size.height, size.width, CV_8UC1, cv::Scalar(0));
  for (const SampleRun& run : lens.runs) {
    auto* row = valid.ptr<uchar>(run.row) + run.column;
    for (int i = 0; i < run.count; ++i) {
      const FisheyeSample& sample = lens.samples[run.first + static_cast<std::size_t>(i)];
      const int u = static_cast<int>(std::floor(sample.u)) + kBorder;
      const int v = static_cast<int>(std::floor(sample.v)) + kBorder;
      row[i] = least.at<uchar>(v, u) != 0 ? 255 : 0;
    }
  }
  return valid;
}

// `front` and `back` are the two halves, CV_16SC3 of the tables' size; `mask` is that of the frame
// that holds both image circles, CV_8UC1, 0 = masked. Where both lenses are blended, a pixel that
// reads masked pixels in one of them gets the other's value in both. Returns what is valid of the
// panorama, CV_8UC1 of the tables' size, 0 or 255: 0 where all that a pixel could be read from is
// masked, if only in part.
cv::Mat join_masked_halves(const StitchTables& tables, const cv::Mat& mask, cv::Mat* front,
                           cv::Mat* back) {
  const cv::Mat in_front = valid_samples(mask, tables.front, tables.size);
  const cv::Mat in_back = valid_samples(mask, tables.back, tables.size);
  const cv::Mat both = tables.region == kBothLenses;
  back->copyTo(*front, both & ~in_front & in_back);
  // Equal halves are blended to themselves, so that nothing of a masked pixel reaches others.
  front->copyTo(*back, both & ~in_back);
  return in_front | in_back;
}

constexpr int kSmallestWidth_px = 64;
constexpr int kLargestWidth_px = 32768;
constexpr double kWidestBlend_deg = 30.0;
// Largest ratio of the frames' resolution to the panorama's without aliasing. At the rim,
// equidistant frames are pi / 2 times as fine as in the middle anyway.
constexpr double kMostMinification = 1.25;

double native_width(const DualFisheyeCamera& camera) {
  return kPi * (camera.layout.front.focal_px + camera.layout.back.focal_px);
}

// Of the tables over the panorama.
int oversampling(const DualFisheyeCamera& camera, int width) {
  return std::max(1,
                  static_cast<int>(std::ceil(native_width(camera) / (kMostMinification * width))));
}

int checked_width(int width) {
  if (width < kSmallestWidth_px || width > kLargestWidth_px || width % 2 != 0) {
    throw UsageError(fmt::format("a panorama cannot be {} px wide; give an even width of {} to {}",
                                 width, kSmallestWidth_px, kLargestWidth_px));
  }
  return width;
}

const StitcherOptions& checked(const StitcherOptions& options) {
  if (!(options.blend_deg > 0.0 && options.blend_deg <= kWidestBlend_deg)) {
    throw UsageError(
        fmt::format("lenses cannot be blended over {:g} degrees; give more than 0 and "
                    "at most {:g}",
                    options.blend_deg, kWidestBlend_deg));
  }
  if (!(options.seam_distance_m > 0.0)) {
    throw UsageError(
        fmt::format("the seam distance is {:g} m; give more than 0, or leave it out for "
                    "infinity",
                    options.seam_distance_m));
  }
  return options;
}

PanoramaSize scaled(PanoramaSize size, int factor) {
  return {factor * size.width, factor * size.height};
}

// With the border that cubics read, and a fourth channel so that a pixel has 32 bits.
cv::Mat padded(const cv::Mat& picture) {
  constexpr int border_px = kFisheyeBorder;
  cv::Mat bordered(picture.rows + 2 * border_px, picture.cols + 2 * border_px, CV_8UC4);
  cv::Mat inner = bordered(cv::Rect({border_px, border_px}, picture.size()));
  cv::cvtColor(picture, inner, cv::COLOR_BGR2BGRA);
  // Writes only the border, as the source is already in the middle of the result.
  cv::copyMakeBorder(inner, bordered, border_px, border_px, border_px, border_px,
                     cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  return bordered;
}

// Levels times kLevelParts, CV_16SC3; only what the runs cover is written.
cv::Mat sampled(const cv::Mat& bordered, const LensSamples& lens, const ColourRoots& colours,
                PanoramaSize size) {
  const FisheyePixels pixels{bordered.ptr(kFisheyeBorder) + 4 * kFisheyeBorder,
                             static_cast<std::int64_t>(bordered.step[0])};
  cv::Mat levels(size.height, size.width, CV_16SC3);
  for (const SampleRun& run : lens.runs) {
    fisheye_kernels().sample(pixels, &lens.samples[run.first], run.count, colours,
                             levels.ptr<std::int16_t>(run.row) + std::ptrdiff_t{3} * run.column);
  }
  return levels;
}

}  // namespace

int default_panorama_width(const DualFisheyeCamera& camera) {
  constexpr double kMultiple = 16.0;
  const double width = kMultiple * std::round(native_width(camera) / kMultiple);
  return static_cast<int>(std::clamp<double>(width, kSmallestWidth_px, kLargestWidth_px));
}

double table_pixels(const DualFisheyeCamera& camera, int width) {
  const double across = static_cast<double>(oversampling(camera, width)) * width;
  return 0.5 * across * across;
}

Stitcher::Stitcher(const DualFisheyeCamera& camera, int width, const StitcherOptions& options,
                   const LensBalance& balance, const Eigen::Matrix3d& world_from_camera)
    : size_{checked_width(width), width / 2},
      oversampling_(oversampling(camera, width)),
      tables_(make_stitch_tables(camera, scaled(size_, oversampling_), checked(options), balance,
                                 world_from_camera)),
      seam_(tables_, options) {
  for (std::size_t colour = 0; colour < balance.back_gain.size(); ++colour) {
    back_roots_.bgr[colour] = static_cast<float>(root_of_light(balance.back_gain[colour]));
  }
}

void Stitcher::reduce(cv::Mat* picture) const {
  if (oversampling_ == 1) return;
  cv::Mat fine = *picture;
  cv::resize(fine, *picture, {size_.width, size_.height}, 0.0, 0.0, cv::INTER_AREA);
}

void Stitcher::reduce_mask(cv::Mat* mask) const {
  if (mask->empty() || oversampling_ == 1) return;
  reduce(mask);
  *mask = *mask == 255;
}

StitchedFrame Stitcher::stitch(const cv::Mat& front, const cv::Mat& back,
                               const cv::Mat& mask) const {
  const cv::Mat front_padded = padded(front);
  const cv::Mat back_padded = front.data == back.data ? front_padded : padded(back);
  cv::Mat levels = sampled(front_padded, tables_.front, ColourRoots{}, tables_.size);
  cv::Mat back_levels = sampled(back_padded, tables_.back, back_roots_, tables_.size);
  StitchedFrame stitched;
  if (!mask.empty()) stitched.mask = join_masked_halves(tables_, mask, &levels, &back_levels);
  seam_.blend(&levels, back_levels);
  levels.convertTo(stitched.panorama, CV_8U, 1.0 / kLevelParts);
  reduce(&stitched.panorama);
  reduce_mask(&stitched.mask);
  return stitched;
}

}  // namespace raywalk::calibrate
