// Finds the lines of a grid from the positions of its stations, or by their names.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/geometry/grid.h"
#include "core/geometry/line_gaps.h"
#include "core/geometry/plan_line.h"
#include "core/geometry/position_tolerance.h"

namespace raywalk {
namespace {

// "front_000.jpg (poses.csv:2)", for errors.
std::string name_of(const StationPose& station) {
  return station.where.empty() ? station.file : fmt::format("{} ({})", station.file, station.where);
}

Eigen::Vector2d plan_of(const StationPose& station) {
  return {station.position_m.x(), station.position_m.z()};
}

// Rails do not climb by more than some degrees: a list that is high and narrow has y and another
// axis exchanged. Throws Error.
void require_level(std::span<const StationPose> stations) {
  Eigen::AlignedBox3d box;
  for (const StationPose& station : stations) box.extend(station.position_m);
  const Eigen::Vector3d span_m = box.sizes();
  const char narrow = span_m.x() < span_m.z() ? 'x' : 'z';
  const double narrow_m = std::min(span_m.x(), span_m.z());
  const double wide_m = std::max(span_m.x(), span_m.z());
  if (span_m.y() <= 0.3 * wide_m || span_m.y() <= 10.0 * narrow_m) return;
  throw Error(
      fmt::format("the heights y of the stations span {:.3g} m and their {} only {:.3g} m: y is "
                  "up, and seems to be exchanged with {} in the list",
                  span_m.y(), narrow, narrow_m, narrow));
}

// Throws Error for a station whose height does not fit those of its line: heights may go up and
// down hill by 6 degrees (a road of 10 %), and each may be within the tolerance of such a hill.
void check_heights(const Line& line, std::span<const std::string> names, double tolerance_m) {
  const double steepest = std::tan(radians_from_degrees(6.0));
  const auto climb = [&](std::size_t from, std::size_t to) {
    return line.stations[to].position_m.y() - line.stations[from].position_m.y();
  };
  const auto length = [&](std::size_t from, std::size_t to) {
    return line.stations[to].along_m - line.stations[from].along_m;
  };
  const auto above_neighbours = [&](std::size_t i) {
    const double part = length(i - 1, i) / length(i - 1, i + 1);
    return climb(i - 1, i) - part * climb(i - 1, i + 1);
  };
  const std::size_t last = line.stations.size() - 1;
  std::size_t worst = 1;
  for (std::size_t i = 2; i < last; ++i) {
    if (std::abs(above_neighbours(i)) > std::abs(above_neighbours(worst))) worst = i;
  }
  if (last > 1 && std::abs(above_neighbours(worst)) > 2.0 * tolerance_m) {
    const double above_m = above_neighbours(worst);
    throw Error(fmt::format(
        "{} is {} {} the height between its neighbours on the line from {} to {}, more than twice "
        "the line tolerance of {}; correct its y, leave it out, or give --line-tolerance-mm {}",
        names[worst], mm_text(std::abs(above_m)), above_m > 0.0 ? "above" : "below", names.front(),
        names.back(), mm_text(tolerance_m), mm_at_least(0.5 * std::abs(above_m))));
  }
  const auto require_road = [&](std::size_t from, std::size_t to) {
    const double climb_m = climb(from, to), length_m = length(from, to);
    if (std::abs(climb_m) <= steepest * length_m + 2.0 * tolerance_m) return;
    throw Error(fmt::format(
        "the line climbs by {:.3g} degrees from {} to {}, more than 6; is y the height?",
        degrees_from_radians(std::atan2(climb_m, length_m)), names[from], names[to]));
  };
  require_road(0, last);
  for (std::size_t i = 1; i <= last; ++i) require_road(i - 1, i);
}

class LineAssembly {
 public:
  LineAssembly(std::span<const StationPose> stations, const GridTolerance& tolerance)
      : stations_(stations) {
    for (const StationPose& station : stations) points_.push_back(plan_of(station));
    const auto is_unnamed = [](const StationPose& station) { return station.line.empty(); };
    const auto unnamed = std::ranges::find_if(stations, is_unnamed);
    named_ = !std::ranges::all_of(stations, is_unnamed);
    if (named_ && unnamed != stations.end()) {
      throw Error(fmt::format(
          "{}: no line is named, but others are; name the line of every frame or of none",
          name_of(*unnamed)));
    }
    set_limits(tolerance);
  }

  std::vector<Line> run() const {
    std::vector<Line> lines;
    for (LineGroup& group : named_ ? named_groups() : found_groups()) {
      lines.push_back(line_of(std::move(group)));
    }
    return lines;
  }

 private:
  void set_limits(const GridTolerance& tolerance) {
    constexpr double kSameStationShare = 0.002, kLeastShare = 1e-9;
    // Stations of a line that is named need not be told from those beside it.
    const double off_share = named_ ? 0.5 : kOffPlaceShare;
    const double spacing_m = typical_spacing(stations_);
    if (!named_ && tolerance.off_line_m.value_or(0.0) > spacing_m) {
      throw Error(fmt::format(
          "a line tolerance of {} exceeds the stations' spacing of {}, so that lines cannot be "
          "distinguished from places beside them; give a smaller --line-tolerance-mm, or name the "
          "line of "
          "every frame in a column line",
          mm_text(*tolerance.off_line_m), mm_text(spacing_m)));
    }
    spacing_m_ = spacing_m;
    Eigen::AlignedBox3d extent;
    double largest_m = 0.0;
    for (const StationPose& station : stations_) {
      extent.extend(station.position_m);
      largest_m = std::max(largest_m, station.position_m.cwiseAbs().maxCoeff());
    }
    const double rounding = rounding_m(largest_m);
    const double least_m = kLeastShare * extent.diagonal().norm() + 2.0 * rounding;
    off_line_m_ =
        tolerance.off_line_m.value_or(std::max(off_share * spacing_m, least_m)) + rounding;
    same_station_m_ =
        rounding + tolerance.same_station_m.value_or(std::min(
                       std::max(kSameStationShare * spacing_m, least_m), 0.5 * off_line_m_));
    if (same_station_m_ > off_line_m_) {
      throw UsageError(fmt::format(
          "stations within {} count as one, but a station may be only {} off its line; give a "
          "smaller --same-station-mm or a larger --line-tolerance-mm",
          mm_text(same_station_m_), mm_text(off_line_m_)));
    }
    twin_m_ = std::max(same_station_m_, std::min(off_line_m_, kOffPlaceShare * spacing_m));
  }

  // By the names of the lines. A line runs along the axis on which its stations are farther apart.
  std::vector<LineGroup> named_groups() const {
    std::map<std::string, std::vector<int>> members;
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      members[stations_[i].line].push_back(static_cast<int>(i));
    }
    std::vector<LineGroup> groups;
    for (auto& [name, stations] : members) {
      if (stations.size() < 2) {
        throw Error(fmt::format("{} is the only station of line {}; a line needs at least two",
                                this->name(stations.front()), name));
      }
      const std::vector<Eigen::Vector2d> points = points_of(stations);
      Eigen::AlignedBox2d extent;
      for (const Eigen::Vector2d& point : points) extent.extend(point);
      const LineAxis axis = extent.sizes().x() >= extent.sizes().y() ? LineAxis::kX : LineAxis::kZ;
      const PlanLine line = fit_line(points, axis, kMaxObliqueness);
      const auto off = [&](int station) { return line.distance_to(point(station)); };
      const int farthest = *std::ranges::max_element(stations, {}, off);
      if (off(farthest) > off_line_m_) {
        throw Error(fmt::format(
            "{} is {} off the line {} along {} that it is listed with, more than the line "
            "tolerance of {}; lines run along x or z within 3 degrees: correct its position or its "
            "line, or give --line-tolerance-mm {}",
            this->name(farthest), mm_text(off(farthest)), name, raywalk::name_of(axis),
            mm_text(off_line_m_), mm_at_least(off(farthest))));
      }
      groups.push_back({line, std::move(stations)});
    }
    return groups;
  }

  std::vector<LineGroup> found_groups() const {
    std::vector<LineGroup> groups = find_lines(points_, off_line_m_);
    share_out_intersections(points_, twin_m_, &groups);
    std::erase_if(groups, [](const LineGroup& group) { return group.stations.size() < 2; });
    require_all_placed(groups);
    return groups;
  }

  // Names the station farthest from all lines: a chance row of stations through it may have left
  // others without their line.
  void require_all_placed(const std::vector<LineGroup>& groups) const {
    std::set<int> unplaced;
    for (std::size_t i = 0; i < stations_.size(); ++i) unplaced.insert(static_cast<int>(i));
    for (const LineGroup& group : groups) {
      for (const int station : group.stations) unplaced.erase(station);
    }
    if (unplaced.empty()) return;
    constexpr double kTourShare = 0.25;
    const auto most_on_none = kTourShare * static_cast<double>(stations_.size());
    if (spacing_m_ > 0.0 && static_cast<double>(unplaced.size()) > most_on_none) {
      throw Error(fmt::format(
          "{} of {} stations, typically {} apart, are on no line within 3 degrees of x or z: the "
          "axes are turned, or this is a tour rather than lines. Views between stations need lines "
          "of stations decimetres apart (docs/capture.md); where the lines are known, name them in "
          "a column line",
          unplaced.size(), stations_.size(), mm_text(spacing_m_)));
    }
    const auto off = [&](int station) {
      double nearest_m = std::numeric_limits<double>::infinity();
      for (const LineGroup& group : groups) {
        nearest_m = std::min(nearest_m, group.line.distance_to(point(station)));
      }
      return nearest_m;
    };
    throw_unplaced(*std::ranges::max_element(unplaced, {}, off), groups);
  }

  [[noreturn]] void throw_unplaced(int station, const std::vector<LineGroup>& groups) const {
    const auto distance_to = [&](const LineGroup& group) {
      return group.line.distance_to(point(station));
    };
    const auto nearest = std::ranges::min_element(groups, {}, distance_to);
    const std::string beside =
        nearest == groups.end()
            ? ""
            : fmt::format("{} beside the line along {} from {} to {} ({} stations), and ",
                          mm_text(distance_to(*nearest)), raywalk::name_of(nearest->line.axis),
                          name(nearest->stations.front()), name(nearest->stations.back()),
                          nearest->stations.size());
    // A larger tolerance would join stations of different lines.
    const bool is_near = nearest != groups.end() && distance_to(*nearest) <= spacing_m_;
    throw Error(fmt::format(
        "{} at x = {:.6g}, z = {:.6g} is on no line: it is {}not in line with another station that "
        "is on none, within the line tolerance of {} and 3 degrees of x or z; a line needs at "
        "least two stations: correct its position, leave it out{}",
        name(station), point(station).x(), point(station).y(), beside, mm_text(off_line_m_),
        is_near ? fmt::format(
                      ", name its line in a column line, or give a larger --line-tolerance-mm ({})",
                      mm_at_least(distance_to(*nearest)))
                : ", or name its line in a column line"));
  }

  void require_two_places(int a, int b) const {
    const double apart_m = (point(a) - point(b)).norm();
    if (apart_m > same_station_m_) return;
    throw Error(fmt::format(
        "{} and {} {} (x = {:.6g}, z = {:.6g}) on one line; stations within {} count "
        "as one: remove one of them, correct its position, or give a smaller --same-station-mm",
        name(a), name(b),
        apart_m > 0.0 ? "are " + mm_text(apart_m) + " apart" : "have the same position",
        point(a).x(), point(a).y(), mm_text(same_station_m_)));
  }

  // The line's final fit to its own stations; along_m is 0 at the first station.
  Line line_of(LineGroup group) const {
    std::vector<int>& members = group.stations;
    const PlanLine fitted = fit_line(points_of(members), group.line.axis, kMaxObliqueness);
    const auto along = [&](int member) { return fitted.along(point(member)); };
    std::ranges::stable_sort(members, {}, along);
    for (std::size_t i = 0; i < members.size(); ++i) {
      for (std::size_t next = i + 1; next < members.size(); ++next) {
        if (along(members[next]) - along(members[i]) > same_station_m_) break;
        require_two_places(std::min(members[i], members[next]),
                           std::max(members[i], members[next]));
      }
    }
    // Stations side by side have the same place along the line, which must increase.
    constexpr double kLeastStep = 1e-9;
    const double first_m = along(members.front());
    const double least_step_m = kLeastStep * (along(members.back()) - first_m);
    const Eigen::Vector2d origin = fitted.origin + first_m * fitted.direction;
    Line line{.axis = fitted.axis,
              .origin = {origin.x(), origin.y()},
              .direction = {fitted.direction.x(), fitted.direction.y()}};
    std::vector<std::string> names;
    for (const int member : members) {
      names.push_back(name(member));
      const StationPose& pose = stations_[static_cast<std::size_t>(member)];
      double along_m = along(member) - first_m;
      if (!line.stations.empty()) along_m = std::max(along_m, line.last_m() + least_step_m);
      line.stations.push_back({pose.file, pose.position_m, along_m});
      line.height_m += pose.position_m.y() / static_cast<double>(members.size());
    }
    check_heights(line, names, off_line_m_);
    return line;
  }

  const Eigen::Vector2d& point(int station) const {
    return points_[static_cast<std::size_t>(station)];
  }
  std::string name(int station) const {
    return name_of(stations_[static_cast<std::size_t>(station)]);
  }
  std::vector<Eigen::Vector2d> points_of(const std::vector<int>& stations) const {
    std::vector<Eigen::Vector2d> points;
    points.reserve(stations.size());
    for (const int station : stations) points.push_back(point(station));
    return points;
  }

  std::span<const StationPose> stations_;
  std::vector<Eigen::Vector2d> points_;
  bool named_ = false;  // all lines are
  // From a station to its line; within which two of a line count as one; and within which two may
  // be those of an intersection, one of each line.
  double off_line_m_ = 0.0, same_station_m_ = 0.0, twin_m_ = 0.0;
  double spacing_m_ = 0.0;
};

// Lines along x in order of z, then lines along z in order of x; numbered in this order.
void sort_and_name(std::vector<Line>* lines) {
  const auto place = [](const Line& line) {
    const double middle = 0.5 * (line.first_m() + line.last_m());
    return line.axis == LineAxis::kX ? line.origin.z_m + middle * line.direction.z_m
                                     : line.origin.x_m + middle * line.direction.x_m;
  };
  std::sort(lines->begin(), lines->end(), [&](const Line& a, const Line& b) {
    return std::make_pair(a.axis, place(a)) < std::make_pair(b.axis, place(b));
  });
  int next_x = 0, next_z = 0;
  for (Line& line : *lines) {
    line.id =
        line.axis == LineAxis::kX ? fmt::format("x{}", next_x++) : fmt::format("z{}", next_z++);
  }
}

}  // namespace

Grid find_grid(std::span<const StationPose> stations, const GridTolerance& tolerance) {
  if (stations.empty()) throw Error("there are no stations");
  if (stations.size() == 1) {
    throw Error(name_of(stations.front()) + " is the only station; a line needs at least two");
  }
  for (const StationPose& station : stations) {
    if (station.position_m.allFinite()) continue;
    throw Error(fmt::format("{}: the position is not finite", name_of(station)));
  }
  if (stations.size() > 2) require_level(stations);
  // By name, so that the order of the list does not matter.
  std::vector<StationPose> by_name(stations.begin(), stations.end());
  std::ranges::stable_sort(by_name, {}, &StationPose::file);
  Grid grid;
  grid.lines = LineAssembly(by_name, tolerance).run();
  sort_and_name(&grid.lines);
  grid.cells = find_cells(grid.lines);
  return grid;
}

}  // namespace raywalk
