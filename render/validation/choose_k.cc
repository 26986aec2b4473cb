#include "render/validation/choose_k.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/geometry/connection_error.h"
#include "core/geometry/grid.h"
#include "render/validation/connect_error_file.h"

namespace raywalk {
namespace {

// The optimum hardly depends on how many distances are summed over (5 and 33 quantiles of a box
// room give the same), while every one takes its time.
constexpr int kModelDistances = 5;
constexpr int kSamplesPerMap = 1024;  // of a map's columns and of its rows together

// Measurements to go by, the best first.
std::vector<Generation> measurements_for(Generation generation) {
  switch (generation) {
    case Generation::kInitial:
      return {Generation::kInitial};
    case Generation::kHlfVd:
      return {Generation::kHlfVd, Generation::kTwoSided, Generation::kInitial};
    case Generation::kTwoSided:
      return {Generation::kTwoSided, Generation::kHlfVd, Generation::kInitial};
  }
  return {};
}

// None where nothing could be read at any k.
std::optional<double> least_k_deg(const ConnectError& measurement) {
  const ConnectErrorRow* best = nullptr;
  for (const ConnectErrorRow& row : measurement.rows) {
    if (std::isnan(row.e_connect)) continue;
    const bool better = best == nullptr || row.e_connect < best->e_connect ||
                        (row.e_connect == best->e_connect && row.k_deg > best->k_deg);
    if (better) best = &row;
  }
  return best == nullptr ? std::nullopt : std::optional(best->k_deg);
}

std::optional<AutoK> measured_k(const Room& room, Generation generation) {
  const std::vector<ConnectError> measurements = read_connect_error(room.directory());
  for (const Generation wanted : measurements_for(generation)) {
    for (const ConnectError& measurement : measurements) {
      if (measurement.generation != wanted) continue;
      if (const auto k_deg = least_k_deg(measurement)) {
        return AutoK{*k_deg, "measured E_connect of " + generation_name(wanted) + " views"};
      }
    }
  }
  return std::nullopt;
}

struct WeightedDistance {
  double distance_m = 0.0;
  double weight = 0.0;  // solid angle
};

void add_samples(const DistanceVolume& volume, int map, std::vector<WeightedDistance>* samples) {
  const PanoramaSize size = volume.size();
  const int stride =
      std::max(1, static_cast<int>(std::lround(
                      std::sqrt(size.width * static_cast<double>(size.height) / kSamplesPerMap))));
  for (int theta = stride / 2; theta < size.width; theta += stride) {
    const auto distances_m = volume.distance_column(map, theta);
    const auto confidence = volume.confidence_column(map, theta);
    for (int row = stride / 2; row < size.height; row += stride) {
      const auto i = static_cast<size_t>(row);
      if (confidence[i] == 0 || !(distances_m[i] >= 0.0f)) continue;
      const double phi_rad = angles_from_pixel({0.0, static_cast<double>(row)}, size).phi_rad;
      samples->push_back({distances_m[i], std::cos(phi_rad)});
    }
  }
}

// `count` distances, each standing for as much solid angle of the room's maps; empty without maps.
std::vector<double> distance_quantiles(const Room& room, int count) {
  std::vector<WeightedDistance> samples;
  for (int line = 0; line < static_cast<int>(room.grid().lines.size()); ++line) {
    const DistanceVolume& volume = room.distances(line);
    for (int map = 0; map < volume.maps(); ++map) add_samples(volume, map, &samples);
  }
  std::ranges::sort(samples, {}, &WeightedDistance::distance_m);
  double total = 0.0;
  for (const WeightedDistance& sample : samples) total += sample.weight;
  std::vector<double> quantiles_m;
  double passed = 0.0;
  for (const WeightedDistance& sample : samples) {
    passed += sample.weight;
    // The middle of each of `count` equal parts.
    while (static_cast<int>(quantiles_m.size()) < count &&
           passed >= total * (static_cast<double>(quantiles_m.size()) + 0.5) / count) {
      quantiles_m.push_back(sample.distance_m);
    }
  }
  return quantiles_m;
}

double mean_side_m(const Grid& grid) {
  double sum_m = 0.0;
  for (const Cell& cell : grid.cells) {
    sum_m += 0.5 * (cell.x_max_m - cell.x_min_m + cell.z_max_m - cell.z_min_m);
  }
  return sum_m / static_cast<double>(grid.cells.size());
}

double median_step_m(const Grid& grid) {
  std::vector<double> steps_m;
  for (const Line& line : grid.lines) steps_m.push_back(median_spacing_m(line));
  return median(std::move(steps_m));
}

}  // namespace

AutoK auto_k_deg(const Room& room, Generation generation) {
  if (room.grid().cells.empty()) return {90.0, "the room has no connections"};
  if (const auto measured = measured_k(room, generation)) return *measured;
  const CellSampling sampling{.side_m = mean_side_m(room.grid()),
                              .step_m = median_step_m(room.grid())};
  std::vector<double> distances_m = distance_quantiles(room, kModelDistances);
  std::string source = "model E_t over the room's distances";
  if (distances_m.empty()) {
    distances_m.push_back(1.5 * sampling.side_m);
    source = "model E_t at 1.5 N";
  }
  return {static_cast<double>(connection_error_curve(sampling, distances_m).optimum_k_deg), source};
}

}  // namespace raywalk
