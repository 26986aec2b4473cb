#include "core/geometry/unplaced_stations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/error.h"
#include "core/geometry/length_text.h"
#include "core/geometry/line_gaps.h"

namespace raywalk {
namespace {

// Lines up to this oblique are recognised, to say that they are too oblique.
constexpr double kMostObliqueNamedDeg = 20.0;
// Stations farther from a line than this and its spacing are rather alone than beside it.
constexpr double kFarInTolerances = 3.0;

// A found line and the part of it that its stations cover.
struct Extent {
  const StationGroup* group = nullptr;
  double first_m = 0.0, last_m = 0.0;
  double spacing_m = 0.0;
  std::string text{};  // "the line along x from a.jpg to b.jpg (12 stations)"
};

class Reasons {
 public:
  Reasons(std::span<const StationPose> stations, const LineLimits& limits)
      : stations_(stations), limits_(limits) {}

  Extent extent_of(const StationGroup& group) const {
    std::vector<std::pair<double, int>> members;
    for (const int member : group.stations) {
      members.emplace_back(group.line.along(plan(member)), member);
    }
    std::sort(members.begin(), members.end());
    std::vector<double> gaps_m;
    for (size_t i = 1; i < members.size(); ++i) {
      gaps_m.push_back(members[i].first - members[i - 1].first);
    }
    return {.group = &group,
            .first_m = members.front().first,
            .last_m = members.back().first,
            .spacing_m = gaps_m.empty() ? 0.0 : covering_spacing(std::move(gaps_m)),
            .text = fmt::format("the line along {} from {} to {} ({} stations)",
                                name_of(group.line.axis), pose(members.front().second).file,
                                pose(members.back().second).file, members.size())};
  }

  // Whether a station is beside the part of a line that is covered, or a spacing from its ends.
  bool is_beside(const Extent& line, int station) const {
    const double along_m = line.group->line.along(plan(station));
    return along_m >= line.first_m - line.spacing_m && along_m <= line.last_m + line.spacing_m;
  }

  // Throws if others have the position of a station.
  void require_own_position(int station) const {
    const StationTree tree = tree_of(stations_);
    const Eigen::Vector2d& point = tree.point(station);
    const double same_m = limits_.same_station_m;
    const std::vector<int> here =
        tree.find([&](const PlanBox& box) { return box.least_apart(point).norm() <= same_m; },
                  [&](int other) { return (tree.point(other) - point).norm() <= same_m; });
    if (here.size() < 2) return;
    double apart_m = 0.0;
    for (const int other : here) apart_m = std::max(apart_m, (tree.point(other) - point).norm());
    constexpr std::size_t kMostNamed = 3;
    std::string names = name_of(pose(here.front()));
    for (std::size_t i = 1; i < std::min(here.size(), kMostNamed); ++i) {
      names += " and " + name_of(pose(here[i]));
    }
    const std::string place = fmt::format("x = {:.6g}, z = {:.6g}", point.x(), point.y());
    if (apart_m == 0.0) {
      throw Error(fmt::format(
          "{} have the same position ({}), and no other line crosses there; remove one of them or "
          "correct its position",
          names, place));
    }
    throw Error(fmt::format(
        "{} are {} apart ({}), and stations within {} count as one; remove one of them, correct "
        "its position, or give a smaller --same-station-mm",
        names, mm_text(apart_m), place, mm_text(same_m)));
  }

  // Throws if a station is on a line that is too oblique and has more stations than any other line
  // beside it.
  void require_straight_axes(const std::vector<Extent>& lines, int station) const {
    size_t most = 2;
    for (const Extent& line : lines) {
      if (is_beside(line, station)) most = std::max(most, line.group->stations.size());
    }
    for (const LineAxis axis : {LineAxis::kX, LineAxis::kZ}) {
      const StationGroup group = line_near(stations_, limits_, station, axis, kMostObliqueNamedDeg);
      const bool on_it =
          std::find(group.stations.begin(), group.stations.end(), station) != group.stations.end();
      const double angle_deg = degrees_from_radians(std::atan(group.line.obliqueness()));
      if (!on_it || group.stations.size() <= most || angle_deg <= kMaxObliquenessDeg) continue;
      throw Error(fmt::format(
          "{} is on {}, which is turned by {:.2g} degrees from {}, more than {:g}; turn the "
          "positions so that lines run along x and z",
          name_of(pose(station)), extent_of(group).text, angle_deg, name_of(axis),
          kMaxObliquenessDeg));
    }
  }

  // For a station beside a line; `others` are beside lines too.
  [[noreturn]] void throw_beside(const Extent& line, int station,
                                 std::span<const double> others_m) const {
    const double off_m = off(line, station);
    double most_m = off_m;
    for (const double other_m : others_m) most_m = std::max(most_m, other_m);
    const std::string others = others_m.empty()
                                   ? ""
                                   : fmt::format(" ({} more likewise, the farthest by {})",
                                                 others_m.size(), mm_text(most_m));
    throw Error(fmt::format(
        "{} is {} beside {}, more than the line tolerance of {}{}; correct its position, leave it "
        "out, or give --line-tolerance-mm {}",
        located(station), mm_text(off_m), line.text, mm_text(limits_.off_line_m), others,
        mm_at_least(most_m)));
  }

  double off(const Extent& line, int station) const {
    return line.group->line.distance_to(plan(station));
  }

  std::optional<Extent> nearest_beside(const std::vector<Extent>& lines, int station) const {
    std::optional<Extent> nearest;
    double least_m = std::numeric_limits<double>::infinity();
    for (const Extent& line : lines) {
      const double off_m = off(line, station);
      if (!is_beside(line, station) || off_m >= least_m) continue;
      least_m = off_m;
      nearest = line;
    }
    return nearest;
  }

  // The largest line beside which all stations of another of its axis lie within twice the
  // tolerance.
  std::optional<Extent> line_close_to(const Extent& other, const std::vector<Extent>& lines) const {
    for (const Extent& line : lines) {
      if (line.group == other.group || line.group->line.axis != other.group->line.axis) continue;
      if (line.group->stations.size() < other.group->stations.size()) continue;
      if (std::all_of(other.group->stations.begin(), other.group->stations.end(), [&](int member) {
            return off(line, member) <= 2.0 * limits_.off_line_m && is_beside(line, member);
          })) {
        return line;
      }
    }
    return std::nullopt;
  }

  [[noreturn]] void throw_alone(const std::optional<Extent>& nearest, int station) const {
    const std::string beside =
        nearest ? fmt::format("; {} is {} away", nearest->text, mm_text(off(*nearest, station)))
                : "";
    throw Error(fmt::format(
        "{} is on no line: no other station that is on no line either lies within the line "
        "tolerance of {} of a line along x or z through it, and farther along it than that; a line "
        "needs at least two{}",
        located(station), mm_text(limits_.off_line_m), beside));
  }

  Eigen::Vector2d plan(int station) const { return plan_of(pose(station)); }
  const StationPose& pose(int station) const { return stations_[static_cast<size_t>(station)]; }

 private:
  std::string located(int station) const {
    return fmt::format("{} at x = {:.6g}, z = {:.6g}", name_of(pose(station)), plan(station).x(),
                       plan(station).y());
  }

  std::span<const StationPose> stations_;
  LineLimits limits_;
};

std::vector<Extent> extents_of(const Reasons& reasons, const std::vector<StationGroup>& groups) {
  std::vector<Extent> lines;
  lines.reserve(groups.size());
  for (const StationGroup& group : groups) lines.push_back(reasons.extent_of(group));
  return lines;
}

}  // namespace

std::string name_of(const StationPose& station) {
  return station.where.empty() ? station.file : fmt::format("{} ({})", station.file, station.where);
}

void throw_unplaced(std::span<const StationPose> stations, const LineLimits& limits,
                    const std::vector<StationGroup>& others, std::span<const int> unplaced) {
  const Reasons reasons(stations, limits);
  const std::vector<Extent> lines = extents_of(reasons, others);
  const int first = unplaced.front();
  reasons.require_own_position(first);
  reasons.require_straight_axes(lines, first);
  const auto line_beside = [&](int station) -> std::optional<Extent> {
    std::optional<Extent> nearest = reasons.nearest_beside(lines, station);
    if (!nearest) return nearest;
    const double far_m = std::max(nearest->spacing_m, kFarInTolerances * limits.off_line_m);
    if (reasons.off(*nearest, station) > far_m) nearest.reset();
    return nearest;
  };
  const std::optional<Extent> line = line_beside(first);
  if (!line) reasons.throw_alone(reasons.nearest_beside(lines, first), first);
  std::vector<double> others_m;
  for (const int station : unplaced.subspan(1)) {
    if (const auto beside = line_beside(station)) others_m.push_back(reasons.off(*beside, station));
  }
  reasons.throw_beside(*line, first, others_m);
}

void require_lines_apart(std::span<const StationPose> stations, const LineLimits& limits,
                         const std::vector<StationGroup>& lines) {
  const Reasons reasons(stations, limits);
  const std::vector<Extent> extents = extents_of(reasons, lines);
  for (const Extent& line : extents) {
    const auto closest = reasons.line_close_to(line, extents);
    if (!closest) continue;
    const std::vector<int>& members = line.group->stations;
    std::vector<double> others_m;
    for (const int member : std::span(members).subspan(1)) {
      others_m.push_back(reasons.off(*closest, member));
    }
    reasons.throw_beside(*closest, members.front(), others_m);
  }
}

}  // namespace raywalk
