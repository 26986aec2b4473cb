#include "build_lf/refine/refine_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/room/kept_stations.h"

namespace raywalk::build_lf {
namespace {

int count_of(const KeptStations& kept) {
  std::size_t count = 0;
  for (const auto& line : kept) count += line.size();
  return static_cast<int>(count);
}

double longest_line_m(const Grid& grid) {
  double longest_m = 0.0;
  for (const Line& line : grid.lines)
    longest_m = std::max(longest_m, line.last_m() - line.first_m());
  return longest_m;
}

KeptStations with_maps(const Room& room) {
  constexpr std::size_t kFewest = 2;
  KeptStations kept = needed_stations(room, std::numeric_limits<double>::infinity());
  for (std::size_t line = 0; line < kept.size(); ++line) {
    const auto maps = room.distances(static_cast<int>(line)).stations();
    if (maps.size() >= kFewest) kept[line].assign(maps.begin(), maps.end());
  }
  return kept;
}

}  // namespace

KeptStations stations_to_develop(const Room& room, int stations) {
  const std::size_t captured = all_stations(room.grid()).size();
  if (stations < 0 || stations > static_cast<int>(captured)) {
    throw UsageError(fmt::format("--stations {}: the room has {} stations", stations, captured));
  }
  if (stations == 0) return with_maps(room);
  // The number falls as the spacing grows.
  double narrow_m = 0.0, wide_m = longest_line_m(room.grid());
  KeptStations kept = needed_stations(room, wide_m, Preferred::kWithDistances);
  constexpr int kHalvings = 40;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle_m = 0.5 * (narrow_m + wide_m);
    KeptStations closer = needed_stations(room, middle_m, Preferred::kWithDistances);
    if (count_of(closer) > stations) {
      narrow_m = middle_m;
    } else {
      wide_m = middle_m;
      kept = std::move(closer);
    }
  }
  return kept;
}

int developed_width(PanoramaSize captured, int asked) {
  if (asked == 0) {
    const int most = std::min(2 * captured.width, std::max(captured.width, kUsualWidth));
    return most - most % 4;
  }
  if (asked % 4 != 0 || asked < captured.width || asked > 2 * captured.width) {
    throw UsageError(fmt::format(
        "--width {}: must be a multiple of 4 from {} px, the captured width, to twice that", asked,
        captured.width));
  }
  return asked;
}

std::vector<StationIndex> sources_of(const Grid& grid, StationIndex station, double surfaces_m) {
  const Eigen::Vector3d here_m = grid.station(station).position_m;
  std::vector<std::pair<double, StationIndex>> others;
  for (const StationIndex other : all_stations(grid)) {
    if (other == station) continue;
    others.emplace_back((grid.station(other).position_m - here_m).norm(), other);
  }
  std::ranges::sort(others);
  // Stations of two lines at their intersection are at one place, where nothing is hidden.
  constexpr std::size_t kNear = kMostSources / 2;
  const auto far =
      std::ranges::find_if(others, [&](const auto& other) { return other.first > surfaces_m; });
  const std::size_t within = std::max<std::size_t>(static_cast<std::size_t>(far - others.begin()),
                                                   std::min(kNear, others.size()));
  std::vector<StationIndex> sources;
  for (std::size_t i = 0; i < std::min(kNear, within); ++i) sources.push_back(others[i].second);
  const std::size_t left = within - sources.size();
  const std::size_t spread = std::min(left, kMostSources - kNear);
  for (std::size_t i = 0; i < spread; ++i) {
    sources.push_back(others[kNear + i * left / spread].second);
  }
  return sources;
}

double median_distance_m(std::span<const float> inverse) {
  std::vector<float> known;
  std::ranges::copy_if(inverse, std::back_inserter(known), [](float w) { return w >= 0.0f; });
  if (known.empty()) return std::numeric_limits<double>::infinity();
  const auto middle = known.begin() + std::ssize(known) / 2;
  std::ranges::nth_element(known, middle);
  return 1.0 / static_cast<double>(*middle);
}

}  // namespace raywalk::build_lf
