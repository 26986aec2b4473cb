#include "calibrate/stitch/light_tracks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/video/tracking.hpp>

namespace raywalk::calibrate {
namespace {

constexpr int kSpacing_px = 10;
constexpr int kWindow_px = 15;
constexpr int kPyramidLevels = 3;
// Smallest eigenvalue of a window's gradient matrix in OpenCV's scale, a hundred times its default:
// shading without texture would be matched where it is equally bright, which hides the vignetting.
constexpr double kLeastTexture = 1e-2;
constexpr double kMostReturnError_px = 0.3;
constexpr double kLeastMotion_px = 1.5;  // smaller motions are static or not informative

double distance(cv::Point2f a, cv::Point2f b) { return std::hypot(a.x - b.x, a.y - b.y); }

PixelPosition position(cv::Point2f point) { return {point.x, point.y}; }

// Angle of a pixel of a lens's full picture from the axis; nullopt outside of the field of view.
std::optional<double> angle_at(const FisheyeLens& lens, PixelPosition full) {
  const auto direction = unproject(lens, full);
  if (!direction) return std::nullopt;
  return std::atan2(std::hypot(direction->x(), direction->y()), direction->z());
}

std::vector<cv::Point2f> flow(const cv::Mat& from, const cv::Mat& to,
                              const std::vector<cv::Point2f>& points,
                              std::vector<unsigned char>* found) {
  std::vector<cv::Point2f> moved;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(
      from, to, points, moved, *found, error, {kWindow_px, kWindow_px}, kPyramidLevels,
      {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01}, 0, kLeastTexture);
  return moved;
}

}  // namespace

LightTracks::LightTracks(const DualFisheyeCamera& camera, LightPictures first)
    : first_(first),
      last_(std::move(first)),
      lenses_{Lens{camera.layout.front, false, {}, {}}, Lens{camera.layout.back, true, {}, {}}} {
  for (Lens& lens : lenses_) place_points(&lens);
}

// On a regular lattice within the lens's own image circle. Corners would be tracked better, but the
// mean of a patch around a corner changes with its distance, which is correlated with the angle: in
// a simulated camera this overestimated the light loss by a tenth.
void LightTracks::place_points(Lens* lens) const {
  const LightPicture& picture = picture_of(first_, *lens);
  for (int v = kSpacing_px / 2; v < picture.grey().rows; v += kSpacing_px) {
    for (int u = kSpacing_px / 2; u < picture.grey().cols; u += kSpacing_px) {
      const PixelPosition small{static_cast<double>(u), static_cast<double>(v)};
      const auto angle = angle_at(lens->model, picture.full_from_small(small));
      if (!angle) continue;
      lens->first.emplace_back(static_cast<float>(u), static_cast<float>(v));
    }
  }
  lens->last = lens->first;
}

void LightTracks::follow(const LightPicture& from, const LightPicture& to, Lens* lens) const {
  if (lens->last.empty()) return;
  std::vector<unsigned char> found, returned;
  const auto there = flow(from.grey(), to.grey(), lens->last, &found);
  const auto back = flow(to.grey(), from.grey(), there, &returned);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < there.size(); ++i) {
    if (found[i] == 0 || returned[i] == 0) continue;
    if (distance(back[i], lens->last[i]) > kMostReturnError_px) continue;
    lens->first[kept] = lens->first[i];
    lens->last[kept++] = there[i];
  }
  lens->first.resize(kept);
  lens->last.resize(kept);
}

void LightTracks::follow(const LightPictures& next) {
  for (Lens& lens : lenses_) follow(picture_of(last_, lens), picture_of(next, lens), &lens);
  last_ = next;
}

std::vector<LightRatio> LightTracks::ratios(int frames) const {
  std::vector<LightRatio> all;
  for (const Lens& lens : lenses_) {
    const LightPicture& before = picture_of(first_, lens);
    const LightPicture& after = picture_of(last_, lens);
    for (std::size_t i = 0; i < lens.first.size(); ++i) {
      if (distance(lens.first[i], lens.last[i]) < kLeastMotion_px) continue;
      const PixelPosition from = before.full_from_small(position(lens.first[i]));
      const PixelPosition to = after.full_from_small(position(lens.last[i]));
      const auto from_angle = angle_at(lens.model, from), to_angle = angle_at(lens.model, to);
      const auto from_levels = before.levels_at(from), to_levels = after.levels_at(to);
      if (!from_angle || !to_angle || !from_levels || !to_levels) continue;
      all.push_back({{lens.back, *from_angle},
                     {lens.back, *to_angle},
                     log_light_ratio(*from_levels, *to_levels),
                     frames});
    }
  }
  return all;
}

}  // namespace raywalk::calibrate
