#include "core/geometry/line_gaps.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>

#include "core/base/median.h"
#include "core/base/number_text.h"
#include "core/geometry/position_tolerance.h"

namespace raywalk {
namespace {

constexpr double kLargestGapInSpacings = 4.0;

std::vector<double> gaps_of(const Line& line) {
  std::vector<double> gaps_m;
  for (std::size_t i = 1; i < line.stations.size(); ++i) {
    gaps_m.push_back(line.stations[i].along_m - line.stations[i - 1].along_m);
  }
  return gaps_m;
}

PlanPoint place_at(const Line& line, double along_m) {
  return {line.origin.x_m + along_m * line.direction.x_m,
          line.origin.z_m + along_m * line.direction.z_m};
}

// The distance between two lines of one axis in the middle of the part that both cover; none if
// there is no such part.
std::optional<double> distance_between(const Line& a, const Line& b) {
  const double begin = std::max(a.first_m(), along_line(a, place_at(b, b.first_m())));
  const double end = std::min(a.last_m(), along_line(a, place_at(b, b.last_m())));
  if (begin >= end) return std::nullopt;
  const PlanPoint on_a = place_at(a, 0.5 * (begin + end));
  const PlanPoint on_b = place_at(b, along_line(b, on_a));
  return std::hypot(on_a.x_m - on_b.x_m, on_a.z_m - on_b.z_m);
}

// Of the corner where a line ends that the line `other` intersects: as far before the line's other
// end as it reaches beyond `other`.
PlanPoint far_corner(const Line& line, const Line& other) {
  const double at_m = along_line(line, intersection_of(line, other));
  const double before_m = at_m - line.first_m(), behind_m = line.last_m() - at_m;
  return place_at(line, behind_m > before_m ? line.last_m() - std::max(0.0, before_m)
                                            : line.first_m() + std::max(0.0, behind_m));
}

// Why lines that intersect close no cell; none if the reason is not that a side is missing.
std::optional<std::string> missing_side(const Grid& grid) {
  std::array<std::vector<const Line*>, 2> lines;  // along x, along z
  for (const Line& line : grid.lines) lines[line.axis == LineAxis::kX ? 0 : 1].push_back(&line);
  for (const std::size_t axis : {0, 1}) {
    const std::vector<const Line*>&these = lines[axis], &others = lines[1 - axis];
    if (these.empty() || others.size() < 2) continue;
    const Line &a = *others.front(), &b = *others.back();
    if (these.size() == 1) {
      const PlanPoint from = far_corner(a, *these[0]), to = far_corner(b, *these[0]);
      return fmt::format(
          "lines {}, {} and {} are three sides of a cell; the fourth, along {} from about {:.3g},"
          "{:.3g} to {:.3g},{:.3g} (x,z in metres), is missing: capture it, or list its stations",
          these[0]->id, a.id, b.id, name_of(these[0]->axis), from.x_m, from.z_m, to.x_m, to.z_m);
    }
    for (const Line* line : {these.front(), these.back()}) {
      for (const Line* other : {&a, &b}) {
        const PlanPoint corner = intersection_of(*line, *other);
        const double at_m = along_line(*line, corner);
        const double short_m = std::max(line->first_m() - at_m, at_m - line->last_m());
        if (short_m <= covering_spacing(*line)) continue;
        return fmt::format(
            "line {} ends {} before the corner with line {} at {:.3g},{:.3g} (x,z in metres), so "
            "no cell is closed: capture it up to there, or list its stations",
            line->id, mm_text(short_m), other->id, corner.x_m, corner.z_m);
      }
    }
  }
  return std::nullopt;
}

struct Neighbour {
  double distance_m = std::numeric_limits<double>::infinity();
  Eigen::Vector2d towards{0, 0};
};

double spacing_at(const StationPose& station, std::span<const StationPose> stations) {
  const double same_m = rounding_m(2.0 * station.position_m.cwiseAbs().maxCoeff());
  Neighbour first, second;
  for (const StationPose& other : stations) {
    const Eigen::Vector3d away = other.position_m - station.position_m;
    const Eigen::Vector2d towards(away.x(), away.z());
    const double distance_m = towards.norm();
    if (distance_m <= same_m || distance_m >= second.distance_m) continue;
    second = {distance_m, towards};
    if (second.distance_m < first.distance_m) std::swap(first, second);
  }
  if (!std::isfinite(second.distance_m)) return first.distance_m;
  const bool in_one_direction =
      first.towards.dot(second.towards) > 0.5 * first.distance_m * second.distance_m;
  return in_one_direction ? first.distance_m : second.distance_m;
}

}  // namespace

double typical_spacing(std::span<const StationPose> stations) {
  constexpr std::size_t kMeasured = 1000;
  const std::size_t count = std::min(kMeasured, stations.size());
  std::vector<double> distances_m;
  for (std::size_t i = 0; i < count; ++i) {
    const StationPose& station = stations[i * stations.size() / count];
    const double distance_m = spacing_at(station, stations);
    if (std::isfinite(distance_m)) distances_m.push_back(distance_m);
  }
  return distances_m.empty() ? 0.0 : median(std::move(distances_m));
}

double covering_spacing(std::vector<double> gaps_m) {
  std::ranges::sort(gaps_m, std::greater());
  const double middle_m = gaps_m[(gaps_m.size() - 1) / 2];
  const double half_m = 0.5 * std::accumulate(gaps_m.begin() + 1, gaps_m.end(), 0.0);
  double sum_m = 0.0;
  for (std::size_t i = 1; i < gaps_m.size(); ++i) {
    sum_m += gaps_m[i];
    if (sum_m >= half_m) return std::max(middle_m, gaps_m[i]);
  }
  return middle_m;
}

double covering_spacing(const Line& line) { return covering_spacing(gaps_of(line)); }

double median_spacing_m(const Line& line) { return median(gaps_of(line)); }

std::vector<LineGap> missing_sections(const Line& line) {
  const double spacing_m = covering_spacing(line);
  const double longest_m = kLargestGapInSpacings * spacing_m + place_tolerance_m(line, spacing_m);
  std::vector<LineGap> missing;
  for (std::size_t i = 1; i < line.stations.size(); ++i) {
    const double from_m = line.stations[i - 1].along_m, to_m = line.stations[i].along_m;
    if (to_m - from_m > longest_m) missing.push_back({static_cast<int>(i) - 1, from_m, to_m});
  }
  return missing;
}

std::vector<std::string> line_notes(const Grid& grid) {
  std::vector<std::string> notes;
  for (const Line& line : grid.lines) {
    for (const LineGap& gap : missing_sections(line)) {
      const auto after = static_cast<std::size_t>(gap.after);
      notes.push_back(fmt::format(
          "line {} has no station for {:.4g} m between {} and {}, more than 4 times its spacing of "
          "{:.3g} m; no cell is closed across this gap",
          line.id, gap.to_m - gap.from_m, line.stations[after].file, line.stations[after + 1].file,
          covering_spacing(line)));
    }
  }
  for (auto a = grid.lines.begin(); a != grid.lines.end(); ++a) {
    for (auto b = std::next(a); b != grid.lines.end() && b->axis == a->axis; ++b) {
      const std::optional<double> apart_m = distance_between(*a, *b);
      if (!apart_m || *apart_m > std::min(covering_spacing(*a), covering_spacing(*b))) continue;
      notes.push_back(fmt::format(
          "lines {} and {} are {} apart, closer than their stations; if they are passes of one "
          "line, give --line-tolerance-mm {}, or name the line of each in a column line",
          a->id, b->id, mm_text(*apart_m), mm_at_least(*apart_m)));
    }
  }
  const auto missing = grid.cells.empty() ? missing_side(grid) : std::nullopt;
  if (missing) notes.push_back(*missing);
  return notes;
}

std::optional<std::string> doubt_of_unit(const Grid& grid) {
  // Neighbours are of one placement of the slider, whose stroke is 1.75 m in our example
  // (configs/capture-osc.yaml); the sides of a cell may take up to 28 of those.
  constexpr double kWidestSpacing_m = 2.0, kWidestCell_m = 50.0;
  double spacing_m = 0.0, cell_m = 0.0;
  for (const Line& line : grid.lines) spacing_m = std::max(spacing_m, median_spacing_m(line));
  for (const Cell& cell : grid.cells) {
    cell_m = std::max({cell_m, cell.x_max_m - cell.x_min_m, cell.z_max_m - cell.z_min_m});
  }
  if (spacing_m <= kWidestSpacing_m && cell_m <= kWidestCell_m) return std::nullopt;
  return fmt::format(
      "stations {:.4g} m apart{}: are the positions in another unit, such as millimetres? x, y and "
      "z are read as metres; divide millimetres by 1000. Surfaces cannot be matched between "
      "stations metres apart: capture them decimetres apart",
      spacing_m, grid.cells.empty() ? "" : fmt::format(" and cells up to {:.4g} m wide", cell_m));
}

}  // namespace raywalk
