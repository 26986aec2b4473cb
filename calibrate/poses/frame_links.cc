#include "calibrate/poses/frame_links.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "calibrate/base/disjoint_sets.h"
#include "calibrate/poses/pose_covariance.h"
#include "calibrate/poses/poses_figures.h"

namespace raywalk::calibrate {
namespace {

std::vector<std::set<int>> frames_by_point(const SeenPoints& points) {
  std::vector<std::set<int>> frames(points.points_m.size());
  for (const PointObservation& observation : points.observations) {
    frames[static_cast<std::size_t>(observation.point)].insert(observation.frame);
  }
  return frames;
}

void keep_posed_observations(RefinedPoses* refined) {
  SeenPoints kept;
  kept.points_m = refined->points.points_m;
  std::vector<double> errors_px;
  for (std::size_t i = 0; i < refined->points.observations.size(); ++i) {
    const PointObservation& observation = refined->points.observations[i];
    if (!refined->poses[static_cast<std::size_t>(observation.frame)]) continue;
    if (refined->errors_px[i] > refined->inlier_px) continue;
    kept.observations.push_back(observation);
    errors_px.push_back(refined->errors_px[i]);
  }
  refined->points = std::move(kept);
  refined->errors_px = std::move(errors_px);
}

}  // namespace

std::vector<int> linked_groups(int frames, const SeenPoints& points, int least_points) {
  std::map<std::pair<int, int>, int> shared;
  for (const std::set<int>& seen_by : frames_by_point(points)) {
    for (auto a = seen_by.begin(); a != seen_by.end(); ++a) {
      for (auto b = std::next(a); b != seen_by.end(); ++b) ++shared[{*a, *b}];
    }
  }
  DisjointSets sets(frames);
  std::vector<bool> linked(static_cast<std::size_t>(frames), false);
  for (const auto& [pair, count] : shared) {
    if (count < least_points) continue;
    sets.join(pair.first, pair.second);
    linked[static_cast<std::size_t>(pair.first)] = true;
    linked[static_cast<std::size_t>(pair.second)] = true;
  }
  std::vector<int> groups(static_cast<std::size_t>(frames), -1);
  for (int i = 0; i < frames; ++i) {
    if (linked[static_cast<std::size_t>(i)]) groups[static_cast<std::size_t>(i)] = sets.root(i);
  }
  return groups;
}

int largest_group(std::span<const int> groups) {
  std::map<int, int> sizes;
  for (const int group : groups) {
    if (group >= 0) ++sizes[group];
  }
  const auto largest = std::max_element(sizes.begin(), sizes.end(),
                                        [](auto& a, auto& b) { return a.second < b.second; });
  return largest == sizes.end() ? -1 : largest->first;
}

int common_points(const SeenPoints& points, const std::vector<bool>& a,
                  const std::vector<bool>& b) {
  int count = 0;
  for (const std::set<int>& seen_by : frames_by_point(points)) {
    const auto seen_in = [&](const std::vector<bool>& frames) {
      return std::any_of(seen_by.begin(), seen_by.end(),
                         [&](int frame) { return frames[static_cast<std::size_t>(frame)]; });
    };
    if (seen_in(a) && seen_in(b)) ++count;
  }
  return count;
}

SeenPoints inliers_of(const RefinedPoses& refined) {
  SeenPoints inliers;
  inliers.points_m = refined.points.points_m;
  for (std::size_t i = 0; i < refined.points.observations.size(); ++i) {
    if (refined.errors_px[i] <= refined.inlier_px) {
      inliers.observations.push_back(refined.points.observations[i]);
    }
  }
  return inliers;
}

void settle(RefinedPoses* refined, const PoseAnchor& anchor) {
  const SeenPoints inliers = widely_seen(inliers_of(*refined), 2);
  const std::vector<int> groups =
      linked_groups(static_cast<int>(refined->poses.size()), inliers, kLeastSharedPoints);
  const int main = largest_group(groups);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    std::optional<FramePose>& pose = refined->poses[i];
    if (pose && (main < 0 || groups[i] != main || pose->observations < kLeastObservations)) {
      pose.reset();
    }
  }
  keep_posed_observations(refined);
  if (!refined->points.observations.empty()) set_sigmas(refined, anchor);
}

}  // namespace raywalk::calibrate
