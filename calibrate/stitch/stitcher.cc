#include "calibrate/stitch/stitcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "calibrate/stitch/seam_blend.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

constexpr float kBrightest = 255.0F;

// 255 where a sample reads only valid pixels; 0 elsewhere, also where the lens is not sampled.
cv::Mat valid_samples(const cv::Mat& mask, const LensSamples& lens, const cv::Mat& sampled) {
  // Cubic interpolation reads pixels up to two away from the nearest one.
  cv::Mat least, valid;
  cv::erode(mask, least, cv::Mat::ones(5, 5, CV_8UC1));
  cv::remap(least, valid, lens.positions, cv::noArray(), cv::INTER_NEAREST, cv::BORDER_REPLICATE);
  return (valid != 0) & sampled;
}

// `front` and `back` are the two halves, CV_16SC3 of the tables' size; `mask` is that of the frame
// that holds both image circles, CV_8UC1, 0 = masked. Where both lenses are blended, a pixel that
// reads masked pixels in one of them gets the other's value in both. Returns what is valid of the
// panorama, CV_8UC1 of the tables' size, 0 or 255: 0 where all that a pixel could be read from is
// masked, if only in part.
cv::Mat join_masked_halves(const StitchTables& tables, const cv::Mat& mask, cv::Mat* front,
                           cv::Mat* back) {
  const cv::Mat in_front = valid_samples(mask, tables.front, tables.region != kBackOnly);
  const cv::Mat in_back = valid_samples(mask, tables.back, tables.region != kFrontOnly);
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

void require_valid(int width, const StitcherOptions& options) {
  if (width < kSmallestWidth_px || width > kLargestWidth_px || width % 2 != 0) {
    throw UsageError(fmt::format("a panorama cannot be {} px wide; give an even width of {} to {}",
                                 width, kSmallestWidth_px, kLargestWidth_px));
  }
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
}

StitchTables tables_of(const DualFisheyeCamera& camera, int width, const StitcherOptions& options,
                       const Eigen::Matrix3d& world_from_camera) {
  require_valid(width, options);
  const int table_width = oversampling(camera, width) * width;
  return make_stitch_tables(camera, {table_width, table_width / 2}, options, world_from_camera);
}

// By level: the shift that makes light a power of levels; on the linear toe its share of that, an
// approximation.
std::array<float, 256> shifts_of_levels() {
  std::array<float, 256> shifts{};
  for (std::size_t level = 0; level < shifts.size(); ++level) {
    shifts[level] = static_cast<float>(kSrgbShift_levels *
                                       std::min(static_cast<double>(level) / kSrgbToe_levels, 1.0));
  }
  return shifts;
}

// Levels with their light corrected by the roots, times kLevelParts. `picture` is CV_8UC3, `roots`
// CV_32FC1 and `levels` CV_16SC3, all of one size.
void correct(const cv::Mat& picture, const cv::Mat& roots, const cv::Vec3f& colour_roots,
             cv::Mat levels) {
  static const std::array<float, 256> shifts = shifts_of_levels();
  for (int v = 0; v < picture.rows; ++v) {
    const auto* from = picture.ptr<cv::Vec3b>(v);
    const auto* roots_in_row = roots.ptr<float>(v);
    auto* to = levels.ptr<cv::Vec3s>(v);
    for (int u = 0; u < picture.cols; ++u) {
      for (int c = 0; c < 3; ++c) {
        const float shift = shifts[from[u][c]];
        const float root = roots_in_row[u] * colour_roots[c];
        const float level = root * (static_cast<float>(from[u][c]) + shift) - shift;
        // Never negative, so truncation after adding a half rounds.
        const float parts = std::clamp(level, 0.0F, kBrightest) * kLevelParts + 0.5F;
        to[u][c] = static_cast<std::int16_t>(parts);
      }
    }
  }
}

// Levels times kLevelParts, CV_16SC3, of what is read from a lens; the rest is undefined.
// `other_only` is the region of the other lens alone.
cv::Mat sampled(const cv::Mat& picture, const LensSamples& lens, const cv::Vec3f& colour_roots,
                const cv::Mat& region, unsigned char other_only) {
  // Each lens shows about half of the panorama: tiles that read nothing from it are left out.
  constexpr int kTile_px = 128;
  const cv::Rect whole({0, 0}, region.size());
  cv::Mat levels(region.size(), CV_16SC3);
  cv::Mat read;
  for (int v = 0; v < whole.height; v += kTile_px) {
    for (int u = 0; u < whole.width; u += kTile_px) {
      const cv::Rect tile = cv::Rect(u, v, kTile_px, kTile_px) & whole;
      if (cv::countNonZero(region(tile) != other_only) == 0) continue;
      cv::remap(picture, read, lens.positions(tile), cv::noArray(), cv::INTER_CUBIC,
                cv::BORDER_REPLICATE);
      correct(read, lens.roots(tile), colour_roots, levels(tile));
    }
  }
  return levels;
}

}  // namespace

int default_panorama_width(const DualFisheyeCamera& camera) {
  constexpr double kMultiple = 16.0;
  const double width = kMultiple * std::round(native_width(camera) / kMultiple);
  return static_cast<int>(std::clamp<double>(width, kSmallestWidth_px, kLargestWidth_px));
}

Stitcher::Stitcher(const DualFisheyeCamera& camera, int width, const StitcherOptions& options,
                   const ColourGains& back_gain, const Eigen::Matrix3d& world_from_camera)
    : size_{width, width / 2},
      options_(options),
      tables_(tables_of(camera, width, options, world_from_camera)),
      back_roots_(static_cast<float>(root_of_light(back_gain[0])),
                  static_cast<float>(root_of_light(back_gain[1])),
                  static_cast<float>(root_of_light(back_gain[2]))) {}

void Stitcher::reduce(cv::Mat* picture) const {
  if (tables_.size == size_) return;
  const cv::Mat fine = *picture;
  cv::resize(fine, *picture, {size_.width, size_.height}, 0.0, 0.0, cv::INTER_AREA);
}

StitchedFrame Stitcher::stitch(const cv::Mat& front, const cv::Mat& back,
                               const cv::Mat& mask) const {
  const cv::Mat& region = tables_.region;
  cv::Mat levels = sampled(front, tables_.front, cv::Vec3f::all(1.0F), region, kBackOnly);
  cv::Mat back_levels = sampled(back, tables_.back, back_roots_, region, kFrontOnly);
  StitchedFrame stitched;
  if (!mask.empty()) stitched.mask = join_masked_halves(tables_, mask, &levels, &back_levels);
  blend_seam(tables_, options_, back_levels, &levels);
  levels.convertTo(stitched.panorama, CV_8U, 1.0 / kLevelParts);
  reduce(&stitched.panorama);
  if (!mask.empty()) {
    reduce(&stitched.mask);
    stitched.mask = stitched.mask == 255;
  }
  return stitched;
}

int frames_at_once(const DualFisheyeCamera& camera, int width, bool own_tables) {
  // For all frames in work.
  constexpr double kWorkBytes = 1.5e9;
  // Of pictures: read, copied with a fourth channel.
  constexpr double kBytesPerPicturePixel = 10.0;
  // Of a panorama before it is averaged down: levels of two lenses, the result, its PNG.
  constexpr double kBytesPerPanoramaPixel = 20.0;
  // A position and a root in each lens, and what picks the lens.
  constexpr double kBytesPerTablePixel = 29.0;
  const double across = static_cast<double>(oversampling(camera, width)) * width;
  const double picture_pixels = (camera.two_files ? 2.0 : 1.0) *
                                static_cast<double>(camera.picture.width) * camera.picture.height;
  const double bytes =
      kBytesPerPicturePixel * picture_pixels +
      (kBytesPerPanoramaPixel + (own_tables ? kBytesPerTablePixel : 0.0)) * 0.5 * across * across;
  return std::clamp(static_cast<int>(kWorkBytes / bytes), 1, thread_count());
}

// Tasks that wait for memory could deadlock, as the thread that holds it may pick them up.
void for_each_frame(std::size_t count, int at_once, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0;
  parallel_for(0, at_once, 1, [&](int, int) {
    for (std::size_t i = next++; i < count; i = next++) {
      throw_if_interrupted();
      try {
        work(i);
      } catch (...) {
        next = count;  // the others stop after their frame
        throw;
      }
    }
  });
}

}  // namespace raywalk::calibrate
