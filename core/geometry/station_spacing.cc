#include "core/geometry/station_spacing.h"

#include <cmath>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/geometry/position_tolerance.h"
#include "core/geometry/station_plan.h"

namespace raywalk {
namespace {

// Median over the stations of `distance(tree, station)`, where it is finite.
template <typename Distance>
double median_distance(std::span<const StationPose> stations, const Distance& distance) {
  constexpr int kGrain = 256;
  const StationTree tree = tree_of(stations);
  std::vector<double> distances_m(stations.size());
  Progress progress("measuring the spacing of", tree.size(), "stations", Progress::Shown::kIfLong);
  parallel_for(0, tree.size(), kGrain, [&](int begin, int end) {
    for (int station = begin; station < end; ++station) {
      distances_m[static_cast<std::size_t>(station)] = distance(tree, station);
    }
    progress.advance(end - begin);
  });
  std::erase_if(distances_m, [](double distance_m) { return !std::isfinite(distance_m); });
  return distances_m.empty() ? 0.0 : median(std::move(distances_m));
}

// The distance to the nearest station farther away than `beyond_m`; infinite if there is none.
double nearest_beyond(const StationTree& tree, int station, double beyond_m) {
  const Eigen::Vector2d& point = tree.point(station);
  return tree.nearest(
      point, [&](const PlanBox& box) { return box.most_apart(point).norm() > beyond_m; },
      [&](int other) { return (tree.point(other) - point).norm() > beyond_m; });
}

// To the nearest station at another position.
double nearest_distance(const StationTree& tree, int station) {
  return nearest_beyond(tree, station, rounding_m(2.0 * tree.point(station).cwiseAbs().maxCoeff()));
}

// Whether one of the stations farther than `beyond_m` and up to `within_m` away lies in another
// direction than `towards`, by more than 60 degrees.
bool has_other_direction(const StationTree& tree, int station, const Eigen::Vector2d& towards,
                         double beyond_m, double within_m) {
  const Eigen::Vector2d& point = tree.point(station);
  const std::vector<int> found =
      tree.find([&](const PlanBox& box) { return box.least_apart(point).norm() <= within_m; },
                [&](int other) {
                  const Eigen::Vector2d away = tree.point(other) - point;
                  return away.norm() > beyond_m && away.norm() <= within_m &&
                         away.dot(towards) < 0.5 * away.norm() * towards.norm();
                });
  return !found.empty();
}

// To the nearest station, or to the second nearest if that lies in another direction: at the end of
// a line it is only the next but one.
double spacing_at(const StationTree& tree, int station) {
  const double nearest_m = nearest_distance(tree, station);
  if (!std::isfinite(nearest_m)) return nearest_m;
  const Eigen::Vector2d& point = tree.point(station);
  const std::vector<int> nearest =
      tree.find([&](const PlanBox& box) { return box.least_apart(point).norm() <= nearest_m; },
                [&](int other) {
                  const double distance_m = (tree.point(other) - point).norm();
                  return distance_m > 0.0 && distance_m <= nearest_m;
                });
  const double second_m = nearest_beyond(tree, station, nearest_m);
  if (nearest.size() > 1 || !std::isfinite(second_m)) return nearest_m;
  const Eigen::Vector2d towards = tree.point(nearest.front()) - point;
  return has_other_direction(tree, station, towards, nearest_m, second_m) ? second_m : nearest_m;
}

}  // namespace

double typical_spacing(std::span<const StationPose> stations) {
  return median_distance(stations, spacing_at);
}

double median_nearest_distance(std::span<const StationPose> stations) {
  return median_distance(stations, nearest_distance);
}

}  // namespace raywalk
