#include "build_lf/depth/station_pairs.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "core/geometry/line_gaps.h"

namespace raywalk::build_lf {
namespace {

double distance_m(const Station& a, const Station& b) {
  return (a.position_m - b.position_m).norm();
}

int nearest_station(const Line& line, PlanPoint point) {
  const double along_m = along_line(line, point);
  const auto nearer = [&](const Station& a, const Station& b) {
    return std::fabs(a.along_m - along_m) < std::fabs(b.along_m - along_m);
  };
  return static_cast<int>(std::min_element(line.stations.begin(), line.stations.end(), nearer) -
                          line.stations.begin());
}

// The nearest stations at the crossing of two lines, if they are about as close as neighbours on a
// line.
std::optional<StationPair> pair_at_crossing(const Grid& grid, int a, int b) {
  const Line& line_a = grid.lines[static_cast<size_t>(a)];
  const Line& line_b = grid.lines[static_cast<size_t>(b)];
  if (line_a.axis == line_b.axis) return std::nullopt;
  const PlanPoint crossing = crossing_of(line_a, line_b);
  const StationPair pair{{a, nearest_station(line_a, crossing)},
                         {b, nearest_station(line_b, crossing)}};
  constexpr double kSteps = 2.0;
  const double near_m = kSteps * std::max(covering_spacing(line_a), covering_spacing(line_b));
  const double apart_m = distance_m(line_a.stations[static_cast<size_t>(pair.from.station)],
                                    line_b.stations[static_cast<size_t>(pair.to.station)]);
  return apart_m <= near_m ? std::optional(pair) : std::nullopt;
}

StationPair nearest_pair(const Grid& grid, int a, int b) {
  const auto& from = grid.lines[static_cast<size_t>(a)].stations;
  const auto& to = grid.lines[static_cast<size_t>(b)].stations;
  StationPair nearest{{a, 0}, {b, 0}};
  double least_m = distance_m(from[0], to[0]);
  for (size_t i = 0; i < from.size(); ++i) {
    for (size_t j = 0; j < to.size(); ++j) {
      const double apart_m = distance_m(from[i], to[j]);
      if (apart_m >= least_m) continue;
      least_m = apart_m;
      nearest = {{a, static_cast<int>(i)}, {b, static_cast<int>(j)}};
    }
  }
  return nearest;
}

// Connected groups of lines (union-find).
class LineGroups {
 public:
  explicit LineGroups(size_t lines) : group_(lines) { std::iota(group_.begin(), group_.end(), 0); }
  bool connected(int a, int b) const {
    return group_[static_cast<size_t>(a)] == group_[static_cast<size_t>(b)];
  }
  void connect(int a, int b) {
    const int kept = group_[static_cast<size_t>(a)];
    const int dissolved = group_[static_cast<size_t>(b)];
    std::replace(group_.begin(), group_.end(), dissolved, kept);
  }

 private:
  std::vector<int> group_;
};

// Connects groups of lines without a common crossing, nearest first (Kruskal's spanning tree).
void connect_groups(const Grid& grid, LineGroups* groups, std::vector<StationPair>* pairs) {
  std::vector<std::pair<double, StationPair>> offers;
  const int lines = static_cast<int>(grid.lines.size());
  for (int a = 0; a < lines; ++a) {
    for (int b = a + 1; b < lines; ++b) {
      if (groups->connected(a, b)) continue;
      const StationPair pair = nearest_pair(grid, a, b);
      offers.emplace_back(
          distance_m(
              grid.lines[static_cast<size_t>(a)].stations[static_cast<size_t>(pair.from.station)],
              grid.lines[static_cast<size_t>(b)].stations[static_cast<size_t>(pair.to.station)]),
          pair);
    }
  }
  std::stable_sort(offers.begin(), offers.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [apart_m, pair] : offers) {
    if (groups->connected(pair.from.line, pair.to.line)) continue;
    groups->connect(pair.from.line, pair.to.line);
    pairs->push_back(pair);
  }
}

}  // namespace

std::vector<StationPair> pairs_to_compare(const Grid& grid) {
  std::vector<StationPair> pairs;
  const int lines = static_cast<int>(grid.lines.size());
  for (int line = 0; line < lines; ++line) {
    const int stations = static_cast<int>(grid.lines[static_cast<size_t>(line)].stations.size());
    for (int i = 0; i < stations; ++i) {
      for (int j = i + 1; j < std::min(i + 3, stations); ++j) {
        pairs.push_back({{line, i}, {line, j}});
      }
    }
  }
  LineGroups groups(grid.lines.size());
  for (int a = 0; a < lines; ++a) {
    for (int b = a + 1; b < lines; ++b) {
      if (const auto pair = pair_at_crossing(grid, a, b)) {
        pairs.push_back(*pair);
        groups.connect(a, b);
      }
    }
  }
  connect_groups(grid, &groups, &pairs);
  return pairs;
}

}  // namespace raywalk::build_lf
