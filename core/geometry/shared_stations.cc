// Which line the stations where lines cross are of.
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

#include "core/geometry/line_gaps.h"
#include "core/geometry/plan_line.h"
#include "core/geometry/position_tolerance.h"

namespace raywalk {
namespace {

constexpr int kNone = -1;
constexpr double kNoNeighbour = std::numeric_limits<double>::infinity();

// A station on a line: how far its neighbours there are, in spacings of the line.
struct Place {
  int line = kNone;
  double before = kNoNeighbour, after = kNoNeighbour;

  // As far beyond its last station a line may have lost some.
  bool is_near() const { return std::min(before, after) <= 4.0 + kOffPlaceShare; }
  // What the line would lose with the station: whether its end, and how wide its gap would be.
  std::pair<bool, double> loss(double more = 0.0) const {
    const bool is_end = before == kNoNeighbour || after == kNoNeighbour;
    return {is_end, (is_end ? std::min(before, after) : before + after) + more};
  }
};

class Sharing {
 public:
  Sharing(std::span<const Eigen::Vector2d> points, double twin_m, std::vector<LineGroup>* lines)
      : points_(points), twin_m_(twin_m), lines_(*lines) {}

  void run() {
    do {
      find_places();
      find_intersections();
    } while (drop_chance_rows());
    for (const auto& [lines, stations] : intersections_) decide(lines, stations);
    for (Place* place : left_) place->line = kNone;
    for (int line = 0; line < static_cast<int>(lines_.size()); ++line) {
      LineGroup& group = lines_[static_cast<std::size_t>(line)];
      std::erase_if(group.stations, [&](int i) { return on(group.line.axis, i).line != line; });
    }
  }

 private:
  using Lines = std::pair<int, int>;  // along x and z

  Place& on(LineAxis axis, int station) {
    return places_[static_cast<std::size_t>(station)][axis == LineAxis::kX ? 0 : 1];
  }
  bool is_shared(int station) {
    return on(LineAxis::kX, station).line != kNone && on(LineAxis::kZ, station).line != kNone;
  }

  void find_places() {
    places_.assign(points_.size(), {});
    for (std::size_t index = 0; index < lines_.size(); ++index) {
      const auto& [line, stations] = lines_[index];
      std::vector<double> gaps_m;
      for (std::size_t i = 1; i < stations.size(); ++i) {
        gaps_m.push_back(line.along(point(stations[i])) - line.along(point(stations[i - 1])));
      }
      const double spacing_m =
          std::max(covering_spacing(gaps_m), std::numeric_limits<double>::min());
      for (std::size_t i = 0; i < stations.size(); ++i) {
        Place& here = on(line.axis, stations[i]);
        here.line = static_cast<int>(index);
        if (i > 0) here.before = gaps_m[i - 1] / spacing_m;
        if (i < gaps_m.size()) here.after = gaps_m[i] / spacing_m;
      }
    }
  }

  // Where a station is far beyond the end of one of its lines, it is of the other.
  void find_intersections() {
    intersections_.clear();
    for (int station = 0; station < static_cast<int>(points_.size()); ++station) {
      if (!is_shared(station)) continue;
      Place &x = on(LineAxis::kX, station), &z = on(LineAxis::kZ, station);
      if (x.is_near() == z.is_near()) {
        intersections_[{x.line, z.line}].push_back(station);
      } else {
        (x.is_near() ? z : x).line = kNone;
      }
    }
  }

  bool drop_chance_rows() {
    std::vector<int> own(lines_.size() + 1);  // the last: of no line
    const auto count = [&](int line) { ++own[line == kNone ? lines_.size() : std::size_t(line)]; };
    for (int station = 0; station < static_cast<int>(points_.size()); ++station) {
      if (is_shared(station)) continue;
      count(on(LineAxis::kX, station).line);
      count(on(LineAxis::kZ, station).line);
    }
    for (const auto& [lines, stations] : intersections_) {
      if (stations.size() < 2) continue;
      count(lines.first);
      count(lines.second);
    }
    auto next = own.begin();
    return std::erase_if(lines_, [&](const LineGroup&) { return *next++ < 2; }) > 0;
  }

  void decide(const Lines& lines, std::vector<int> stations) {
    if (stations.size() == 1) {
      Place &x = on(LineAxis::kX, stations[0]), &z = on(LineAxis::kZ, stations[0]);
      left_.push_back(z.loss() > x.loss(kOffPlaceShare) ? &x : &z);
      return;
    }
    std::map<int, std::pair<int, double>> less_x;  // by the list, then by distance
    for (const int i : stations) {
      less_x[i] = {-neighbours_on_x(i, lines), line(lines.first).distance_to(point(i)) -
                                                   line(lines.second).distance_to(point(i))};
    }
    std::ranges::stable_sort(stations, {}, [&](int i) { return less_x[i]; });
    auto of_x = std::ranges::count_if(stations, [&](int i) {
      return less_x[i].first != 0 ? less_x[i].first < 0 : less_x[i].second <= 0.0;
    });
    if (has_twins(stations)) of_x = std::clamp<std::ptrdiff_t>(of_x, 1, std::ssize(stations) - 1);
    for (std::ptrdiff_t i = 0; i < std::ssize(stations); ++i) {
      const LineAxis other = i < of_x ? LineAxis::kZ : LineAxis::kX;
      left_.push_back(&on(other, stations[static_cast<std::size_t>(i)]));
    }
  }

  // How many more of a station's neighbours in the list are on the line along x than on the other.
  int neighbours_on_x(int station, const Lines& lines) {
    int more = 0;
    for (const int step : {-1, 1}) {
      int other = station + step;
      const auto is_listed = [&] { return other >= 0 && other < std::ssize(points_); };
      while (is_listed() && is_shared(other)) other += step;
      if (!is_listed()) continue;
      if (on(LineAxis::kX, other).line == lines.first) ++more;
      if (on(LineAxis::kZ, other).line == lines.second) --more;
    }
    return more;
  }

  bool has_twins(const std::vector<int>& stations) const {
    for (auto a = stations.begin(); a != stations.end(); ++a) {
      if (std::any_of(a + 1, stations.end(),
                      [&](int b) { return (point(*a) - point(b)).norm() <= twin_m_; })) {
        return true;
      }
    }
    return false;
  }

  const Eigen::Vector2d& point(int station) const {
    return points_[static_cast<std::size_t>(station)];
  }
  const PlanLine& line(int index) const { return lines_[static_cast<std::size_t>(index)].line; }

  std::span<const Eigen::Vector2d> points_;
  double twin_m_;
  std::vector<LineGroup>& lines_;
  std::vector<std::array<Place, 2>> places_;  // of each station along x and z
  std::map<Lines, std::vector<int>> intersections_;
  std::vector<Place*> left_;  // decided against
};

}  // namespace

void share_out_intersections(std::span<const Eigen::Vector2d> points, double twin_m,
                             std::vector<LineGroup>* lines) {
  Sharing(points, twin_m, lines).run();
}

}  // namespace raywalk
