#include "core/geometry/line_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/median.h"

namespace raywalk {
namespace {

const double kMaxObliqueness = std::tan(radians_from_degrees(kMaxObliquenessDeg));

// Refits converge in two or three rounds; the bound stops a station that alternates in and out.
constexpr int kMaxRefits = 20;

// Coordinates of plan vectors, (x, z).
int along_index(LineAxis axis) { return axis == LineAxis::kX ? 0 : 1; }

// Greedy search: an unclaimed station proposes a line, the line claims its stations.
class LineSearch {
 public:
  LineSearch(std::span<const StationPose> stations, double tolerance_m)
      : stations_(stations), tolerance_m_(tolerance_m), claimed_(stations.size(), false) {
    for (const StationPose& station : stations) points_.push_back(plan_of(station));
  }

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
    seeds.reserve(points_.size());
    for (int seed = 0; seed < static_cast<int>(points_.size()); ++seed) {
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
    double distance = std::numeric_limits<double>::infinity();
    for (int other : stations_in_wedge(seed, axis)) {
      distance = std::min(distance, (point(other) - point(seed)).norm());
    }
    return distance;
  }

  bool on_claimed_line(int station, LineAxis axis) const {
    return std::any_of(groups_.begin(), groups_.end(), [&](const StationGroup& group) {
      return group.line.axis == axis && group.line.distance_to(point(station)) <= tolerance_m_;
    });
  }

  // Unclaimed stations that a line through the seed, no more oblique than allowed, could hold.
  std::vector<int> stations_in_wedge(int seed, LineAxis axis) const {
    const int u = along_index(axis);
    std::vector<int> inside;
    for (int other = 0; other < static_cast<int>(points_.size()); ++other) {
      const Eigen::Vector2d apart = (point(other) - point(seed)).cwiseAbs();
      if (claimed_[static_cast<size_t>(other)] || apart[u] <= tolerance_m_) continue;
      if (apart[1 - u] <= 2.0 * tolerance_m_ + kMaxObliqueness * apart[u]) inside.push_back(other);
    }
    return inside;
  }

  // Of the lines through the seed and one other station, the one with the most stations nearby.
  PlanLine best_line_through(int seed, LineAxis axis, const std::vector<int>& candidates) const {
    PlanLine best;
    std::ptrdiff_t best_count = -1;
    for (int other : candidates) {
      const std::array<Eigen::Vector2d, 2> ends{point(seed), point(other)};
      const PlanLine line = fit_line(ends, axis);
      const auto count = std::count_if(candidates.begin(), candidates.end(), [&](int station) {
        return line.distance_to(point(station)) <= 2.0 * tolerance_m_;
      });
      if (count > best_count) {
        best = line;
        best_count = count;
      }
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
    std::vector<int> members;
    for (int station = 0; station < static_cast<int>(points_.size()); ++station) {
      if (claimed_[static_cast<size_t>(station)] || line.distance_to(point(station)) > limit_m)
        continue;
      members.push_back(station);
    }
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
    for (const StationGroup& group : groups_) {
      for (int other : group.stations) {
        if ((point(other) - point(seed)).norm() > tolerance_m_) continue;
        throw Error(
            fmt::format("{} and {} have the same position (x = {:.6g}, z = {:.6g}; closer than "
                        "{:.3g} mm), and no other line crosses there; remove one of them",
                        name_of(stations_[static_cast<size_t>(other)]), name_of(station),
                        point(seed).x(), point(seed).y(), tolerance_m_ * 1e3));
      }
    }
    throw Error(
        fmt::format("{} at x = {:.6g}, z = {:.6g} is on no line: no other station lies within "
                    "{:.3g} mm of a line along x or z through it; a line needs at least two",
                    name_of(station), point(seed).x(), point(seed).y(), tolerance_m_ * 1e3));
  }

  const Eigen::Vector2d& point(int station) const { return points_[static_cast<size_t>(station)]; }

  std::span<const StationPose> stations_;
  double tolerance_m_;
  std::vector<Eigen::Vector2d> points_;
  std::vector<bool> claimed_;
  std::vector<StationGroup> groups_;
};

}  // namespace

double PlanLine::distance_to(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d from = point - origin;
  return std::abs(direction.x() * from.y() - direction.y() * from.x());
}

double PlanLine::obliqueness() const {
  const int u = along_index(axis);
  return std::abs(direction[1 - u]) / direction[u];
}

Eigen::Vector2d plan_of(const StationPose& station) {
  return {station.position_m.x(), station.position_m.z()};
}

std::string name_of(const StationPose& station) {
  return station.where.empty() ? station.file : fmt::format("{} ({})", station.file, station.where);
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
  std::vector<double> nearest;
  for (const StationPose& station : stations) {
    double squared = std::numeric_limits<double>::infinity();
    for (const StationPose& other : stations) {
      const double apart = (plan_of(other) - plan_of(station)).squaredNorm();
      if (apart > 0.0) squared = std::min(squared, apart);
    }
    if (std::isfinite(squared)) nearest.push_back(std::sqrt(squared));
  }
  if (nearest.empty()) return 0.0;
  return median(std::move(nearest));
}

std::vector<StationGroup> find_lines(std::span<const StationPose> stations, double tolerance_m) {
  return LineSearch(stations, tolerance_m).run();
}

}  // namespace raywalk
