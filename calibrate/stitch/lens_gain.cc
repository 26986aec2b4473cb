#include "calibrate/stitch/lens_gain.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "calibrate/stitch/fisheye_frames.h"
#include "calibrate/stitch/stitch_tables.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/panorama/srgb.h"

namespace raywalk::calibrate {
namespace {

constexpr std::size_t kMostFrames = 24;
constexpr std::size_t kFewestOfFrame = 50;  // a frame with fewer does not count
constexpr int kFewestPoints = 200;          // of all frames
constexpr double kLeastCorrelation = 0.5;

// Pictures are reduced to about this focal length and smoothed, so that a level is the mean over a
// patch of the same angle at any resolution, and parallax and noise count for little.
constexpr double kReducedFocal_px = 250.0;
constexpr double kSmoothing_px = 1.5;
// Pixels further away have a thousandth of the weight.
constexpr double kPatchRadius_px = 5.0;
// Excludes sRGB's toe and coarsely rounded dark levels, and clipped or compressed highlights.
constexpr double kDarkest_levels = 16.0;
constexpr double kBrightest_levels = 240.0;

// Points that both lenses see: where they are in the reduced pictures, and what corrects the
// falloff of the lens there (LensImage::root).
struct SeamPoints {
  struct OfLens {
    std::vector<cv::Point2f> at{};
    std::vector<float> roots{};
  };
  cv::Size reduced{};
  OfLens front{};
  OfLens back{};
};

// Spread evenly over the overlap, far enough from the rims for whole patches.
SeamPoints seam_points(const DualFisheyeCamera& camera) {
  constexpr PanoramaSize kLattice{360, 180};  // a degree
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const PanoramaSize full = camera.picture;
  const LensView front(camera, false, kInfinity), back(camera, true, kInfinity);
  const double focal_px = std::min(front.lens().focal_px, back.lens().focal_px);
  const int shrink = std::max(1, static_cast<int>(std::lround(focal_px / kReducedFocal_px)));
  const double margin_rad = shrink * kPatchRadius_px / focal_px;
  SeamPoints points{
      .reduced = {std::max(1, full.width / shrink), std::max(1, full.height / shrink)}};
  const auto add = [&](const LensImage& image, SeamPoints::OfLens* lens) {
    lens->at.emplace_back(
        static_cast<float>((image.pixel.u + 0.5) * points.reduced.width / full.width - 0.5),
        static_cast<float>((image.pixel.v + 0.5) * points.reduced.height / full.height - 0.5));
    lens->roots.push_back(static_cast<float>(image.root));
  };
  for (int v = 0; v < kLattice.height; ++v) {
    // Fewer columns near the poles for a uniform density of directions.
    const double phi = angles_from_pixel({0.0, static_cast<double>(v)}, kLattice).phi_rad;
    const int columns = std::max(1, static_cast<int>(std::lround(kLattice.width * std::cos(phi))));
    for (int u = 0; u < columns; ++u) {
      const double theta = -kPi + (u + 0.5) * kTwoPi / columns;
      const Eigen::Vector3d direction = direction_from_angles({theta, phi});
      const auto in_front = front.look(direction), in_back = back.look(direction);
      if (!in_front || !in_back) continue;
      if (std::min(in_front->margin_rad, in_back->margin_rad) < margin_rad) continue;
      add(*in_front, &points.front);
      add(*in_back, &points.back);
    }
  }
  return points;
}

// 255 where no pixel of a patch is masked, too dark or too bright, and none is beyond the picture.
cv::Mat usable_patches(const cv::Mat& picture, const cv::Mat& mask) {
  cv::Mat in_range, usable;
  cv::inRange(picture, cv::Scalar::all(kDarkest_levels), cv::Scalar::all(kBrightest_levels),
              in_range);
  if (!mask.empty()) in_range &= mask == 255;
  const int side = 2 * static_cast<int>(kPatchRadius_px) + 1;
  cv::erode(in_range, usable, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}), {-1, -1},
            1, cv::BORDER_CONSTANT, cv::Scalar::all(0));
  return usable;
}

// A column for each of a lens's points: shifted levels (core/panorama/srgb.h), on which a gain of
// light is a factor.
struct PatchLevels {
  cv::Mat_<cv::Vec3f> shifted{};
  cv::Mat_<unsigned char> usable{};
};

PatchLevels patch_levels(const cv::Mat& picture, const cv::Mat& mask, const cv::Size& reduced,
                         const SeamPoints::OfLens& points) {
  cv::Mat small, small_mask, smooth;
  cv::resize(picture, small, reduced, 0.0, 0.0, cv::INTER_AREA);
  if (!mask.empty()) cv::resize(mask, small_mask, reduced, 0.0, 0.0, cv::INTER_AREA);
  small.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {0, 0}, kSmoothing_px);
  PatchLevels levels;
  cv::remap(smooth, levels.shifted, points.at, cv::noArray(), cv::INTER_LINEAR);
  cv::remap(usable_patches(small, small_mask), levels.usable, points.at, cv::noArray(),
            cv::INTER_NEAREST);
  for (int i = 0; i < levels.shifted.cols; ++i) {
    cv::Vec3f& level = levels.shifted(i);
    level = (level + cv::Vec3f::all(kSrgbShift_levels)) * points.roots[static_cast<std::size_t>(i)];
  }
  return levels;
}

// Shifted levels of a frame where both lenses can be measured.
struct FrameSeam {
  std::vector<cv::Vec3f> front{};
  std::vector<cv::Vec3f> back{};
};

FrameSeam measure_frame(const CaptureFrame& frame, const DualFisheyeCamera& camera,
                        const SeamPoints& points) {
  FrameSeam seam;
  if (points.front.at.empty()) return seam;
  const FramePictures pictures = read_frame_pictures(frame, camera);
  const PatchLevels front =
      patch_levels(pictures.front, pictures.mask, points.reduced, points.front);
  const PatchLevels back = patch_levels(pictures.back, pictures.mask, points.reduced, points.back);
  for (int i = 0; i < front.shifted.cols; ++i) {
    if (front.usable(i) == 0 || back.usable(i) == 0) continue;
    seam.front.push_back(front.shifted(i));
    seam.back.push_back(back.shifted(i));
  }
  return seam;
}

ColourGains gain_of(const std::vector<FrameSeam>& seams) {
  ColourGains gains{};
  for (int colour = 0; colour < 3; ++colour) {
    std::vector<double> ratios;
    for (const FrameSeam& seam : seams) {
      for (std::size_t i = 0; i < seam.front.size(); ++i) {
        ratios.push_back(seam.back[i][colour] / seam.front[i][colour]);
      }
    }
    // Half of the points may show other surfaces in the two lenses, by parallax or gloss.
    gains[static_cast<std::size_t>(colour)] = std::pow(median(std::move(ratios)), kSrgbExponent);
  }
  return gains;
}

double correlation_of(const Eigen::ArrayXd& a, const Eigen::ArrayXd& b) {
  const Eigen::ArrayXd from_a = a - a.mean(), from_b = b - b.mean();
  const double squares = from_a.square().sum() * from_b.square().sum();
  return squares > 0.0 ? (from_a * from_b).sum() / std::sqrt(squares) : 0.0;
}

struct SeamFigures {
  double step_levels = 0.0;
  double correlation = 0.0;
};

// Medians over the frames, with the back lens corrected by a gain.
SeamFigures figures_of(const std::vector<FrameSeam>& seams, const ColourGains& back_gain) {
  const cv::Vec3d roots(root_of_light(back_gain[0]), root_of_light(back_gain[1]),
                        root_of_light(back_gain[2]));
  std::vector<double> steps, correlations;
  for (const FrameSeam& seam : seams) {
    const auto count = static_cast<Eigen::Index>(seam.front.size());
    Eigen::ArrayXd front(count), back(count);
    for (std::size_t i = 0; i < seam.front.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      front[at] = cv::Vec3d(seam.front[i]).dot(cv::Vec3d::all(1.0 / 3.0));
      back[at] = cv::Vec3d(seam.back[i]).dot(roots / 3.0);
    }
    const Eigen::ArrayXd difference = front - back;
    steps.push_back(std::abs(median({difference.begin(), difference.end()})));
    correlations.push_back(correlation_of(front, back));
  }
  return {median(std::move(steps)), median(std::move(correlations))};
}

}  // namespace

LensGain measure_lens_gain(const CaptureSet& set, const DualFisheyeCamera& camera, bool balance) {
  const SeamPoints points = seam_points(camera);
  std::vector<FrameSeam> seams(std::min(set.frames.size(), kMostFrames));
  const int count = static_cast<int>(seams.size());
  Progress progress("comparing the lenses", count, "frames");
  parallel_for(0, count, 1, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const CaptureFrame& frame = set.frames[i * set.frames.size() / seams.size()];
      seams[i] = measure_frame(frame, camera, points);
      progress.advance();
    }
  });
  std::erase_if(seams, [](const FrameSeam& seam) { return seam.front.size() < kFewestOfFrame; });
  LensGain gain{.frames = count};
  for (const FrameSeam& seam : seams) gain.points += static_cast<int>(seam.front.size());
  if (gain.points < kFewestPoints) {
    gain.warnings.emplace_back(
        "the lenses' overlap is too narrow, too dark or too bright to compare them; their exposure "
        "is not balanced");
    return gain;
  }
  if (balance) gain.back_gain = gain_of(seams);
  gain.step_before_levels = figures_of(seams, kEqualLenses).step_levels;
  const SeamFigures after = figures_of(seams, gain.back_gain);
  gain.step_after_levels = after.step_levels;
  gain.correlation = after.correlation;
  if (gain.correlation < kLeastCorrelation) {
    gain.warnings.push_back(fmt::format(
        "the two lenses do not show the same along their seam (correlation {:.2f}); check that the "
        "lens file is of this camera and has the right attitude of the back lens",
        gain.correlation));
  }
  return gain;
}

}  // namespace raywalk::calibrate
