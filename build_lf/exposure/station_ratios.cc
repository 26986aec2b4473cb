#include "build_lf/exposure/station_ratios.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <span>

#include "build_lf/depth/nearest_maps.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/base/recently_made.h"

namespace raywalk::build_lf {
namespace {

struct Place {
  StationIndex station;
  Eigen::Vector3d position_m{0, 0, 0};
};

WholeRatio whole_ratio(int from, int to, std::span<const PatchRatio> patches) {
  constexpr double kModelError = 0.005;
  WholeRatio whole{from, to, {}, !patches.empty()};
  if (!whole.known) return whole;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<double> values;
    values.reserve(patches.size());
    for (const PatchRatio& patch : patches) {
      values.push_back(static_cast<double>(patch.log_ratio[c]));
    }
    const double middle = median(values);
    const auto count = static_cast<double>(values.size());
    for (double& value : values) value = std::fabs(value - middle);
    const double error = robust_sigma(std::move(values)) / std::sqrt(count);
    whole.channels[c] = {from, to, middle, std::hypot(error, kModelError)};
  }
  return whole;
}

}  // namespace

void measure_ratios(const Room& room, const SurfaceMaps& maps, StationRatios* ratios) {
  constexpr size_t kOwn = 4;
  constexpr size_t kOthers = 6;
  const std::vector<StationIndex> stations = all_stations(room.grid());
  std::vector<Place> mapped;
  mapped.reserve(maps.stations.size());
  for (const StationIndex s : maps.stations)
    mapped.push_back({s, room.grid().station(s).position_m});
  // Stations after each other are mostly compared with the same ones.
  RecentlyMade<StationIndex, StationSurfaces> surfaces(
      static_cast<size_t>(24 * thread_count()),
      [&](StationIndex station) { return station_surfaces(room, station, maps); });
  const auto count = static_cast<int>(stations.size());
  const int groups = (count + kRatioGroup - 1) / kRatioGroup;
  ratios->patches.resize(static_cast<size_t>(groups));
  std::vector<std::vector<WholeRatio>> whole(static_cast<size_t>(groups));
  Progress progress("comparing surfaces", count, "stations");
  parallel_for(0, groups, 1, [&](int group, int) {
    std::vector<PatchRatio> of_group;
    for (int to = group * kRatioGroup; to < std::min(count, (group + 1) * kRatioGroup); ++to) {
      const StationIndex station = stations[static_cast<size_t>(to)];
      const auto own = surfaces.get(station);
      for (const int partner : nearest_maps(mapped, station, own->position_m, kOwn, kOthers)) {
        const StationIndex other = mapped[static_cast<size_t>(partner)].station;
        const auto from =
            static_cast<int>(std::ranges::lower_bound(stations, other) - stations.begin());
        std::vector<PatchRatio> compared = compare_surfaces(*surfaces.get(other), *own);
        whole[static_cast<size_t>(group)].push_back(whole_ratio(from, to, compared));
        for (PatchRatio& ratio : compared) {
          ratio.from += from * kPatches;
          ratio.to += to * kPatches;
          of_group.push_back(ratio);
        }
      }
      progress.advance();
    }
    ratios->patches[static_cast<size_t>(group)] = {of_group.begin(), of_group.end(),
                                                   &ratios->files};
  });
  for (const std::vector<WholeRatio>& of_group : whole) {
    std::ranges::copy(of_group, std::back_inserter(ratios->whole));
  }
}

}  // namespace raywalk::build_lf
