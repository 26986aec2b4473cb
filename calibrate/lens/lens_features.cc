#include "calibrate/lens/lens_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "calibrate/lens/image_circle.h"

namespace raywalk::calibrate {
namespace {

// Larger pictures are reduced first: the finest features of a 6K frame are noise, and the time
// grows with the area.
constexpr double kLargestRadius_px = 800.0;

// A lower threshold than Lowe's: plain walls have weak features, and outliers are removed later.
constexpr double kContrast = 0.02;

// Rings and sectors of the cells over which features are spread.
constexpr std::size_t kRings = 8;
constexpr std::size_t kSectors = 16;

struct Found {
  PixelPosition seen{};  // of the full picture
  double size_px = 0.0;  // likewise, of its neighbourhood
  float response = 0.0F;
  int row = 0;  // of its descriptor
};

struct Detection {
  std::vector<Found> found{};
  cv::Mat descriptors{};
};

Detection detect(const cv::Mat& picture, double scale) {
  // OpenCV doubles the picture first, which puts pixel u at 2 u + 0.5, and halves the positions.
  constexpr double kShift_px = 0.25;
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  if (scale < 1.0) cv::resize(grey, grey, {}, scale, scale, cv::INTER_AREA);
  std::vector<cv::KeyPoint> points;
  Detection result;
  cv::SIFT::create(0, 3, kContrast)
      ->detectAndCompute(grey, cv::noArray(), points, result.descriptors);
  const auto in_full = [&](double at) { return (at - kShift_px + 0.5) / scale - 0.5; };
  for (const cv::KeyPoint& point : points) {
    result.found.push_back({{in_full(point.pt.x), in_full(point.pt.y)},
                            point.size / scale,
                            point.response,
                            static_cast<int>(result.found.size())});
  }
  return result;
}

// Whether the neighbourhood of a feature, a square around it, holds no masked pixel.
bool unmasked(const Found& found, const cv::Mat& mask) {
  if (mask.empty()) return true;
  const int reach = static_cast<int>(std::ceil(found.size_px));
  const cv::Rect around(static_cast<int>(std::lround(found.seen.u)) - reach,
                        static_cast<int>(std::lround(found.seen.v)) - reach, 2 * reach + 1,
                        2 * reach + 1);
  const cv::Rect inside = around & cv::Rect({0, 0}, mask.size());
  return cv::countNonZero(mask(inside)) == inside.area();
}

bool usable(const Found& found, const FisheyeLens& lens, const Eigen::Matrix3d& camera_from_lens,
            const FeatureOptions& options) {
  const double margin_px = std::max(3.0, found.size_px);
  if (distance_px(found.seen, lens.centre) > rim_radius_px(lens) - margin_px) return false;
  if (options.ignore_below_rad <= 0.0) return true;
  const auto direction = unproject(lens, found.seen);
  return direction &&
         (camera_from_lens * *direction).dot(options.down) < std::cos(options.ignore_below_rad);
}

// The strongest of every cell. SIFT returns a point once per orientation of its neighbourhood; only
// the first is kept, as duplicates would count twice.
std::vector<Found> spread(std::vector<Found> found, const FisheyeLens& lens, int most) {
  std::ranges::stable_sort(found, std::ranges::greater(), &Found::response);
  const double rim_px = rim_radius_px(lens);
  const int most_per_cell = std::max(1, most / static_cast<int>(kRings * kSectors));
  std::array<std::array<int, kSectors>, kRings> count{};
  std::vector<Found> kept;
  for (const Found& one : found) {
    const double right = one.seen.u - lens.centre.u, down = one.seen.v - lens.centre.v;
    // Rings of the same area.
    const double share = (right * right + down * down) / (rim_px * rim_px);
    const double turn = (std::atan2(down, right) + kPi) / kTwoPi;
    int& in_cell = count[std::min(static_cast<std::size_t>(kRings * share), kRings - 1)]
                        [std::min(static_cast<std::size_t>(kSectors * turn), kSectors - 1)];
    const bool again = !kept.empty() && distance_px(kept.back().seen, one.seen) == 0.0;
    if (in_cell < most_per_cell && !again) {
      ++in_cell;
      kept.push_back(one);
    }
  }
  return kept;
}

// RootSIFT: square roots of descriptors that sum to 1, compared by the Hellinger distance, which
// discriminates better than the Euclidean one (Arandjelovic and Zisserman 2012).
void add_descriptor(const cv::Mat& descriptor, cv::Mat* descriptors) {
  cv::Mat row;
  descriptor.convertTo(row, CV_32F, 1.0 / std::max(1e-6, cv::sum(descriptor)[0]));
  cv::sqrt(row, row);
  descriptors->push_back(row);
}

}  // namespace

LensFeatures find_lens_features(const LensPictures& pictures, const DualFisheyeCamera& camera,
                                const FeatureOptions& options) {
  const DualFisheyeLayout& layout = camera.layout;
  const double scale = std::min(
      1.0, kLargestRadius_px / std::max(rim_radius_px(layout.front), rim_radius_px(layout.back)));
  const Detection in_front = detect(pictures.front, scale);
  const Detection in_back = camera.two_files ? detect(pictures.back, scale) : in_front;
  LensFeatures result;
  for (const bool back : {false, true}) {
    const Detection& detection = back ? in_back : in_front;
    const FisheyeLens& lens = back ? layout.back : layout.front;
    const Eigen::Matrix3d camera_from_lens =
        back ? world_from_camera(layout.back_attitude) : Eigen::Matrix3d::Identity();
    std::vector<Found> of_lens;
    for (const Found& found : detection.found) {
      if (!camera.two_files && belongs_to_back(layout, found.seen) != back) continue;
      if (!unmasked(found, pictures.mask)) continue;
      if (usable(found, lens, camera_from_lens, options)) of_lens.push_back(found);
    }
    for (const Found& found : spread(std::move(of_lens), lens, options.most_per_lens)) {
      result.features.push_back({found.seen, back});
      add_descriptor(detection.descriptors.row(found.row), &result.descriptors);
    }
  }
  return result;
}

}  // namespace raywalk::calibrate
