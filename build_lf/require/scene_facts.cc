#include "build_lf/require/scene_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "build_lf/require/distance_error.h"
#include "core/base/error.h"
#include "core/room/distance_samples.h"

namespace raywalk::build_lf {
namespace {

constexpr int kColumns = static_cast<int>(360.0 / kFieldDeg);
constexpr int kRows = static_cast<int>(180.0 / kFieldDeg);
constexpr int kMaxSamples = 2'000'000;  // 32 MB
constexpr int kMaxSamplesPerMap = 16384;
constexpr std::array kShares{0.01, 0.5, 0.99};
// In units of the reach N/2: from close to the line to the diagonal of a cell.
constexpr std::array kReaches{0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 2.8284271247461903};

double sky_share(std::span<const DistanceSample> samples) {
  double sky = 0.0, all = 0.0;
  for (const DistanceSample& sample : samples) {
    all += sample.weight;
    if (std::isinf(sample.distance_m)) sky += sample.weight;
  }
  return sky / all;
}

int field_of(const DistanceSample& sample) {
  const auto index = [](double angle_rad, double first_deg, int count) {
    const double field = (degrees_from_radians(angle_rad) - first_deg) / kFieldDeg;
    return std::clamp(static_cast<int>(std::floor(field)), 0, count - 1);
  };
  return index(sample.phi_rad, -90.0, kRows) * kColumns + index(sample.theta_rad, -180.0, kColumns);
}

DirectionRange range_of(int field, std::span<DistanceSample> samples) {
  const std::vector<double> quantiles = distance_quantiles(samples, kShares);
  const int row = field / kColumns;
  return {.longitude_deg = (field % kColumns + 0.5) * kFieldDeg - 180.0,
          .latitude_deg = (row + 0.5) * kFieldDeg - 90.0,
          .near_m = quantiles[0],
          .median_m = quantiles[1],
          .far_m = quantiles[2],
          .sky_share = sky_share(samples)};
}

std::vector<DirectionRange> directions(std::span<DistanceSample> samples) {
  std::ranges::sort(samples, {}, field_of);
  std::vector<DirectionRange> ranges;
  for (size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    const int field = field_of(samples[begin]);
    while (end < samples.size() && field_of(samples[end]) == field) ++end;
    ranges.push_back(range_of(field, samples.subspan(begin, end - begin)));
  }
  return ranges;
}

double inverse(double distance_m) { return 1.0 / distance_m; }  // 0 for the sky

}  // namespace

DistanceFacts distance_facts(const Room& room) {
  const int per_map = std::clamp(kMaxSamples / std::max(1, static_cast<int>(map_count(room))), 256,
                                 kMaxSamplesPerMap);
  DistanceSamples known = sample_distances(room, per_map);
  if (known.samples.empty()) {
    throw Error(
        fmt::format("{}: the room has no known distances to measure; run raywalk-build-lf depth "
                    "on it, or pack it with raywalk-build-lf pack --distance DIR",
                    room.directory().string()));
  }
  DistanceFacts facts;
  facts.directions = directions(known.samples);
  const std::vector<double> quantiles = distance_quantiles(known.samples, kShares);
  facts.near_m = quantiles[0];
  facts.median_m = quantiles[1];
  facts.far_m = quantiles[2];
  facts.sky_share = sky_share(known.samples);
  facts.known_share = known.known_share;
  facts.omega_error_per_m = omega_error(room);
  return facts;
}

double typical_reach_m(const Grid& grid) {
  double side_m = std::numeric_limits<double>::infinity();
  for (const Cell& cell : grid.cells) {
    side_m = std::min({side_m, cell.x_max_m - cell.x_min_m, cell.z_max_m - cell.z_min_m});
  }
  if (grid.cells.empty()) {
    side_m = 0.0;
    for (const Line& line : grid.lines) side_m = std::max(side_m, line.last_m() - line.first_m());
  }
  return 0.5 * side_m;
}

LayerFacts layer_facts(const DistanceFacts& distance, double reach_m, double tolerance_rad) {
  LayerFacts facts{inverse(distance.far_m), inverse(distance.near_m), {}};
  for (const double reach : kReaches) {
    const double d_p_m = reach * reach_m;
    facts.by_d_p.push_back({d_p_m, layers_for_tolerance(facts.range(), d_p_m, tolerance_rad)});
  }
  return facts;
}

}  // namespace raywalk::build_lf
