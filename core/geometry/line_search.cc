#include "core/geometry/line_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/geometry/line_near.h"
#include "core/geometry/position_tolerance.h"
#include "core/geometry/straight_fit.h"

namespace raywalk {
namespace {

// A group no longer than this many tolerances may as well be the stations around a place of a line
// along the other axis.
constexpr double kShortestInTolerances = 4.0;
// As far beyond its last station a line may have lost some.
constexpr double kReachInSpacings = 4.0 + kOffPlaceShare;

// Greedy search: an unclaimed station proposes a line, the line claims its stations.
class LineSearch {
 public:
  LineSearch(std::vector<Eigen::Vector2d> points, const LineLimits& limits)
      : tolerance_m_(limits.off_line_m),
        same_m_(limits.same_station_m),
        finder_(std::move(points), limits, kMaxObliquenessDeg),
        group_of_(static_cast<size_t>(tree().size()), kNone) {}

  // Stations on a line found before wait until all lines are found from others: they belong to a
  // line that crosses there, or are another pass of that line, or repeat one of its stations.
  FoundLines run() {
    const std::vector<int> seeds = seeds_by_nearness();
    for (const int seed : seeds) {
      while (finder_.is_free(seed, LineAxis::kX) && finder_.is_free(seed, LineAxis::kZ) &&
             claim_line_from(seed)) {
      }
    }
    adopt_left_out();
    leave_only_repeated();
    for (const int seed : seeds) {
      while (!is_claimed(seed) && claim_line_from(seed)) {
      }
    }
    FoundLines found{std::move(groups_), {}};
    for (int station = 0; station < tree().size(); ++station) {
      if (!is_claimed(station)) found.unplaced.push_back(station);
    }
    return found;
  }

 private:
  static constexpr int kNone = -1;

  bool is_claimed(int station) const { return group_of_[static_cast<size_t>(station)] != kNone; }
  void claim(int station, size_t group) {
    group_of_[static_cast<size_t>(station)] = static_cast<int>(group);
    finder_.take(station);
  }

  // Stations with near neighbours first: these are the likeliest to be of one line.
  std::vector<int> seeds_by_nearness() const {
    constexpr int kGrain = 256;
    std::vector<std::pair<double, int>> seeds(static_cast<size_t>(tree().size()));
    Progress progress("finding the neighbours of", tree().size(), "stations",
                      Progress::Shown::kIfLong);
    parallel_for(0, tree().size(), kGrain, [&](int begin, int end) {
      for (int seed = begin; seed < end; ++seed) {
        seeds[static_cast<size_t>(seed)] = {std::min(finder_.nearest_along(seed, LineAxis::kX),
                                                     finder_.nearest_along(seed, LineAxis::kZ)),
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
    for (const int station : best.stations) claim(station, groups_.size());
    progress_.advance(static_cast<std::int64_t>(best.stations.size()));
    take_stations_on(best);
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
        if (!finder_.is_free(seed, axis)) continue;
        groups[static_cast<size_t>(i)] = finder_.line_near(seed, axis);
      }
    });
    return groups;
  }

  // Stations on a found line, or rather too far beside it than on another (within twice the
  // tolerance), would be another pass of it.
  void take_stations_on(const StationGroup& group) {
    const PlanLine& line = group.line;
    const double first_m = line.along(point(group.stations.front()));
    const double last_m = line.along(point(group.stations.back()));
    const double reach_m =
        kReachInSpacings * (last_m - first_m) / static_cast<double>(group.stations.size() - 1);
    const std::vector<int> near = stations_near(tree(), line, 2.0 * tolerance_m_, [&](int station) {
      const double along_m = line.along(point(station));
      return line.distance_to(point(station)) <= tolerance_m_ ||
             (along_m >= first_m - reach_m && along_m <= last_m + reach_m);
    });
    for (const int station : near) finder_.take(station, line.axis);
  }

  // Compares groups: whether one is long enough to have a direction; then how densely its stations
  // follow each other, as stations of a line are closer together than parallel lines.
  std::pair<bool, double> likelihood(const StationGroup& group) const {
    const double length_m = group.line.along(point(group.stations.back())) -
                            group.line.along(point(group.stations.front()));
    return {length_m > kShortestInTolerances * tolerance_m_,
            static_cast<double>(group.stations.size() - 1) / length_m};
  }

  // Gives stations on a line to it, unless they repeat one of its own; the nearest first. A station
  // is on a line too if some line is within tolerance of it and of all of the line's stations: the
  // least squares may be farther from it.
  void adopt_left_out() {
    std::vector<std::tuple<double, int, size_t>> near;  // distance, station, group
    for (int station = 0; station < tree().size(); ++station) {
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
      claim(station, group);
    }
  }

  // Adds a station to a group, whose line is moved as far as it is uncertain; false if that is not
  // enough.
  bool take_in(int station, StationGroup* group) const {
    if (group->line.distance_to(point(station)) > tolerance_m_) {
      if (off_fitted_line(station, *group) > tolerance_m_) return false;
      std::vector<Eigen::Vector2d> points = finder_.points_of(group->stations);
      points.push_back(point(station));
      const PlanLine line = narrowest_line(points, group->line.axis, finder_.most_oblique());
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
    const std::vector<int> same = tree().find(
        [&](const PlanBox& box) { return box.least_apart(point(station)).norm() <= same_m_; },
        [&](int other) { return accept(other) && finder_.distance(other, station) <= same_m_; });
    return !same.empty();
  }

  // Of the stations left, only those may form more lines that repeat a claimed one, as where lines
  // cross; others are beside lines.
  void leave_only_repeated() {
    for (int station = 0; station < tree().size(); ++station) {
      if (is_claimed(station)) continue;
      if (repeats(station, [&](int other) { return is_claimed(other); })) continue;
      finder_.take(station);
    }
  }

  const StationTree& tree() const { return finder_.tree(); }
  const Eigen::Vector2d& point(int station) const { return finder_.point(station); }

  double tolerance_m_, same_m_;
  LineFinder finder_;          // a station that is claimed is taken
  std::vector<int> group_of_;  // index into groups_; kNone: not claimed
  std::vector<StationGroup> groups_;
  Progress progress_{"finding the lines of", tree().size(), "stations", Progress::Shown::kIfLong};
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
  FoundLines found = LineSearch(std::move(points), limits).run();
  const auto to_listed = [&](std::vector<int>& indices) {
    for (int& index : indices) index = order[static_cast<size_t>(index)];
  };
  for (StationGroup& group : found.groups) to_listed(group.stations);
  to_listed(found.unplaced);
  std::sort(found.unplaced.begin(), found.unplaced.end());
  return found;
}

}  // namespace raywalk
