#include "core/geometry/line_near.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "core/geometry/line_candidates.h"

namespace raywalk {
namespace {

// Refits converge in two or three rounds; the bound stops a station that alternates in and out.
constexpr int kMaxRefits = 20;

}  // namespace

LineFinder::LineFinder(std::vector<Eigen::Vector2d> points, const LineLimits& limits,
                       double most_oblique_deg)
    : tolerance_m_(limits.off_line_m),
      twin_m_(limits.twin_m),
      most_oblique_(std::tan(radians_from_degrees(most_oblique_deg))),
      tree_(std::move(points)),
      taken_{std::vector<bool>(static_cast<std::size_t>(tree_.size()), false),
             std::vector<bool>(static_cast<std::size_t>(tree_.size()), false)} {}

void LineFinder::take(int station) {
  take(station, LineAxis::kX);
  take(station, LineAxis::kZ);
}

std::vector<Eigen::Vector2d> LineFinder::points_of(const std::vector<int>& stations) const {
  std::vector<Eigen::Vector2d> points;
  points.reserve(stations.size());
  for (const int station : stations) points.push_back(point(station));
  return points;
}

StationGroup LineFinder::line_near(int seed, LineAxis axis) const {
  StationGroup best = line_found_from(seed, axis);
  for (bool grew = true; grew;) {
    grew = false;
    for (const size_t quarter : {1, 2, 3}) {
      if (best.stations.empty()) return best;
      StationGroup other = line_found_from(best.stations[quarter * best.stations.size() / 4], axis);
      if (other.stations.size() <= best.stations.size()) continue;
      best = std::move(other);
      grew = true;
    }
  }
  return best;
}

StationGroup LineFinder::line_found_from(int seed, LineAxis axis) const {
  const std::vector<int> candidates = stations_in_wedge(seed, axis);
  if (candidates.empty()) return {};
  return refit(best_line_through(seed, axis, candidates));
}

double LineFinder::nearest_along(int seed, LineAxis axis) const {
  return tree_.nearest(
      point(seed),
      [&](const PlanBox& box) {
        return in_wedge(box.most_apart(point(seed)), box.least_apart(point(seed)), axis);
      },
      [&](int other) { return is_candidate(seed, other, axis); });
}

// Whether a line through a seed, no more oblique than allowed, could pass a point this far along
// the axis and this far across.
bool LineFinder::in_wedge(const Eigen::Vector2d& along, const Eigen::Vector2d& across,
                          LineAxis axis) const {
  const int u = along_index(axis);
  return along[u] > tolerance_m_ && across[1 - u] <= 2.0 * tolerance_m_ + most_oblique_ * along[u];
}

bool LineFinder::is_candidate(int seed, int other, LineAxis axis) const {
  const Eigen::Vector2d apart = (point(other) - point(seed)).cwiseAbs();
  return is_free(other, axis) && in_wedge(apart, apart, axis);
}

// Free stations that a line through the seed, no more oblique than allowed, could hold: all, or
// the nearest along the axis where these are enough to tell the line. The refit takes in those
// farther along it; comparing all of a large grid for every line would take its square.
std::vector<int> LineFinder::stations_in_wedge(int seed, LineAxis axis) const {
  constexpr std::size_t kEnough = 4096;
  constexpr double kFirstReachInTolerances = 1000.0;
  const double everywhere_m = tree_.extent();
  double reach_m = kFirstReachInTolerances * tolerance_m_;
  std::vector<int> found = stations_in_wedge(seed, axis, reach_m);
  while (found.size() < kEnough && reach_m < everywhere_m) {
    reach_m = reach_m > 0.0 ? 2.0 * reach_m : everywhere_m;
    found = stations_in_wedge(seed, axis, reach_m);
  }
  return found;
}

std::vector<int> LineFinder::stations_in_wedge(int seed, LineAxis axis, double reach_m) const {
  const int u = along_index(axis);
  return tree_.find(
      [&](const PlanBox& box) {
        const Eigen::Vector2d least = box.least_apart(point(seed));
        return least[u] <= reach_m && in_wedge(box.most_apart(point(seed)), least, axis);
      },
      [&](int other) {
        return std::abs(point(other)[u] - point(seed)[u]) <= reach_m &&
               is_candidate(seed, other, axis);
      });
}

// Of the lines through the seed and one other station, the one with the most stations nearby; of
// equal ones the first. Most are told by the bound alone: the first one counted usually has as
// many as its bound.
PlanLine LineFinder::best_line_through(int seed, LineAxis axis,
                                       const std::vector<int>& candidates) const {
  const std::vector<Eigen::Vector2d> points = points_of(candidates);
  const std::vector<int> bounds = most_near_lines(point(seed), points, axis, 2.0 * tolerance_m_);
  std::vector<int> order(candidates.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return bounds[static_cast<size_t>(a)] > bounds[static_cast<size_t>(b)];
  });
  PlanLine best;
  int best_place = static_cast<int>(candidates.size());
  std::ptrdiff_t best_count = -1;
  for (int place : order) {
    const std::ptrdiff_t bound = bounds[static_cast<size_t>(place)];
    if (bound < best_count) break;
    if (bound == best_count && place > best_place) continue;
    const std::array<Eigen::Vector2d, 2> ends{point(seed), points[static_cast<size_t>(place)]};
    const PlanLine line = fit_line(ends, axis);
    const auto count = std::count_if(points.begin(), points.end(), [&](const auto& at) {
      return line.distance_to(at) <= 2.0 * tolerance_m_;
    });
    if (count < best_count || (count == best_count && place > best_place)) continue;
    best = line;
    best_count = count;
    best_place = place;
  }
  return best;
}

// The largest group that a line near this one leaves within the tolerance, in order along it.
StationGroup LineFinder::refit(const PlanLine& line) const {
  StationGroup converged = refit_until_settled(line);
  if (converged.stations.size() < 2) return {};
  StationGroup trimmed = refit_to_most(converged.line);
  StationGroup& best = trimmed.stations.size() > converged.stations.size() ? trimmed : converged;
  if (follows_oblique_line(best)) return {};
  return std::move(best);
}

// Least squares over the stations within tolerance, until the set no longer changes. The first
// round admits twice the tolerance, as the two stations it starts from may both be off.
StationGroup LineFinder::refit_until_settled(PlanLine line) const {
  std::vector<int> members = stations_within(line, 2.0 * tolerance_m_);
  for (int round = 0; round < kMaxRefits && members.size() >= 2; ++round) {
    line = fitted(members, line.axis);
    std::vector<int> next = stations_within(line, tolerance_m_);
    if (next == members) break;
    members = std::move(next);
  }
  return {line, std::move(members)};
}

// Least squares over all stations within twice the tolerance, of which the farthest are left out
// until all are within the tolerance. Keeps stations near the tolerance that the refit above
// loses when it starts beside them.
StationGroup LineFinder::refit_to_most(PlanLine line) const {
  constexpr double kShareKept = 0.95;
  std::vector<int> members = stations_within(line, 2.0 * tolerance_m_);
  while (members.size() >= 2) {
    line = fitted(members, line.axis);
    double farthest_m = 0.0;
    for (const int member : members) {
      farthest_m = std::max(farthest_m, line.distance_to(point(member)));
    }
    if (farthest_m <= tolerance_m_) break;
    const double limit_m = std::max(tolerance_m_, kShareKept * farthest_m);
    std::erase_if(members, [&](int member) { return line.distance_to(point(member)) > limit_m; });
  }
  return {line, std::move(members)};
}

// Whether the stations are a part of a longer line that is more oblique than allowed.
bool LineFinder::follows_oblique_line(const StationGroup& group) const {
  PlanLine free = fit_line(points_of(group.stations), group.line.axis);
  if (free.obliqueness() <= most_oblique_) return false;
  std::vector<int> members = group.stations;
  for (int round = 0; round < kMaxRefits; ++round) {
    std::vector<int> next = stations_within(free, tolerance_m_);
    if (next.size() <= members.size()) break;
    members = std::move(next);
    free = fit_line(points_of(members), group.line.axis);
  }
  return members.size() > group.stations.size();
}

PlanLine LineFinder::fitted(const std::vector<int>& members, LineAxis axis) const {
  return fit_line_within(points_of(members), axis, most_oblique_);
}

// Free stations within `limit_m` of the line, in order along it; of several within twin_m_
// only the first, as the others may belong to the line that crosses here.
std::vector<int> LineFinder::stations_within(const PlanLine& line, double limit_m) const {
  std::vector<int> near =
      stations_near(tree_, line, limit_m, [&](int station) { return is_free(station, line.axis); });
  std::stable_sort(near.begin(), near.end(),
                   [&](int a, int b) { return line.along(point(a)) < line.along(point(b)); });
  std::vector<int> members;
  members.reserve(near.size());
  for (const int station : near) {
    if (!has_twin_before(members, line, station)) members.push_back(station);
  }
  return members;
}

// Whether one of `members`, which ascend along the line, is within twin_m_ of a station beyond
// them.
bool LineFinder::has_twin_before(const std::vector<int>& members, const PlanLine& line,
                                 int station) const {
  const double along_m = line.along(point(station));
  for (auto member = members.rbegin(); member != members.rend(); ++member) {
    if (along_m - line.along(point(*member)) > twin_m_) return false;
    if (distance(*member, station) <= twin_m_) return true;
  }
  return false;
}

StationGroup line_near(std::span<const StationPose> stations, const LineLimits& limits, int station,
                       LineAxis axis, double most_oblique_deg) {
  return LineFinder(plans_of(stations), limits, most_oblique_deg).line_near(station, axis);
}

}  // namespace raywalk
