#include "calibrate/poses/seen_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "calibrate/base/disjoint_sets.h"

namespace raywalk::calibrate {
namespace {

std::vector<std::set<std::size_t>> frames_by_point(const SeenPoints& points) {
  std::vector<std::set<std::size_t>> frames(points.points_m.size());
  for (const PointObservation& one : points.observations) frames[one.point].insert(one.frame);
  return frames;
}

}  // namespace

SeenPoints chosen_points(const SeenPoints& points, const std::vector<bool>& keep) {
  SeenPoints kept;
  std::vector<std::size_t> index(points.points_m.size());
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    index[i] = kept.points_m.size();
    kept.points_m.push_back(points.points_m[i]);
  }
  for (PointObservation one : points.observations) {
    if (!keep[one.point]) continue;
    one.point = index[one.point];
    kept.observations.push_back(one);
  }
  return kept;
}

Eigen::Matrix<double, 2, 3> axes_across(const Eigen::Vector3d& bearing) {
  Eigen::Matrix<double, 2, 3> axes;
  axes.row(0) = bearing.unitOrthogonal();
  axes.row(1) = bearing.cross(axes.row(0).transpose());
  return axes;
}

SeenPoints widely_seen(const SeenPoints& points, std::size_t least_frames) {
  std::vector<bool> keep;
  for (const auto& frames : frames_by_point(points)) keep.push_back(frames.size() >= least_frames);
  return chosen_points(points, keep);
}

SeenPoints strongest(const SeenPoints& points, int per_frame) {
  std::vector<std::vector<std::size_t>> frames(points.points_m.size());
  std::size_t frame_count = 0;
  for (const PointObservation& one : points.observations) {
    frames[one.point].push_back(one.frame);
    frame_count = std::max(frame_count, one.frame + 1);
  }
  std::vector<std::size_t> order(frames.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return frames[a].size() > frames[b].size();
  });
  std::vector<int> seen(frame_count, 0);
  std::vector<bool> keep(frames.size(), false);
  for (const std::size_t point : order) {
    keep[point] = std::any_of(frames[point].begin(), frames[point].end(),
                              [&](std::size_t frame) { return seen[frame] < per_frame; });
    if (!keep[point]) continue;
    for (const std::size_t frame : frames[point]) ++seen[frame];
  }
  return chosen_points(points, keep);
}

std::vector<bool> largest_linked_group(std::size_t frames, const SeenPoints& points,
                                       int least_points) {
  std::map<std::pair<std::size_t, std::size_t>, int> shared;
  for (const std::set<std::size_t>& seen_by : frames_by_point(points)) {
    for (auto a = seen_by.begin(); a != seen_by.end(); ++a) {
      for (auto b = std::next(a); b != seen_by.end(); ++b) ++shared[{*a, *b}];
    }
  }
  DisjointSets sets(static_cast<int>(frames));
  for (const auto& [pair, count] : shared) {
    if (count >= least_points) sets.join(pair.first, pair.second);
  }
  std::vector<int> sizes(frames, 0);
  for (std::size_t i = 0; i < frames; ++i) ++sizes[sets.root(i)];
  const auto largest = std::max_element(sizes.begin(), sizes.end());
  std::vector<bool> in_group(frames, false);
  if (largest == sizes.end() || *largest < 2) return in_group;
  for (std::size_t i = 0; i < frames; ++i) {
    in_group[i] = sets.root(i) == largest - sizes.begin();
  }
  return in_group;
}

}  // namespace raywalk::calibrate
