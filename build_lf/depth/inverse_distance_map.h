// A distance map in the making: inverse distances of one station, in world axes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {

// A station by its indices in Grid::lines and Line::stations.
struct StationIndex {
  int line = 0;
  int station = 0;
  friend bool operator==(StationIndex, StationIndex) = default;
  friend bool operator<(StationIndex a, StationIndex b) {
    return std::pair(a.line, a.station) < std::pair(b.line, b.station);
  }
};

// Omega is the inverse distance along the ray, 1/m: 0 is infinitely far. Parallax is proportional
// to it, so errors in it are what a rendered view shows.
struct InverseDistanceMap {
  StationIndex station;
  Eigen::Vector3d position_m{0, 0, 0};
  PanoramaSize size;
  std::vector<float> omega;              // [theta][phi], 0 or larger
  std::vector<std::uint8_t> confidence;  // [theta][phi], 0 unknown to 255 certain
};

}  // namespace raywalk
