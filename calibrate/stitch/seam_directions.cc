#include "calibrate/stitch/seam_directions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/base/median.h"
#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

constexpr double kLightFocal_px = 250.0;    // approximate, of the reduced pictures
constexpr PanoramaSize kLattice{720, 360};  // half a degree
constexpr std::size_t kMostDirections = 4000;
constexpr int kFewestDirections = 3;

using Levels = std::array<double, 3>;

// Levels corrected as by the stitcher.
Levels corrected(const Levels& levels, const LensBalance& balance, bool back, double angle_rad) {
  Levels result{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double factor = balance.share_at(angle_rad) * (back ? balance.back_gain[c] : 1.0);
    result[c] = (levels[c] + kSrgbShift_levels) * root_of_light(factor) - kSrgbShift_levels;
  }
  return result;
}

double mean_of(const Levels& levels) { return (levels[0] + levels[1] + levels[2]) / 3.0; }

double correlation_of(const std::vector<double>& a, const std::vector<double>& b) {
  double mean_a = 0.0, mean_b = 0.0;
  const auto count = static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    mean_a += a[i] / count;
    mean_b += b[i] / count;
  }
  double aa = 0.0, bb = 0.0, ab = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
    ab += (a[i] - mean_a) * (b[i] - mean_b);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

// Sigma of a Gaussian. Pixels beyond kPatchRadius_px, which may be outside of the image circle,
// have a thousandth of the weight.
constexpr double kSmoothing_px = 1.5;
// Excludes sRGB's toe and coarsely rounded dark levels, and clipped or compressed highlights.
constexpr double kDarkest_levels = 16.0;
constexpr double kBrightest_levels = 240.0;

// 255 where no pixel of the patch is masked and no colour of it is too dark or too bright. `mask`
// was reduced like the picture.
cv::Mat usable_in(const cv::Mat& picture, const cv::Mat& mask) {
  cv::Mat in_range, usable;
  cv::inRange(picture, cv::Scalar::all(kDarkest_levels), cv::Scalar::all(kBrightest_levels),
              in_range);
  if (!mask.empty()) in_range &= mask == 255;
  const int side = 2 * static_cast<int>(kPatchRadius_px) + 1;
  cv::erode(in_range, usable, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}), {-1, -1},
            1, cv::BORDER_CONSTANT, cv::Scalar::all(0));
  return usable;
}

}  // namespace

int light_shrink(const DualFisheyeCamera& camera) {
  const double focal = std::min(camera.layout.front.focal_px, camera.layout.back.focal_px);
  return std::max(1, static_cast<int>(std::lround(focal / kLightFocal_px)));
}

std::vector<SeamDirection> seam_directions(const DualFisheyeCamera& camera) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const LensView front = front_view(camera, kInfinity), back = back_view(camera, kInfinity);
  const double patch_px = light_shrink(camera) * kPatchRadius_px;
  std::vector<SeamDirection> all;
  for (int v = 0; v < kLattice.height; ++v) {
    // Fewer columns near the poles for a uniform density of directions.
    const double phi = angles_from_pixel({0.0, static_cast<double>(v)}, kLattice).phi_rad;
    const int columns = std::max(1, static_cast<int>(std::lround(kLattice.width * std::cos(phi))));
    for (int u = 0; u < columns; ++u) {
      const double theta = -kPi + (u + 0.5) * kTwoPi / columns;
      const Eigen::Vector3d direction = direction_from_angles({theta, phi});
      const auto in_front = front.look(direction), in_back = back.look(direction);
      if (!in_front || !in_back) continue;
      if (in_front->margin_rad * camera.layout.front.focal_px < patch_px ||
          in_back->margin_rad * camera.layout.back.focal_px < patch_px) {
        continue;
      }
      all.push_back({*in_front, *in_back});
    }
  }
  const std::size_t step = all.size() / kMostDirections + 1;
  std::vector<SeamDirection> spread;
  for (std::size_t i = 0; i < all.size(); i += step) spread.push_back(all[i]);
  return spread;
}

LightPictures light_pictures(const FramePictures& pictures, int shrink) {
  LightPicture front(pictures.front, pictures.mask, shrink);
  if (pictures.front.data == pictures.back.data) return {front, front};
  return {std::move(front), LightPicture(pictures.back, pictures.mask, shrink)};
}

std::vector<LightRatio> seam_ratios(const LightPictures& pictures,
                                    const std::vector<SeamDirection>& directions) {
  std::vector<LightRatio> ratios;
  for (const SeamDirection& direction : directions) {
    const auto front = pictures.front.levels_at(direction.front.pixel);
    const auto back = pictures.back.levels_at(direction.back.pixel);
    if (!front || !back) continue;
    ratios.push_back({{false, direction.front.angle_rad},
                      {true, direction.back.angle_rad},
                      log_light_ratio(*front, *back),
                      std::nullopt});
  }
  return ratios;
}

SeamFigures seam_figures(const LightPictures& pictures,
                         const std::vector<SeamDirection>& directions, const LensBalance& balance) {
  std::vector<double> fronts, backs, steps;
  for (const SeamDirection& direction : directions) {
    const auto front = pictures.front.levels_at(direction.front.pixel);
    const auto back = pictures.back.levels_at(direction.back.pixel);
    if (!front || !back) continue;
    fronts.push_back(mean_of(corrected(*front, balance, false, direction.front.angle_rad)));
    backs.push_back(mean_of(corrected(*back, balance, true, direction.back.angle_rad)));
    steps.push_back(fronts.back() - backs.back());
  }
  SeamFigures figures;
  figures.directions = static_cast<int>(steps.size());
  if (figures.directions < kFewestDirections) return figures;
  figures.step_levels = median(std::move(steps));
  figures.correlation = correlation_of(fronts, backs);
  return figures;
}

LightPicture::LightPicture(const cv::Mat& picture, const cv::Mat& mask, int shrink)
    : full_(picture.size()) {
  const auto reduce = [&](const cv::Mat& full, cv::Mat* reduced) {
    cv::resize(full, *reduced, {std::max(1, full.cols / shrink), std::max(1, full.rows / shrink)},
               0.0, 0.0, cv::INTER_AREA);
  };
  cv::Mat small, small_mask;
  reduce(picture, &small);
  if (!mask.empty()) reduce(mask, &small_mask);
  cv::cvtColor(small, grey_, cv::COLOR_BGR2GRAY);
  usable_ = usable_in(small, small_mask);
  small.convertTo(levels_, CV_32F);
  cv::GaussianBlur(levels_, levels_, {0, 0}, kSmoothing_px);
}

PixelPosition LightPicture::small_from_full(PixelPosition full) const {
  return {(full.u + 0.5) * grey_.cols / full_.width - 0.5,
          (full.v + 0.5) * grey_.rows / full_.height - 0.5};
}

PixelPosition LightPicture::full_from_small(PixelPosition small) const {
  return {(small.u + 0.5) * full_.width / grey_.cols - 0.5,
          (small.v + 0.5) * full_.height / grey_.rows - 0.5};
}

std::optional<std::array<double, 3>> LightPicture::levels_at(PixelPosition full) const {
  const PixelPosition at = small_from_full(full);
  const int u = static_cast<int>(std::floor(at.u)), v = static_cast<int>(std::floor(at.v));
  if (u < 0 || v < 0 || u + 1 >= levels_.cols || v + 1 >= levels_.rows) return std::nullopt;
  if (usable_.at<unsigned char>(v, u) == 0) return std::nullopt;
  const auto right = static_cast<float>(at.u - u), down = static_cast<float>(at.v - v);
  const cv::Vec3f upper =
      (1.0F - right) * levels_.at<cv::Vec3f>(v, u) + right * levels_.at<cv::Vec3f>(v, u + 1);
  const cv::Vec3f lower = (1.0F - right) * levels_.at<cv::Vec3f>(v + 1, u) +
                          right * levels_.at<cv::Vec3f>(v + 1, u + 1);
  const cv::Vec3f level = (1.0F - down) * upper + down * lower;
  return std::array<double, 3>{level[0], level[1], level[2]};
}

double log_light(double level) { return kSrgbExponent * std::log(level + kSrgbShift_levels); }

std::array<double, 3> log_light_ratio(const std::array<double, 3>& a,
                                      const std::array<double, 3>& b) {
  return {log_light(b[0]) - log_light(a[0]), log_light(b[1]) - log_light(a[1]),
          log_light(b[2]) - log_light(a[2])};
}

}  // namespace raywalk::calibrate
