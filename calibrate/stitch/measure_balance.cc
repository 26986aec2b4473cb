#include "calibrate/stitch/measure_balance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/stitch/light_tracks.h"
#include "calibrate/stitch/seam_directions.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace raywalk::calibrate {
namespace {

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
