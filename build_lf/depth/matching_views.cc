#include "build_lf/depth/matching_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace raywalk::build_lf {
namespace {

// Maximum penalty of a usable station; a baseline off by a factor of e costs 1, an offset along the
// direction as long as the reach costs 1/4.
constexpr double kMaxPenalty = 0.8;
constexpr double kAlongPenalty = 0.25;

struct Candidate {
  int station = 0;
  double baseline_m = 0.0;
  double penalty = 0.0;  // penalty for the offset along the direction and for a slant
};

// The unit vector perpendicular to `direction` that separates the two sides: the component of the
// rail or, if the direction is nearly along the rail, the horizontal perpendicular to it.
Eigen::Vector3d side_axis(const Eigen::Vector3d& rail, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d across = rail - rail.dot(direction) * direction;
  constexpr double kNearlyAlong = 0.35;
  if (across.norm() >= kNearlyAlong) return across.normalized();
  return direction.cross(Eigen::Vector3d::UnitY()).normalized();
}

std::array<std::vector<Candidate>, 2> candidates_by_side(
    const MatchingGeometry& geometry, const Eigen::Vector3d& direction,
    std::span<const Eigen::Vector3d> stations_m) {
  const Eigen::Vector3d axis = side_axis(geometry.rail, direction);
  std::array<std::vector<Candidate>, 2> candidates;
  for (int i = 0; i < static_cast<int>(stations_m.size()); ++i) {
    const Eigen::Vector3d offset = stations_m[static_cast<size_t>(i)] - geometry.reference_m;
    const double ahead = offset.dot(direction);
    const Eigen::Vector3d across = offset - ahead * direction;
    const double baseline = across.norm();
    const double to_side = across.dot(axis);
    constexpr double kSlanted = 0.7;
    if (ahead > geometry.reach_m || std::fabs(to_side) < kSlanted * baseline ||
        baseline < 1e-3 * geometry.reach_m) {
      continue;
    }
    const double slant = 1.0 - std::fabs(to_side) / baseline;
    candidates[to_side > 0.0 ? 0 : 1].push_back(
        {i, baseline, kAlongPenalty * std::fabs(ahead) / geometry.reach_m + slant});
  }
  return candidates;
}

}  // namespace

MatchingViews choose_matching_views(const MatchingGeometry& geometry,
                                    const Eigen::Vector3d& direction,
                                    std::span<const Eigen::Vector3d> stations_m) {
  MatchingViews views;
  const auto candidates = candidates_by_side(geometry, direction, stations_m);
  for (size_t side = 0; side < candidates.size(); ++side) {
    std::vector<int>& chosen = views.side[side];
    for (int i = 1; i <= kViewsPerSide; ++i) {
      const double target_m = geometry.reach_m * i / kViewsPerSide;
      double least = kMaxPenalty;
      int best = -1;
      for (const Candidate& candidate : candidates[side]) {
        const double penalty =
            std::fabs(std::log(candidate.baseline_m / target_m)) + candidate.penalty;
        if (penalty < least &&
            std::find(chosen.begin(), chosen.end(), candidate.station) == chosen.end()) {
          least = penalty;
          best = candidate.station;
        }
      }
      if (best >= 0) chosen.push_back(best);
    }
  }
  return views;
}

}  // namespace raywalk::build_lf
