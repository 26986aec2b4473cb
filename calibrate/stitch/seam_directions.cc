#include "calibrate/stitch/seam_directions.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace raywalk::calibrate
