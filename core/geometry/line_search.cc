#include "core/geometry/line_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"

namespace raywalk {
namespace {

const double kMaxObliqueness = std::tan(radians_from_degrees(kMaxObliquenessDeg));

// Refits converge in two or three rounds; the bound stops a station that alternates in and out.
constexpr int kMaxRefits = 20;

// Coordinates of plan vectors, (x, z).
int along_index(LineAxis axis) { return axis == LineAxis::kX ? 0 : 1; }

// For each of `points` an upper bound, which is rarely too large, of how many of them lie within
// `limit_m` of the line through it and the seed. Point p lies within that of a line of direction t
// if t is within asin(limit / |p - seed|) of the direction of p, modulo pi; the intervals that hold
// a direction are counted with their sorted ends, in n log n.
std::vector<int> most_near_lines(const Eigen::Vector2d& seed,
                                 const std::vector<Eigen::Vector2d>& points, int along,
                                 double limit_m) {
  constexpr double kRounding = 1e-12, kAngleRounding = 1e-9;
  std::vector<double> angles, begins, ends;
  int everywhere = 0;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d from_seed = point - seed;
    const double u = from_seed[along], v = from_seed[1 - along];
    const double angle = std::atan2(std::copysign(1.0, u) * v, std::abs(u));
    angles.push_back(angle);
    const double reach_m = limit_m + kRounding * (point.norm() + seed.norm());
    if (reach_m >= from_seed.norm()) {
      ++everywhere;
      continue;
    }
    const double half = std::asin(reach_m / from_seed.norm()) + kAngleRounding;
    const auto add = [&](double turn) {
      begins.push_back(angle - half + turn);
      ends.push_back(angle + half + turn);
    };
    add(0.0);
    if (angle + half > kHalfPi) add(-kPi);
    if (angle - half < -kHalfPi) add(kPi);
  }
  std::sort(begins.begin(), begins.end());
  std::sort(ends.begin(), ends.end());
  std::vector<int> bounds;
  bounds.reserve(angles.size());
  for (const double angle : angles) {
    const auto begun = std::upper_bound(begins.begin(), begins.end(), angle) - begins.begin();
    const auto ended = std::lower_bound(ends.begin(), ends.end(), angle) - ends.begin();
    bounds.push_back(everywhere + static_cast<int>(begun - ended));
  }
  return bounds;
}

// Greedy search: an unclaimed station proposes a line, the line claims its stations.
class LineSearch {
 public:
  LineSearch(std::span<const StationPose> stations, double tolerance_m)
      : stations_(stations),
        tolerance_m_(tolerance_m),
        tree_(tree_of(stations)),
        claimed_(stations.size(), false) {}

  std::vector<StationGroup> run() {
    for (int seed : seeds_by_nearness()) {
      while (!claimed_[static_cast<size_t>(seed)]) claim_line_from(seed);
    }
    return std::move(groups_);
  }

 private:
  // Stations with near neighbours first, so that a stray station cannot take stations from a line.
  std::vector<int> seeds_by_nearness() const {
    std::vector<std::pair<double, int>> seeds;
    seeds.reserve(stations_.size());
    for (int seed = 0; seed < tree_.size(); ++seed) {
      seeds.emplace_back(
          std::min(nearest_in_wedge(seed, LineAxis::kX), nearest_in_wedge(seed, LineAxis::kZ)),
          seed);
    }
    std::sort(seeds.begin(), seeds.end());
    std::vector<int> order;
    order.reserve(seeds.size());
    for (const auto& [distance, seed] : seeds) order.push_back(seed);
    return order;
  }

  // Claims a line near the seed. The seed may not be on it (a stray station beside a line first
  // finds that line, then remains alone), but every call claims at least two stations or throws.
  void claim_line_from(int seed) {
    throw_if_interrupted();
    for (LineAxis axis : axes_by_nearness(seed)) {
      const std::vector<int> candidates = stations_in_wedge(seed, axis);
      if (candidates.empty()) continue;
      StationGroup group = refit(best_line_through(seed, axis, candidates));
      if (group.stations.size() < 2) continue;
      for (int station : group.stations) claimed_[static_cast<size_t>(station)] = true;
      groups_.push_back(std::move(group));
      return;
    }
    throw_no_line(seed);
  }

  // Candidate axes of the seed's line, the likelier first: towards the nearest station, as stations
  // of a line are closer together than parallel lines. An axis is excluded if the seed lies on a
  // claimed line of that axis, as this is the second capture at a crossing.
  std::vector<LineAxis> axes_by_nearness(int seed) const {
    std::vector<std::pair<double, LineAxis>> nearest;
    for (LineAxis axis : {LineAxis::kX, LineAxis::kZ}) {
      if (on_claimed_line(seed, axis)) continue;
      nearest.emplace_back(nearest_in_wedge(seed, axis), axis);
    }
    std::stable_sort(nearest.begin(), nearest.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<LineAxis> axes;
    axes.reserve(nearest.size());
    for (const auto& [distance, axis] : nearest) axes.push_back(axis);
    return axes;
  }

  double nearest_in_wedge(int seed, LineAxis axis) const {
    return tree_.nearest(
        point(seed),
        [&](const PlanBox& box) {
          return in_wedge(box.most_apart(point(seed)), box.least_apart(point(seed)), axis);
        },
        [&](int other) { return is_candidate(seed, other, axis); });
  }

  // Whether a line through a seed, no more oblique than allowed, could pass a point this far along
  // the axis and this far across.
  bool in_wedge(const Eigen::Vector2d& along, const Eigen::Vector2d& across, LineAxis axis) const {
    const int u = along_index(axis);
    return along[u] > tolerance_m_ &&
           across[1 - u] <= 2.0 * tolerance_m_ + kMaxObliqueness * along[u];
  }

  bool is_candidate(int seed, int other, LineAxis axis) const {
    const Eigen::Vector2d apart = (point(other) - point(seed)).cwiseAbs();
    return !claimed_[static_cast<size_t>(other)] && in_wedge(apart, apart, axis);
  }

  bool on_claimed_line(int station, LineAxis axis) const {
    return std::any_of(groups_.begin(), groups_.end(), [&](const StationGroup& group) {
      return group.line.axis == axis && group.line.distance_to(point(station)) <= tolerance_m_;
    });
  }

  // Unclaimed stations that a line through the seed, no more oblique than allowed, could hold.
  std::vector<int> stations_in_wedge(int seed, LineAxis axis) const {
    return tree_.find(
        [&](const PlanBox& box) {
          return in_wedge(box.most_apart(point(seed)), box.least_apart(point(seed)), axis);
        },
        [&](int other) { return is_candidate(seed, other, axis); });
  }

  // Of the lines through the seed and one other station, the one with the most stations nearby; of
  // equal ones the first. Most are told by the bound alone: the first one counted usually has as
  // many as its bound.
  PlanLine best_line_through(int seed, LineAxis axis, const std::vector<int>& candidates) const {
    std::vector<Eigen::Vector2d> points;
    points.reserve(candidates.size());
    for (int candidate : candidates) points.push_back(point(candidate));
    const std::vector<int> bounds =
        most_near_lines(point(seed), points, along_index(axis), 2.0 * tolerance_m_);
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

  // Least squares over the unclaimed stations within tolerance, until the set no longer changes.
  // The first round admits twice the tolerance, as the two stations it starts from may both be off.
  StationGroup refit(PlanLine line) const {
    std::vector<int> members = stations_within(line, 2.0 * tolerance_m_);
    for (int round = 0; round < kMaxRefits && members.size() >= 2; ++round) {
      std::vector<Eigen::Vector2d> points;
      points.reserve(members.size());
      for (int member : members) points.push_back(point(member));
      line = fit_line(points, line.axis);
      std::vector<int> next = stations_within(line, tolerance_m_);
      if (next == members) break;
      members = std::move(next);
    }
    if (line.obliqueness() > kMaxObliqueness) members.clear();
    return {line, std::move(members)};
  }

  // Unclaimed stations within `limit_m` of the line, in order along it; of several at one position
  // only the first, as the others belong to the line that crosses here.
  std::vector<int> stations_within(const PlanLine& line, double limit_m) const {
    std::vector<int> members = stations_near(
        tree_, line, limit_m, [&](int station) { return !claimed_[static_cast<size_t>(station)]; });
    std::stable_sort(members.begin(), members.end(),
                     [&](int a, int b) { return line.along(point(a)) < line.along(point(b)); });
    const auto repeated = [&](int a, int b) {
      return line.along(point(b)) - line.along(point(a)) <= tolerance_m_;
    };
    members.erase(std::unique(members.begin(), members.end(), repeated), members.end());
    return members;
  }

  [[noreturn]] void throw_no_line(int seed) const {
    const StationPose& station = stations_[static_cast<size_t>(seed)];
    require_own_position(stations_, tree_, seed, tolerance_m_);
    throw Error(
        fmt::format("{} at x = {:.6g}, z = {:.6g} is on no line: no other station lies within "
                    "{:.3g} mm of a line along x or z through it; a line needs at least two",
                    name_of(station), point(seed).x(), point(seed).y(), tolerance_m_ * 1e3));
  }

  const Eigen::Vector2d& point(int station) const { return tree_.point(station); }

  std::span<const StationPose> stations_;
  double tolerance_m_;
  StationTree tree_;
  std::vector<bool> claimed_;
  std::vector<StationGroup> groups_;
};

}  // namespace

double PlanLine::distance_to(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d from = point - origin;
  return std::abs(direction.x() * from.y() - direction.y() * from.x());
}

// The signed distance is linear, so within a box it differs from that of the centre by no more than
// at a corner.
bool PlanLine::may_come_near(const PlanBox& box, double limit_m) const {
  constexpr double kRounding = 1e-12;
  const Eigen::Vector2d half = 0.5 * (box.high - box.low);
  const Eigen::Vector2d centre = box.low + half;
  const double spread = std::abs(direction.x()) * half.y() + std::abs(direction.y()) * half.x();
  const double rounding = kRounding * ((centre - origin).norm() + half.norm());
  return distance_to(centre) <= limit_m + spread + rounding;
}

double PlanLine::obliqueness() const {
  const int u = along_index(axis);
  return std::abs(direction[1 - u]) / direction[u];
}

Eigen::Vector2d plan_of(const StationPose& station) {
  return {station.position_m.x(), station.position_m.z()};
}

StationTree tree_of(std::span<const StationPose> stations) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(stations.size());
  for (const StationPose& station : stations) points.push_back(plan_of(station));
  return StationTree(std::move(points));
}

std::string name_of(const StationPose& station) {
  return station.where.empty() ? station.file : fmt::format("{} ({})", station.file, station.where);
}

void require_own_position(std::span<const StationPose> stations, const StationTree& tree,
                          int station, double tolerance_m) {
  const Eigen::Vector2d& point = tree.point(station);
  const std::vector<int> here =
      tree.find([&](const PlanBox& box) { return box.least_apart(point).norm() <= tolerance_m; },
                [&](int other) { return (tree.point(other) - point).norm() <= tolerance_m; });
  if (here.size() < 2) return;
  const std::string closer =
      tolerance_m > 0.0 ? fmt::format("; closer than {:.3g} mm", tolerance_m * 1e3) : "";
  constexpr std::size_t kMostNamed = 3;
  std::string names = name_of(stations[static_cast<size_t>(here.front())]);
  for (std::size_t i = 1; i < std::min(here.size(), kMostNamed); ++i) {
    names += " and " + name_of(stations[static_cast<size_t>(here[i])]);
  }
  throw Error(
      fmt::format("{} have the same position (x = {:.6g}, z = {:.6g}{}), and no other line crosses "
                  "there; remove one of them or correct its position",
                  names, point.x(), point.y(), closer));
}

// The direction (cos t, sin t) that leaves the least squares perpendicular to it is the major axis
// of the scatter matrix [sxx sxz; sxz szz]: tan 2t = 2 sxz / (sxx - szz).
PlanLine fit_line(std::span<const Eigen::Vector2d> points, LineAxis axis) {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) centroid += point - points.front();
  centroid = points.front() + centroid / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : points) {
    scatter += (point - centroid) * (point - centroid).transpose();
  }
  const double angle = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
  // Along x the angle is near 0, where the sine is exact for exactly straight lines; along z it is
  // taken from the z axis for the same reason.
  Eigen::Vector2d direction{std::cos(angle), std::sin(angle)};
  if (axis == LineAxis::kZ) {
    const double from_z = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(1, 1) - scatter(0, 0));
    direction = {std::sin(from_z), std::cos(from_z)};
  }
  return {axis, centroid, direction};
}

double median_nearest_distance(std::span<const StationPose> stations) {
  const StationTree tree = tree_of(stations);
  std::vector<double> nearest;
  for (int station = 0; station < tree.size(); ++station) {
    const Eigen::Vector2d& point = tree.point(station);
    const double distance = tree.nearest(
        point, [&](const PlanBox& box) { return box.most_apart(point).squaredNorm() > 0.0; },
        [&](int other) { return (tree.point(other) - point).squaredNorm() > 0.0; });
    if (std::isfinite(distance)) nearest.push_back(distance);
  }
  if (nearest.empty()) return 0.0;
  return median(std::move(nearest));
}

std::vector<StationGroup> find_lines(std::span<const StationPose> stations, double tolerance_m) {
  return LineSearch(stations, tolerance_m).run();
}

}  // namespace raywalk
