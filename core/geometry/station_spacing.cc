#include "core/geometry/station_spacing.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/geometry/position_tolerance.h"

namespace raywalk {
namespace {

struct Neighbour {
  double distance_m = std::numeric_limits<double>::infinity();
  Eigen::Vector2d towards{0, 0};
};

double spacing_at(const StationPose& station, std::span<const StationPose> stations) {
  const double same_m = rounding_m(2.0 * station.position_m.cwiseAbs().maxCoeff());
  Neighbour first, second;
  for (const StationPose& other : stations) {
    const Eigen::Vector3d away = other.position_m - station.position_m;
    const Eigen::Vector2d towards(away.x(), away.z());
    const double distance_m = towards.norm();
    if (distance_m <= same_m || distance_m >= second.distance_m) continue;
    second = {distance_m, towards};
    if (second.distance_m < first.distance_m) std::swap(first, second);
  }
  if (!std::isfinite(second.distance_m)) return first.distance_m;
  const bool in_one_direction =
      first.towards.dot(second.towards) > 0.5 * first.distance_m * second.distance_m;
  return in_one_direction ? first.distance_m : second.distance_m;
}

}  // namespace

double typical_spacing(std::span<const StationPose> stations) {
  constexpr std::size_t kMeasured = 1000;
  const std::size_t count = std::min(kMeasured, stations.size());
  std::vector<double> distances_m;
  for (std::size_t i = 0; i < count; ++i) {
    const StationPose& station = stations[i * stations.size() / count];
    const double distance_m = spacing_at(station, stations);
    if (std::isfinite(distance_m)) distances_m.push_back(distance_m);
  }
  return distances_m.empty() ? 0.0 : median(std::move(distances_m));
}

}  // namespace raywalk
