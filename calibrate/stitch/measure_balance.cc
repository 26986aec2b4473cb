#include "calibrate/stitch/measure_balance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/video/tracking.hpp>
#include <utility>

#include "calibrate/stitch/seam_directions.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"

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

// Tracks points from picture to picture along a line (Lucas and Kanade, with a forward-backward
// check) and compares their light at the first and the last picture. Static points, as on a dolly,
// are dropped. Surfaces that are not Lambertian are left to the fit's robust weights.
class LightTracks {
 public:
  // `first` and those passed to follow() are the pictures of consecutive stations.
  LightTracks(const DualFisheyeCamera& camera, LightPictures first)
      : first_(first),
        last_(std::move(first)),
        lenses_{Lens{camera.layout.front, false, {}, {}}, Lens{camera.layout.back, true, {}, {}}} {
    for (Lens& lens : lenses_) place_points(&lens);
  }

  void follow(const LightPictures& next) {
    for (Lens& lens : lenses_) follow(picture_of(last_, lens), picture_of(next, lens), &lens);
    last_ = next;
  }

  // Ratios between the first and the last picture; `frames` is stored in LightRatio::frames.
  std::vector<LightRatio> ratios(int frames) const {
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

 private:
  struct Lens {
    FisheyeLens model{};
    bool back = false;
    std::vector<cv::Point2f> first{};  // of tracks still followed, in the small picture
    std::vector<cv::Point2f> last{};
  };

  const LightPicture& picture_of(const LightPictures& pictures, const Lens& lens) const {
    return lens.back ? pictures.back : pictures.front;
  }

  // On a regular lattice within the lens's own image circle. Corners would be tracked better, but
  // the mean of a patch around a corner changes with its distance, which is correlated with the
  // angle: in a simulated camera this overestimated the light loss by a tenth.
  void place_points(Lens* lens) const {
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

  void follow(const LightPicture& from, const LightPicture& to, Lens* lens) const {
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

  LightPictures first_;
  LightPictures last_;
  std::array<Lens, 2> lenses_;
};

constexpr int kGroups = 10;
constexpr int kGroupFrames = 6;  // neighbours; longer tracks are rare
constexpr double kLeastCorrelation = 0.5;
constexpr int kFewestRatios = 200;

// Indices of consecutive frames of one line.
using Group = std::vector<int>;

// Groups that start at even intervals in the whole set; a line shorter than a group is one group.
std::vector<Group> groups_of(const CaptureSet& set) {
  std::vector<Group> all;
  for (const CaptureLine& line : set.lines) {
    for (std::size_t begin = 0; begin < line.frames.size(); begin += kGroupFrames) {
      const std::size_t end = std::min(begin + kGroupFrames, line.frames.size());
      all.emplace_back(line.frames.begin() + static_cast<std::ptrdiff_t>(begin),
                       line.frames.begin() + static_cast<std::ptrdiff_t>(end));
    }
  }
  const std::size_t count = std::min<std::size_t>(all.size(), kGroups);
  std::vector<Group> spread;
  for (std::size_t i = 0; i < count; ++i) spread.push_back(all[i * all.size() / count]);
  return spread;
}

struct GroupLight {
  std::vector<LightPictures> ends{};  // the first frame's and the last's
  std::vector<LightRatio> overlap{};
  std::vector<LightRatio> motion{};
};

GroupLight measure_group(const CaptureSet& set, const DualFisheyeCamera& camera, const Group& group,
                         const std::vector<SeamDirection>& directions, int number) {
  const int shrink = light_shrink(camera);
  const auto load = [&](int frame) {
    throw_if_interrupted();
    const CaptureFrame& station = set.frames[static_cast<std::size_t>(frame)];
    return light_pictures(read_frame_pictures(station, camera), shrink);
  };
  GroupLight light;
  light.ends.push_back(load(group.front()));
  LightTracks tracks(camera, light.ends.front());
  for (std::size_t i = 1; i < group.size(); ++i) {
    LightPictures next = load(group[i]);
    tracks.follow(next);
    if (i + 1 == group.size()) light.ends.push_back(std::move(next));
  }
  light.motion = tracks.ratios(number);
  for (const LightPictures& end : light.ends) {
    const auto ratios = seam_ratios(end, directions);
    light.overlap.insert(light.overlap.end(), ratios.begin(), ratios.end());
  }
  return light;
}

double median_or_zero(std::vector<double> values) {
  return values.empty() ? 0.0 : median(std::move(values));
}

// Median over the frames of |step| and of the correlation.
SeamFigures median_figures(const std::vector<GroupLight>& groups,
                           const std::vector<SeamDirection>& directions,
                           const LensBalance& balance) {
  std::vector<double> steps, correlations;
  SeamFigures result;
  for (const GroupLight& group : groups) {
    for (const LightPictures& end : group.ends) {
      const SeamFigures figures = seam_figures(end, directions, balance);
      result.directions += figures.directions;
      if (figures.directions < kFewestRatios) continue;
      steps.push_back(std::abs(figures.step_levels));
      correlations.push_back(figures.correlation);
    }
  }
  result.step_levels = median_or_zero(std::move(steps));
  result.correlation = median_or_zero(std::move(correlations));
  return result;
}

void warn(const SeamFigures& figures, BalanceReport* report) {
  if (report->overlap_ratios < kFewestRatios) {
    report->warnings.push_back(
        "the lenses' overlap is too narrow, too dark or too bright to compare them; their exposure "
        "is not balanced");
  } else if (figures.correlation < kLeastCorrelation) {
    report->warnings.push_back(fmt::format(
        "the two lenses do not show the same along their seam (correlation {:.2f}); check that the "
        "lens file is of this camera and has the right attitude of the back lens",
        figures.correlation));
  }
}

}  // namespace

BalanceReport measure_balance(const CaptureSet& set, const DualFisheyeCamera& camera,
                              bool balance) {
  const std::vector<Group> groups = groups_of(set);
  const std::vector<SeamDirection> directions = seam_directions(camera);
  std::vector<GroupLight> light(groups.size());
  BalanceReport report;
  for (const Group& group : groups) report.frames += static_cast<int>(group.size());
  Progress progress("comparing the lenses", static_cast<int>(groups.size()), "groups");
  parallel_for(0, static_cast<int>(groups.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto at = static_cast<std::size_t>(i);
      light[at] = measure_group(set, camera, groups[at], directions, i);
      progress.advance();
    }
  });
  std::vector<LightRatio> ratios;
  for (const GroupLight& group : light) {
    ratios.insert(ratios.end(), group.overlap.begin(), group.overlap.end());
    ratios.insert(ratios.end(), group.motion.begin(), group.motion.end());
    report.overlap_ratios += static_cast<int>(group.overlap.size());
    report.motion_ratios += static_cast<int>(group.motion.size());
  }
  // Without an overlap, gain and falloff cannot be separated from the room's own light.
  if (balance && report.overlap_ratios >= kFewestRatios) report.fit = fit_balance(ratios);
  report.step_before_levels = median_figures(light, directions, {}).step_levels;
  const SeamFigures after = median_figures(light, directions, report.fit.balance);
  report.step_after_levels = after.step_levels;
  report.correlation = after.correlation;
  warn(after, &report);
  return report;
}

}  // namespace raywalk::calibrate
