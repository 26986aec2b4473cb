#include "build_lf/depth/depth_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "build_lf/depth/nearest_maps.h"
#include "core/base/error.h"
#include "core/files/words.h"
#include "core/geometry/position_tolerance.h"

namespace raywalk::build_lf {
namespace {

constexpr int kWidestMap = 1024;
constexpr int kNarrowestMap = 32;
// Spacing of the maps as a share of the reach. Views interpolate between maps; surfaces that
// neither sees are seen from other lines.
constexpr double kMapGap = 0.4;
constexpr double kCandidateGap = 0.1;
constexpr int kOwnVoters = 4;
constexpr int kOtherVoters = 8;

// The median distance between neighbours on the lines.
double median_gap_m(const Grid& grid) {
  std::vector<double> gaps_m;
  for (const Line& line : grid.lines) {
    for (size_t i = 1; i < line.stations.size(); ++i) {
      gaps_m.push_back(line.stations[i].along_m - line.stations[i - 1].along_m);
    }
  }
  if (gaps_m.empty()) return 0.0;
  const auto middle = gaps_m.begin() + static_cast<std::ptrdiff_t>(gaps_m.size() / 2);
  std::nth_element(gaps_m.begin(), middle, gaps_m.end());
  return *middle;
}

double reach_of(const Grid& grid, double surfaces_m) {
  double reach = std::numeric_limits<double>::infinity();
  for (const Cell& cell : grid.cells) {
    reach =
        std::min({reach, 0.5 * (cell.x_max_m - cell.x_min_m), 0.5 * (cell.z_max_m - cell.z_min_m)});
  }
  if (!grid.cells.empty()) return reach;
  double longest = 0.0;
  for (const Line& line : grid.lines) longest = std::max(longest, line.last_m() - line.first_m());
  // What two stations see of a surface from directions farther apart differs too much to compare.
  const double most = std::tan(radians_from_degrees(30.0));
  return std::min(0.25 * longest, std::max(most * surfaces_m, median_gap_m(grid)));
}

// The sweep starts at a quarter of the width, of which the height is half.
constexpr int kWidthStep = 4;

PanoramaSize map_size(const Room& room, int width) {
  const int captured = room.panorama().width;
  if (captured < kNarrowestMap) {
    throw Error(
        fmt::format("panoramas of {} x {} are too small to estimate distances; capture at least "
                    "{} x {}",
                    captured, captured / 2, kNarrowestMap, kNarrowestMap / 2));
  }
  if (width == 0) width = std::min(captured, kWidestMap) / kWidthStep * kWidthStep;
  if (width > captured || width % kWidthStep != 0 || width < kNarrowestMap) {
    throw UsageError(fmt::format("--width {}: give a multiple of {} from {} to {}, as captured",
                                 width, kWidthStep, kNarrowestMap, captured));
  }
  return {width, width / 2};
}

// Station indices at least `gap_m` apart, from the first to the last.
std::vector<int> spread_out(const Line& line, double gap_m) {
  const double rounding = rounding_m(line);
  std::vector<int> chosen{0};
  const int last = static_cast<int>(line.stations.size()) - 1;
  const auto along = [&](int i) { return line.stations[static_cast<size_t>(i)].along_m; };
  for (int i = 1; i <= last; ++i) {
    if (along(i) - along(chosen.back()) >= gap_m - rounding) chosen.push_back(i);
  }
  // The end of the line needs a station as much as its beginning.
  if (along(last) - along(chosen.back()) > 0.5 * gap_m) chosen.push_back(last);
  return chosen;
}

std::vector<int> every_nth(const Line& line, int n) {
  std::vector<int> chosen;
  for (int i = 0; i < static_cast<int>(line.stations.size()); i += n) chosen.push_back(i);
  return chosen;
}

// Candidates are ordered by line.
bool some_line_has_two(std::span<const SweepCandidate> candidates) {
  const auto same_line = [](const SweepCandidate& a, const SweepCandidate& b) {
    return a.station.line == b.station.line;
  };
  return std::adjacent_find(candidates.begin(), candidates.end(), same_line) != candidates.end();
}

// All maps, ordered by distance from one of them.
std::vector<int> maps_by_distance(const DepthPlan& plan, int from) {
  const Eigen::Vector3d& from_m = plan.maps[static_cast<size_t>(from)].position_m;
  std::vector<int> order(plan.maps.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return (plan.maps[static_cast<size_t>(a)].position_m - from_m).norm() <
           (plan.maps[static_cast<size_t>(b)].position_m - from_m).norm();
  });
  return order;
}

}  // namespace

DepthMethod depth_method_from_name(const std::string& name) {
  if (name == "sweep") return DepthMethod::kSweep;
  if (name == "flow") return DepthMethod::kFlow;
  throw UsageError(fmt::format("unknown method '{}'; use sweep or flow", name));
}

std::string name_of(DepthMethod method) { return method == DepthMethod::kSweep ? "sweep" : "flow"; }

DepthPlan plan_depth(const Room& room, const DepthOptions& options, double surfaces_m) {
  if (options.every < 0)
    throw UsageError("--every: give 1 or more, or 0 to choose by the cell size");
  const Grid& grid = room.grid();
  DepthPlan plan{map_size(room, options.width), reach_of(grid, surfaces_m), {}, {}};
  for (int l = 0; l < static_cast<int>(grid.lines.size()); ++l) {
    const Line& line = grid.lines[static_cast<size_t>(l)];
    const auto position = [&](int s) { return line.stations[static_cast<size_t>(s)].position_m; };
    const Eigen::Vector3d rail(line.direction.x_m, 0.0, line.direction.z_m);
    const std::vector<int> with_map = options.every > 0 ? every_nth(line, options.every)
                                                        : spread_out(line, kMapGap * plan.reach_m);
    for (const int s : with_map) plan.maps.push_back({{l, s}, position(s), rail});
    for (const int s : spread_out(line, kCandidateGap * plan.reach_m)) {
      plan.candidates.push_back({{l, s}, position(s)});
    }
  }
  return plan;
}

void exclude_stations(std::span<const StationIndex> stations, DepthPlan* plan) {
  const auto is_left_out = [&](const auto& entry) {
    return std::find(stations.begin(), stations.end(), entry.station) != stations.end();
  };
  const std::size_t compared = plan->candidates.size();
  std::erase_if(plan->maps, is_left_out);
  std::erase_if(plan->candidates, is_left_out);
  if (!some_line_has_two(plan->candidates)) {
    throw Error(
        fmt::format("cannot estimate distances: {} of {} stations had to be left out, and no line "
                    "has two left to compare; capture them again",
                    compared - plan->candidates.size(), compared));
  }
  if (plan->maps.empty()) {
    throw Error("all stations selected for maps had to be left out; choose another --every");
  }
}

std::vector<int> voters_of(const DepthPlan& plan, int which) {
  const SweepReference& own = plan.maps[static_cast<size_t>(which)];
  std::vector<int> voters =
      nearest_maps(plan.maps, own.station, own.position_m, kOwnVoters, kOtherVoters);
  voters.insert(voters.begin(), which);
  return voters;
}

std::vector<int> fallback_voters_of(const DepthPlan& plan, std::span<const int> voters) {
  constexpr size_t kMaxFallback = 8;
  constexpr double kGapPerDistance = 0.25;
  std::vector<int> all(voters.begin(), voters.end());
  const auto distance_m = [&](int a, int b) {
    return (plan.maps[static_cast<size_t>(a)].position_m -
            plan.maps[static_cast<size_t>(b)].position_m)
        .norm();
  };
  for (const int i : maps_by_distance(plan, voters.front())) {
    if (all.size() == voters.size() + kMaxFallback) break;
    const double gap_m = kGapPerDistance * distance_m(i, voters.front());
    const bool is_near = std::any_of(all.begin(), all.end(),
                                     [&](int other) { return distance_m(i, other) <= gap_m; });
    if (!is_near && i != voters.front()) all.push_back(i);
  }
  return {all.begin() + static_cast<std::ptrdiff_t>(voters.size()), all.end()};
}

std::vector<SweepCandidate> candidates_near(const DepthPlan& plan,
                                            const SweepReference& reference) {
  std::vector<SweepCandidate> near;
  for (const SweepCandidate& candidate : plan.candidates) {
    const double away = (candidate.position_m - reference.position_m).norm();
    if (candidate.station != reference.station && away <= 3.0 * plan.reach_m) {
      near.push_back(candidate);
    }
  }
  return near;
}

}  // namespace raywalk::build_lf
