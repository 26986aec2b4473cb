#include "core/geometry/plan_line.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace raywalk {
namespace {

// Greedy: a station that is on no line yet proposes one, which takes all stations near it.
class LineSearch {
 public:
  LineSearch(std::span<const Eigen::Vector2d> points, double tolerance_m)
      : points_(points), tolerance_m_(tolerance_m), is_placed_(points.size(), false) {
    free_.fill(std::vector<int>(points.size()));
    for (std::vector<int>& free : free_) std::iota(free.begin(), free.end(), 0);
  }

  std::vector<LineGroup> run() {
    std::vector<int> seeds = free_[0];
    std::ranges::sort(seeds, {}, [&](int i) { return std::pair(at(i).x(), at(i).y()); });
    for (const int seed : seeds) {
      while (!is_placed(seed) && take_line_near(seed)) {
      }
    }
    return std::move(lines_);
  }

 private:
  const Eigen::Vector2d& at(int station) const {
    return points_[static_cast<std::size_t>(station)];
  }
  bool is_placed(int station) const { return is_placed_[static_cast<std::size_t>(station)]; }
  const std::vector<int>& free_for(LineAxis axis) const {
    return free_[static_cast<std::size_t>(along_index(axis))];
  }

  // Takes the likelier of the lines along x and z near a station; false if there is none. The
  // station itself may remain, if it is beside that line.
  bool take_line_near(int seed) {
    LineGroup best;
    for (const LineAxis axis : {LineAxis::kX, LineAxis::kZ}) {
      LineGroup found = line_near(seed, axis);
      if (found.stations.empty()) continue;
      if (best.stations.empty() || likelihood(found) > likelihood(best)) best = std::move(found);
    }
    if (best.stations.empty()) return false;
    const PlanLine& line = best.line;
    const double first_m = line.along(at(best.stations.front()));
    const double last_m = line.along(at(best.stations.back()));
    for (const int station : best.stations) is_placed_[static_cast<std::size_t>(station)] = true;
    // Stations just beside the line are rather too far off it than on another of its axis.
    std::erase_if(free_[static_cast<std::size_t>(along_index(line.axis))], [&](int station) {
      const double along_m = line.along(at(station)), off_m = line.distance_to(at(station));
      return off_m <= tolerance_m_ ||
             (off_m <= 2.0 * tolerance_m_ && along_m >= first_m && along_m <= last_m);
    });
    lines_.push_back(std::move(best));
    return true;
  }

  // Compares lines: whether one is long enough to have a direction; then how densely its stations
  // follow each other, as stations of a line are closer together than parallel lines.
  std::pair<bool, double> likelihood(const LineGroup& group) const {
    constexpr double kShortestInTolerances = 4.0;
    const double length_m =
        group.line.along(at(group.stations.back())) - group.line.along(at(group.stations.front()));
    return {length_m > kShortestInTolerances * tolerance_m_,
            static_cast<double>(group.stations.size() - 1) / length_m};
  }

  // The line found from a station, or from one in the middle of that line if it holds more: a
  // station beside a line finds a part of it, at a small angle.
  LineGroup line_near(int seed, LineAxis axis) const {
    LineGroup best = line_found_from(seed, axis);
    while (!best.stations.empty()) {
      LineGroup other = line_found_from(best.stations[best.stations.size() / 2], axis);
      if (other.stations.size() <= best.stations.size()) break;
      best = std::move(other);
    }
    return best;
  }

  // At first through the station and another, then fitted to those near, and to ever farther ones:
  // few do not tell where a long line ends.
  LineGroup line_found_from(int seed, LineAxis axis) const {
    const std::vector<int> candidates = candidates_for(seed, axis);
    if (candidates.empty()) return {};
    std::size_t count = std::min<std::size_t>(128, candidates.size());
    LineGroup group{line_with_most(seed, std::span(candidates).first(count), axis), {}};
    for (; count < candidates.size(); count *= 2) {
      if (!fit_to(std::span(candidates).first(count), &group)) return {};
    }
    // A line of two stations is through both already.
    if (candidates.size() > 1 && !fit_to(candidates, &group)) return {};
    if (!fit_to(free_for(axis), &group)) return {};
    const auto along = [&](int station) { return group.line.along(at(station)); };
    std::ranges::stable_sort(group.stations, {}, along);
    if (along(group.stations.front()) == along(group.stations.back())) return {};
    return group;
  }

  // The stations that a line through the seed may hold, nearest first.
  std::vector<int> candidates_for(int seed, LineAxis axis) const {
    const int u = along_index(axis);
    std::vector<std::pair<double, int>> found;
    for (const int station : free_for(axis)) {
      const Eigen::Vector2d apart = (at(station) - at(seed)).cwiseAbs();
      if (apart[u] > tolerance_m_ &&
          apart[1 - u] <= 2.0 * tolerance_m_ + kMaxObliqueness * apart[u]) {
        found.emplace_back(apart[u], station);
      }
    }
    std::ranges::sort(found);
    std::vector<int> stations;
    stations.reserve(found.size());
    for (const auto& [apart_m, station] : found) stations.push_back(station);
    return stations;
  }

  // Of the lines through the seed and one of the others that with the most of these near it. They
  // count by Tukey's biweight, so that a line between two others does not seem to hold both.
  PlanLine line_with_most(int seed, std::span<const int> others, LineAxis axis) const {
    PlanLine best;
    double most = -1.0;
    for (const int other : others) {
      const std::array<Eigen::Vector2d, 2> ends{at(seed), at(other)};
      const PlanLine line = fit_line(ends, axis);
      double sum = 0.0;
      for (const int each : others) {
        const double off = line.distance_to(at(each)) / (2.0 * tolerance_m_);
        if (off < 1.0) sum += (1.0 - off * off) * (1.0 - off * off);
      }
      if (sum <= most) continue;
      best = line;
      most = sum;
    }
    return best;
  }

  // Fits a line to those of these stations that are within the tolerance of it, until they no
  // longer change; false if they are less than two. The two that it starts from may both be off.
  bool fit_to(std::span<const int> stations, LineGroup* group) const {
    constexpr int kMaxRounds = 20;  // stops a station that alternates in and out
    double limit_m = 2.0 * tolerance_m_;
    for (int round = 0; round < kMaxRounds; ++round) {
      std::vector<int> members;
      std::vector<Eigen::Vector2d> places;
      for (const int station : stations) {
        if (group->line.distance_to(at(station)) > limit_m) continue;
        members.push_back(station);
        places.push_back(at(station));
      }
      if (members.size() < 2) return false;
      if (round > 0 && members == group->stations) return true;
      group->line = fit_line(places, group->line.axis, kMaxObliqueness);
      group->stations = std::move(members);
      limit_m = tolerance_m_;
    }
    return true;
  }

  std::span<const Eigen::Vector2d> points_;
  double tolerance_m_;
  std::vector<bool> is_placed_;           // on a line of either axis
  std::array<std::vector<int>, 2> free_;  // that may be of new lines along x and z
  std::vector<LineGroup> lines_;
};

}  // namespace

// The direction (cos t, sin t) that leaves the least squares perpendicular to it is the major axis
// of the scatter matrix [sxx sxz; sxz szz]: tan 2t = 2 sxz / (sxx - szz). The angle is taken from
// the line's own axis, where the sine is exact for exactly straight lines. The sum of squares is a
// cosine of twice the angle, so the best allowed angle is the limit on the side of the best of all.
PlanLine fit_line(std::span<const Eigen::Vector2d> points, LineAxis axis, double most_oblique) {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) centroid += point - points.front();
  centroid = points.front() + centroid / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : points) {
    scatter += (point - centroid) * (point - centroid).transpose();
  }
  const int u = along_index(axis), v = 1 - u;
  const double angle = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(u, u) - scatter(v, v));
  PlanLine line{.axis = axis, .origin = centroid};
  line.direction[u] = std::cos(angle);
  line.direction[v] = std::sin(angle);
  if (std::abs(line.direction[v]) > most_oblique * line.direction[u]) {
    line.direction[v] = std::copysign(most_oblique, line.direction[v]);
    line.direction[u] = 1.0;
    line.direction.normalize();
  }
  return line;
}

std::vector<LineGroup> find_lines(std::span<const Eigen::Vector2d> points, double tolerance_m) {
  return LineSearch(points, tolerance_m).run();
}

}  // namespace raywalk
