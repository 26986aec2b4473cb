// Samples of a room's known distances, for statistics of the scene.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

struct DistanceSample {
  float distance_m = 0.0f;  // from the station, along the ray; +inf: no surface
  float weight = 0.0f;      // solid angle (cos phi) times confidence in [0, 1]; > 0
  float theta_rad = 0.0f;   // direction in world axes
  float phi_rad = 0.0f;
};

struct DistanceSamples {
  std::vector<DistanceSample> samples{};
  double known_share = 0.0;  // of the solid angle of all maps, weighted by confidence
};

// The number of a room's distance maps.
std::size_t map_count(const Room& room);

// About `per_map` pixels of every distance map, spread evenly over rows and columns. Pixels with
// confidence 0 or an invalid distance (0, negative, NaN) count as unknown. Empty if the room has no
// maps.
DistanceSamples sample_distances(const Room& room, int per_map);

// The weighted quantiles of the distances, metres, for `shares` in [0, 1]. Sorts the samples. NaN
// if there are none.
std::vector<double> distance_quantiles(std::span<DistanceSample> samples,
                                       std::span<const double> shares);

}  // namespace raywalk
