#include "core/geometry/line_heights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/length_text.h"
#include "core/geometry/straight_fit.h"

namespace raywalk {
namespace {

double height_of(const Station& station) { return station.position_m.y(); }

std::vector<Eigen::Vector2d> heights_along(const Line& line) {
  std::vector<Eigen::Vector2d> points;
  for (const Station& station : line.stations) {
    points.emplace_back(station.along_m, height_of(station));
  }
  return points;
}

// How far a station is above the straight line between its neighbours.
double above_neighbours(const Line& line, std::size_t i) {
  const Station &before = line.stations[i - 1], &here = line.stations[i],
                &after = line.stations[i + 1];
  const double share = (here.along_m - before.along_m) / (after.along_m - before.along_m);
  return height_of(here) - height_of(before) - share * (height_of(after) - height_of(before));
}

bool goes_up_and_down_hill(const Line& line, double tolerance_m) {
  const double steepest = std::tan(radians_from_degrees(kMaxClimbDeg));
  for (std::size_t i = 1; i < line.stations.size(); ++i) {
    const Station &before = line.stations[i - 1], &here = line.stations[i];
    const double climb_m = std::abs(height_of(here) - height_of(before));
    if (climb_m > steepest * (here.along_m - before.along_m) + tolerance_m) return false;
    if (i + 1 < line.stations.size() && std::abs(above_neighbours(line, i)) > tolerance_m) {
      return false;
    }
  }
  return true;
}

}  // namespace

void check_heights(const Line& line, std::span<const std::string> names, double tolerance_m) {
  const std::vector<Eigen::Vector2d> heights = heights_along(line);
  const StraightFit straight(heights);
  const double steepest = std::tan(radians_from_degrees(kMaxClimbDeg));
  if (std::abs(straight.slope) > steepest) {
    throw Error(fmt::format(
        "the line from {} to {} climbs by {:.3g} degrees, more than {:.3g}; is y the height?",
        names.front(), names.back(), degrees_from_radians(std::atan(straight.slope)),
        kMaxClimbDeg));
  }
  const auto farthest = std::max_element(
      heights.begin(), heights.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
        return std::abs(straight.off(a)) < std::abs(straight.off(b));
      });
  const double off_m = straight.off(*farthest);
  const double known_to_m = kSureErrors * straight.error_at(farthest->x());
  if (std::abs(off_m) <= tolerance_m || goes_up_and_down_hill(line, tolerance_m) ||
      (std::abs(off_m) <= tolerance_m + known_to_m &&
       narrowest_strip(heights, steepest).half_width <= tolerance_m)) {
    return;
  }
  throw Error(fmt::format(
      "{} is {} {} the straight line through the heights of its line, from {} to {}, more than the "
      "line tolerance of {}; correct its y, leave it out, or give --line-tolerance-mm {}",
      names[static_cast<std::size_t>(farthest - heights.begin())], mm_text(std::abs(off_m)),
      off_m > 0.0 ? "above" : "below", line.stations.front().file, line.stations.back().file,
      mm_text(tolerance_m), mm_at_least(std::abs(off_m))));
}

}  // namespace raywalk
