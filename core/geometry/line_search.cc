#include "core/geometry/line_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/geometry/line_candidates.h"
#include "core/geometry/position_tolerance.h"
#include "core/geometry/straight_fit.h"

namespace raywalk {
namespace {

// Refits converge in two or three rounds; the bound stops a station that alternates in and out.
constexpr int kMaxRefits = 20;
// A group no longer than this many tolerances may as well be the stations around a place of a line
// along the other axis.
constexpr double kShortestInTolerances = 4.0;
// As far beyond its last station a line may have lost some.
constexpr double kReachInSpacings = 4.0 + kOffPlaceShare;

double tangent_of(double degrees) { return std::tan(radians_from_degrees(degrees)); }

// Greedy search: an unclaimed station proposes a line, the line claims its stations.
class LineSearch {
 public:
  LineSearch(std::vector<Eigen::Vector2d> points, const LineLimits& limits, double most_oblique)
      : tolerance_m_(limits.off_line_m),
        same_m_(limits.same_station_m),
        twin_m_(limits.twin_m),
        most_oblique_(most_oblique),
        tree_(std::move(points)),
        group_of_(static_cast<size_t>(tree_.size()), kNone),
        on_line_{std::vector<bool>(group_of_.size(), false),
                 std::vector<bool>(group_of_.size(), false)} {}

  // Stations on a line found before wait until all lines are found from others: they belong to a
  // line that crosses there, or are another pass of that line, or repeat one of its stations.
  FoundLines run() {
    const std::vector<int> seeds = seeds_by_nearness();
    for (const int seed : seeds) {
      while (is_free(seed, LineAxis::kX) && is_free(seed, LineAxis::kZ) && claim_line_from(seed)) {
      }
    }
    adopt_left_out();
    leave_only_repeated();
    for (const int seed : seeds) {
      while (!is_claimed(seed) && claim_line_from(seed)) {
      }
    }
    FoundLines found{std::move(groups_), {}};
    for (int station = 0; station < tree_.size(); ++station) {
      if (!is_claimed(station)) found.unplaced.push_back(station);
    }
    return found;
  }

  // The largest group that is found from a seed, or from the stations found from it: a seed beside
  // a line first finds a part of it, on a line across it at a small angle.
  StationGroup line_near(int seed, LineAxis axis) const {
    StationGroup best = line_found_from(seed, axis);
    for (bool grew = true; grew;) {
      grew = false;
      for (const size_t quarter : {1, 2, 3}) {
        if (best.stations.empty()) return best;
        StationGroup other =
            line_found_from(best.stations[quarter * best.stations.size() / 4], axis);
        if (other.stations.size() <= best.stations.size()) continue;
        best = std::move(other);
        grew = true;
      }
    }
    return best;
  }

 private:
  static constexpr int kNone = -1;
  int& group_of(int station) { return group_of_[static_cast<size_t>(station)]; }
  bool is_claimed(int station) const { return group_of_[static_cast<size_t>(station)] != kNone; }
  // Whether a station is on a line along an axis that is found already, or rather too far beside it
  // than on another: within twice the tolerance.
  bool is_on_line(int station, LineAxis axis) const {
    return on_line_[static_cast<size_t>(along_index(axis))][static_cast<size_t>(station)];
  }
  // Whether a station may be of a new line along an axis: it is of none, and on none of that axis,
  // of which it would be another pass.
  bool is_free(int station, LineAxis axis) const {
    return !is_claimed(station) && !is_on_line(station, axis);
  }

  StationGroup line_found_from(int seed, LineAxis axis) const {
    const std::vector<int> candidates = stations_in_wedge(seed, axis);
    if (candidates.empty()) return {};
    return refit(best_line_through(seed, axis, candidates));
  }

  // Stations with near neighbours first: these are the likeliest to be of one line.
  std::vector<int> seeds_by_nearness() const {
    constexpr int kGrain = 256;
    std::vector<std::pair<double, int>> seeds(static_cast<size_t>(tree_.size()));
    Progress progress("finding the neighbours of", tree_.size(), "stations",
                      Progress::Shown::kIfLong);
    parallel_for(0, tree_.size(), kGrain, [&](int begin, int end) {
      for (int seed = begin; seed < end; ++seed) {
        seeds[static_cast<size_t>(seed)] = {
            std::min(nearest_in_wedge(seed, LineAxis::kX), nearest_in_wedge(seed, LineAxis::kZ)),
            seed};
      }
      progress.advance(end - begin);
    });
    std::sort(seeds.begin(), seeds.end());
    std::vector<int> order;
    order.reserve(seeds.size());
    for (const auto& [distance, seed] : seeds) order.push_back(seed);
    return order;
  }

  // Claims the likelier of the lines along x and z near the seed; false if there is none. The seed
  // may not be on it (a stray station beside a line first finds that line, then remains alone), but
  // every line claims at least two stations.
  bool claim_line_from(int seed) {
    StationGroup best;
    for (StationGroup& group : lines_near(seed)) {
      if (group.stations.size() < 2) continue;
      if (best.stations.empty() || likelihood(group) > likelihood(best)) best = std::move(group);
    }
    if (best.stations.empty()) return false;
    for (const int station : best.stations) group_of(station) = static_cast<int>(groups_.size());
    progress_.advance(static_cast<std::int64_t>(best.stations.size()));
    mark_stations_on(best);
    groups_.push_back(std::move(best));
    return true;
  }

  // The lines along x and z near the seed; without stations where there is none or the seed cannot
  // be of one.
  std::array<StationGroup, 2> lines_near(int seed) const {
    std::array<StationGroup, 2> groups;
    parallel_for(0, 2, 1, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const LineAxis axis = i == 0 ? LineAxis::kX : LineAxis::kZ;
        if (is_free(seed, axis)) groups[static_cast<size_t>(i)] = line_near(seed, axis);
      }
    });
    return groups;
  }

  void mark_stations_on(const StationGroup& group) {
    const PlanLine& line = group.line;
    const double first_m = line.along(point(group.stations.front()));
    const double last_m = line.along(point(group.stations.back()));
    const double reach_m =
        kReachInSpacings * (last_m - first_m) / static_cast<double>(group.stations.size() - 1);
    const std::vector<int> near = stations_near(tree_, line, 2.0 * tolerance_m_, [&](int station) {
      const double along_m = line.along(point(station));
      return line.distance_to(point(station)) <= tolerance_m_ ||
             (along_m >= first_m - reach_m && along_m <= last_m + reach_m);
    });
    auto& on_line = on_line_[static_cast<size_t>(along_index(line.axis))];
    for (const int station : near) on_line[static_cast<size_t>(station)] = true;
  }

  // Compares groups: whether one is long enough to have a direction; then how densely its stations
  // follow each other, as stations of a line are closer together than parallel lines.
  std::pair<bool, double> likelihood(const StationGroup& group) const {
    const double length_m = group.line.along(point(group.stations.back())) -
                            group.line.along(point(group.stations.front()));
    return {length_m > kShortestInTolerances * tolerance_m_,
            static_cast<double>(group.stations.size() - 1) / length_m};
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
           across[1 - u] <= 2.0 * tolerance_m_ + most_oblique_ * along[u];
  }

  bool is_candidate(int seed, int other, LineAxis axis) const {
    const Eigen::Vector2d apart = (point(other) - point(seed)).cwiseAbs();
    return is_free(other, axis) && in_wedge(apart, apart, axis);
  }

  // Free stations that a line through the seed, no more oblique than allowed, could hold: all, or
  // the nearest along the axis where these are enough to tell the line. The refit takes in those
  // farther along it; comparing all of a large grid for every line would take its square.
  std::vector<int> stations_in_wedge(int seed, LineAxis axis) const {
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

  std::vector<int> stations_in_wedge(int seed, LineAxis axis, double reach_m) const {
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
  PlanLine best_line_through(int seed, LineAxis axis, const std::vector<int>& candidates) const {
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
  StationGroup refit(const PlanLine& line) const {
    StationGroup converged = refit_until_settled(line);
    if (converged.stations.size() < 2) return {};
    StationGroup trimmed = refit_to_most(converged.line);
    StationGroup& best = trimmed.stations.size() > converged.stations.size() ? trimmed : converged;
    if (follows_oblique_line(best)) return {};
    return std::move(best);
  }

  // Least squares over the stations within tolerance, until the set no longer changes. The first
  // round admits twice the tolerance, as the two stations it starts from may both be off.
  StationGroup refit_until_settled(PlanLine line) const {
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
  StationGroup refit_to_most(PlanLine line) const {
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
  bool follows_oblique_line(const StationGroup& group) const {
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

  PlanLine fitted(const std::vector<int>& members, LineAxis axis) const {
    return fit_line_within(points_of(members), axis, most_oblique_);
  }

  // Free stations within `limit_m` of the line, in order along it; of several within twin_m_
  // only the first, as the others may belong to the line that crosses here.
  std::vector<int> stations_within(const PlanLine& line, double limit_m) const {
    std::vector<int> near = stations_near(tree_, line, limit_m,
                                          [&](int station) { return is_free(station, line.axis); });
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
  bool has_twin_before(const std::vector<int>& members, const PlanLine& line, int station) const {
    const double along_m = line.along(point(station));
    for (auto member = members.rbegin(); member != members.rend(); ++member) {
      if (along_m - line.along(point(*member)) > twin_m_) return false;
      if (distance(*member, station) <= twin_m_) return true;
    }
    return false;
  }

  // Gives stations on a line to it, unless they repeat one of its own; the nearest first. A station
  // is on a line too if some line is within tolerance of it and of all of the line's stations: the
  // least squares may be farther from it.
  void adopt_left_out() {
    std::vector<std::tuple<double, int, size_t>> near;  // distance, station, group
    for (int station = 0; station < tree_.size(); ++station) {
      if (is_claimed(station)) continue;
      for (size_t group = 0; group < groups_.size(); ++group) {
        const double off_m = groups_[group].line.distance_to(point(station));
        if (off_m <= 2.0 * tolerance_m_) near.emplace_back(off_m, station, group);
      }
    }
    std::sort(near.begin(), near.end());
    for (const auto& [off_m, station, group] : near) {
      if (is_claimed(station) || repeats_one_of(static_cast<int>(group), station)) continue;
      if (!take_in(station, &groups_[group])) continue;
      group_of(station) = static_cast<int>(group);
    }
  }

  // Adds a station to a group, whose line is moved as far as it is uncertain; false if that is not
  // enough.
  bool take_in(int station, StationGroup* group) const {
    if (group->line.distance_to(point(station)) > tolerance_m_) {
      if (off_fitted_line(station, *group) > tolerance_m_) return false;
      std::vector<Eigen::Vector2d> points = points_of(group->stations);
      points.push_back(point(station));
      const PlanLine line = narrowest_line(points, group->line.axis, most_oblique_);
      if (std::any_of(points.begin(), points.end(), [&](const Eigen::Vector2d& at) {
            return line.distance_to(at) > tolerance_m_;
          })) {
        return false;
      }
      group->line = line;
    }
    group->stations.push_back(station);
    return true;
  }

  // How far a station is beside the least-squares line of a group, less what that is uncertain by.
  double off_fitted_line(int station, const StationGroup& group) const {
    const PlanLine& line = group.line;
    const Eigen::Vector2d across(-line.direction.y(), line.direction.x());
    const auto place = [&](int at) {
      return Eigen::Vector2d(line.along(point(at)), (point(at) - line.origin).dot(across));
    };
    std::vector<Eigen::Vector2d> places;
    for (const int member : group.stations) places.push_back(place(member));
    const StraightFit fit(places);
    const Eigen::Vector2d at = place(station);
    return std::abs(fit.off(at)) - kSureErrors * fit.error_at(at.x());
  }

  bool repeats_one_of(int group, int station) const {
    return repeats(station,
                   [&](int other) { return group_of_[static_cast<size_t>(other)] == group; });
  }

  // Whether one of the stations that `accept(index)` takes counts as one with a station.
  template <typename Accept>
  bool repeats(int station, const Accept& accept) const {
    const std::vector<int> same = tree_.find(
        [&](const PlanBox& box) { return box.least_apart(point(station)).norm() <= same_m_; },
        [&](int other) { return accept(other) && distance(other, station) <= same_m_; });
    return !same.empty();
  }

  // Of the stations left, only those may form more lines that repeat a claimed one, as where lines
  // cross; others are beside lines.
  void leave_only_repeated() {
    for (int station = 0; station < tree_.size(); ++station) {
      if (is_claimed(station)) continue;
      if (repeats(station, [&](int other) { return is_claimed(other); })) continue;
      for (auto& on_line : on_line_) on_line[static_cast<size_t>(station)] = true;
    }
  }

  std::vector<Eigen::Vector2d> points_of(const std::vector<int>& stations) const {
    std::vector<Eigen::Vector2d> points;
    points.reserve(stations.size());
    for (const int station : stations) points.push_back(point(station));
    return points;
  }
  const Eigen::Vector2d& point(int index) const { return tree_.point(index); }
  double distance(int a, int b) const { return (point(a) - point(b)).norm(); }

  double tolerance_m_, same_m_, twin_m_, most_oblique_;
  StationTree tree_;
  std::vector<int> group_of_;                 // index into groups_; kNone: not claimed
  std::array<std::vector<bool>, 2> on_line_;  // along x and z
  std::vector<StationGroup> groups_;
  Progress progress_{"finding the lines of", tree_.size(), "stations", Progress::Shown::kIfLong};
};

// The stations' indices by position, so that the order of the list does not matter.
std::vector<int> order_by_position(std::span<const StationPose> stations) {
  std::vector<int> order(stations.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int index) {
    const StationPose& station = stations[static_cast<size_t>(index)];
    return std::tuple<double, double, double, const std::string&>(
        station.position_m.x(), station.position_m.z(), station.position_m.y(), station.file);
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  return order;
}

}  // namespace

FoundLines find_lines(std::span<const StationPose> stations, const LineLimits& limits) {
  const std::vector<int> order = order_by_position(stations);
  std::vector<Eigen::Vector2d> points;
  points.reserve(order.size());
  for (const int index : order) points.push_back(plan_of(stations[static_cast<size_t>(index)]));
  FoundLines found = LineSearch(std::move(points), limits, tangent_of(kMaxObliquenessDeg)).run();
  const auto to_listed = [&](std::vector<int>& indices) {
    for (int& index : indices) index = order[static_cast<size_t>(index)];
  };
  for (StationGroup& group : found.groups) to_listed(group.stations);
  to_listed(found.unplaced);
  std::sort(found.unplaced.begin(), found.unplaced.end());
  return found;
}

StationGroup line_near(std::span<const StationPose> stations, const LineLimits& limits, int station,
                       LineAxis axis, double most_oblique_deg) {
  return LineSearch(plans_of(stations), limits, tangent_of(most_oblique_deg))
      .line_near(station, axis);
}

}  // namespace raywalk
