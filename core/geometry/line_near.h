// Finds the straight line along x or z with the most of the captured positions near one of them.
// Internal to find_grid (grid.h).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/plan_line.h"
#include "core/geometry/station_plan.h"
#include "core/geometry/station_tree.h"

namespace raywalk {

// The distances that decide which stations form a line, metres, none negative.
struct LineLimits {
  double off_line_m = 0.0;      // from a station to its line
  double same_station_m = 0.0;  // within which two stations count as one; at most twin_m
  // Within which two stations may be the two captured where lines cross, one of each; at most
  // off_line_m.
  double twin_m = 0.0;
};

// A line and the stations (indices) that belong to it.
struct StationGroup {
  PlanLine line;
  std::vector<int> stations;
};

// Finds lines from a station (the seed) among those that are still free.
class LineFinder {
 public:
  // Plan points, all of them free; lines may be oblique by up to `most_oblique_deg`.
  LineFinder(std::vector<Eigen::Vector2d> points, const LineLimits& limits,
             double most_oblique_deg);

  // The largest group that is found from a seed, or from the stations found from it: a seed beside
  // a line first finds a part of it, on a line across it at a small angle. Its stations are in
  // order along it; none if there is no line.
  StationGroup line_near(int seed, LineAxis axis) const;
  // The distance to the nearest station that may be of one line with the seed; infinite if there is
  // none.
  double nearest_along(int seed, LineAxis axis) const;

  // Whether a station may be of a new line along an axis.
  bool is_free(int station, LineAxis axis) const {
    return !taken_[static_cast<std::size_t>(along_index(axis))][static_cast<std::size_t>(station)];
  }
  // Leaves a station out of the lines found from now on, along one axis or both.
  void take(int station, LineAxis axis) {
    taken_[static_cast<std::size_t>(along_index(axis))][static_cast<std::size_t>(station)] = true;
  }
  void take(int station);

  const StationTree& tree() const { return tree_; }
  const Eigen::Vector2d& point(int station) const { return tree_.point(station); }
  std::vector<Eigen::Vector2d> points_of(const std::vector<int>& stations) const;
  double distance(int a, int b) const { return (point(a) - point(b)).norm(); }
  // Tangent of the largest angle between a line and its axis.
  double most_oblique() const { return most_oblique_; }

 private:
  StationGroup line_found_from(int seed, LineAxis axis) const;
  bool in_wedge(const Eigen::Vector2d& along, const Eigen::Vector2d& across, LineAxis axis) const;
  bool is_candidate(int seed, int other, LineAxis axis) const;
  std::vector<int> stations_in_wedge(int seed, LineAxis axis) const;
  std::vector<int> stations_in_wedge(int seed, LineAxis axis, double reach_m) const;
  PlanLine best_line_through(int seed, LineAxis axis, const std::vector<int>& candidates) const;
  StationGroup refit(const PlanLine& line) const;
  StationGroup refit_until_settled(PlanLine line) const;
  StationGroup refit_to_most(PlanLine line) const;
  bool follows_oblique_line(const StationGroup& group) const;
  PlanLine fitted(const std::vector<int>& members, LineAxis axis) const;
  std::vector<int> stations_within(const PlanLine& line, double limit_m) const;
  bool has_twin_before(const std::vector<int>& members, const PlanLine& line, int station) const;

  double tolerance_m_, twin_m_, most_oblique_;
  StationTree tree_;
  std::array<std::vector<bool>, 2> taken_;  // along x and z
};

// The line along `axis` with the most stations that passes near a station; lines may be oblique by
// up to `most_oblique_deg`. Without stations if there is none.
StationGroup line_near(std::span<const StationPose> stations, const LineLimits& limits, int station,
                       LineAxis axis, double most_oblique_deg);

}  // namespace raywalk
