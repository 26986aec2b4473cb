#include "build_lf/require/held_out.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace raywalk::build_lf {
namespace {

constexpr int kMapsPerStation = 2;
constexpr int kViewsPerStride = 12;
// Width of the compared pixels and of the distances: enough to measure the effect of a station.
constexpr int kWidth = 512;

struct MapIndex {
  int line = 0;
  int map = 0;
  double distance_m = 0.0;
};

Eigen::Vector3d position_of(const Room& room, int line, int station) {
  return room.grid()
      .lines[static_cast<size_t>(line)]
      .stations[static_cast<size_t>(station)]
      .position_m;
}

// The maps of a room nearest to a position, without those captured at `left_out_m`.
std::vector<MapIndex> nearest_maps(const Room& room, const Eigen::Vector3d& position_m,
                                   const Eigen::Vector3d& left_out_m) {
  std::vector<MapIndex> maps;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const auto stations = room.distances(line).stations();
    for (int map = 0; map < static_cast<int>(stations.size()); ++map) {
      const int station = stations[static_cast<size_t>(map)];
      const Eigen::Vector3d captured_m = position_of(room, line, station);
      if (captured_m == left_out_m) continue;
      maps.push_back({line, map, (captured_m - position_m).norm()});
    }
  }
  const auto count = std::min<std::ptrdiff_t>(kMapsPerStation, std::ssize(maps));
  std::ranges::partial_sort(maps, maps.begin() + count, {}, &MapIndex::distance_m);
  maps.resize(static_cast<size_t>(count));
  return maps;
}

// The inverse distances seen from a position, projected from the maps around it.
OmegaMap omega_at(const Room& room, const Eigen::Vector3d& position_m,
                  const Eigen::Vector3d& left_out_m, int width) {
  std::vector<OmegaMap> maps;
  std::vector<PlacedMap> placed;
  maps.reserve(kMapsPerStation);
  for (const MapIndex& index : nearest_maps(room, position_m, left_out_m)) {
    const DistanceVolume& volume = room.distances(index.line);
    OmegaMap map = omega_map_of(volume, index.map);
    maps.push_back(map.size().width > kWidth ? resized(map, kWidth) : std::move(map));
    const int station = volume.stations()[static_cast<size_t>(index.map)];
    placed.push_back({&maps.back(), position_of(room, index.line, station)});
  }
  return projected(placed, position_m, width);
}

RecreationScore recreate(const Room& room, const Room& distances, const HeldOutStation& held_out,
                         double tolerance_px) {
  const std::array stations{held_out.station, held_out.left, held_out.right};
  const auto place = [&](int station) { return position_of(room, held_out.line, station); };
  const int width = std::min(kWidth, room.panorama().width);
  std::vector<OmegaMap> omega;
  omega.reserve(stations.size());
  for (const int station : stations) {
    omega.push_back(omega_at(distances, place(station), place(held_out.station), width));
  }
  const auto view = [&](size_t i) {
    return StationView{&room.volume(held_out.line), stations[i], place(stations[i]), &omega[i]};
  };
  return score_recreation(view(0), view(1), view(2), tolerance_px, kWidth);
}

// 2, 3, 4, 6, 8, 12, 16, ...
std::vector<int> strides_up_to(int longest) {
  std::vector<int> strides;
  for (int power = 2; power <= longest; power *= 2) {
    strides.push_back(power);
    if (power + power / 2 <= longest) strides.push_back(power + power / 2);
  }
  return strides;
}

// The middle stations of a stride's gaps, and the width of each gap.
std::vector<HeldOutStation> middles(const Grid& grid, int stride, std::vector<double>* steps_m) {
  std::vector<HeldOutStation> found;
  for (int line = 0; line < static_cast<int>(grid.lines.size()); ++line) {
    const std::vector<Station>& stations = grid.lines[static_cast<size_t>(line)].stations;
    for (int left = 0; left + stride < static_cast<int>(stations.size()); left += stride) {
      const int right = left + stride;
      found.push_back({line, left + stride / 2, left, right});
      steps_m->push_back(stations[static_cast<size_t>(right)].along_m -
                         stations[static_cast<size_t>(left)].along_m);
    }
  }
  return found;
}

HeldOutFacts facts_of(int stride, double step_m, std::span<const RecreationScore> scores) {
  HeldOutFacts facts{.stride = stride, .step_m = step_m, .views = static_cast<int>(scores.size())};
  const double part = 1.0 / static_cast<double>(scores.size());
  for (const RecreationScore& score : scores) {
    facts.psnr_with_distances_db += part * score.psnr_with_distances_db;
    facts.psnr_without_depth_db += part * score.psnr_without_depth_db;
    facts.psnr_of_tolerance_db += part * score.psnr_of_tolerance_db;
    facts.hidden_share += part * score.hidden_share;
  }
  return facts;
}

}  // namespace

std::vector<RecreationScore> recreate_stations(const Room& room, const Room& distances,
                                               std::span<const HeldOutStation> stations,
                                               double tolerance_px) {
  std::vector<RecreationScore> scores(stations.size());
  Progress progress("re-creating", std::ssize(stations), "stations");
  parallel_for(0, static_cast<int>(stations.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const auto index = static_cast<size_t>(i);
      scores[index] = recreate(room, distances, stations[index], tolerance_px);
      progress.advance();
    }
  });
  return scores;
}

std::vector<HeldOutStation> pick_evenly(std::span<const HeldOutStation> stations, int count) {
  if (std::ssize(stations) <= count) return {stations.begin(), stations.end()};
  std::vector<HeldOutStation> chosen;
  chosen.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    chosen.push_back(stations[static_cast<size_t>((i + 0.5) * double(stations.size()) / count)]);
  }
  return chosen;
}

std::vector<HeldOutFacts> measure_strides(const Room& room, double tolerance_px) {
  int longest = 0;
  for (const Line& line : room.grid().lines) {
    longest = std::max(longest, static_cast<int>(line.stations.size()) - 1);
  }
  const std::vector<int> strides = strides_up_to(longest);
  std::vector<HeldOutStation> all;
  std::vector<size_t> first;  // of each stride in `all`
  std::vector<double> step_m;
  for (const int stride : strides) {
    std::vector<double> steps_m;
    const auto views = pick_evenly(middles(room.grid(), stride, &steps_m), kViewsPerStride);
    first.push_back(all.size());
    step_m.push_back(median(steps_m));
    all.insert(all.end(), views.begin(), views.end());
  }
  first.push_back(all.size());
  const auto scores = recreate_stations(room, room, all, tolerance_px);
  std::vector<HeldOutFacts> facts;
  for (size_t i = 0; i < strides.size(); ++i) {
    facts.push_back(facts_of(strides[i], step_m[i],
                             std::span(scores).subspan(first[i], first[i + 1] - first[i])));
  }
  return facts;
}

double measured_up_to_m(std::span<const HeldOutFacts> strides) {
  double step_m = 0.0;
  for (const HeldOutFacts& facts : strides) {
    if (facts.psnr_with_distances_db < facts.psnr_of_tolerance_db) break;
    step_m = facts.step_m;
  }
  return step_m;
}

}  // namespace raywalk::build_lf
