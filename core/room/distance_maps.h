// What is made of a room's distance maps: maps of inverse distances at other widths, and samples
// for statistics of the scene.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/room/room.h"

namespace raywalk {

// Neighbouring pixels of distances of this width are on one surface where their inverse distances
// differ by no more than this, relative to the larger: the change across one pixel of a plane seen
// at 80 degrees incidence, at most a quarter.
float surface_tolerance_of(int width);

// Inverse distances 1 / d: parallax is proportional to them, they are 0 for the sky, and
// on a plane they are linear in the direction's components, so that they can be interpolated.
class InverseMap {
 public:
  // All pixels unknown.
  explicit InverseMap(PanoramaSize size)
      : size_(size),
        inverse_(static_cast<size_t>(size.width) * static_cast<size_t>(size.height), -1.0f) {}

  PanoramaSize size() const { return size_; }
  // 1/m, at least 0; negative if unknown. Column theta in [0, width), row in [0, height).
  float at(int theta, int row) const { return inverse_[index(theta, row)]; }
  float& at(int theta, int row) { return inverse_[index(theta, row)]; }
  // All of them, [theta][row].
  std::span<const float> values() const { return inverse_; }
  std::span<float> values() { return inverse_; }

  // Bilinear interpolation over the neighbours on the same surface as the nearest pixel; negative
  // if that pixel is unknown.
  float sample(PixelPosition pixel) const;

 private:
  size_t index(int theta, int row) const {
    return static_cast<size_t>(theta) * static_cast<size_t>(size_.height) +
           static_cast<size_t>(row);
  }

  PanoramaSize size_;
  std::vector<float> inverse_;  // [theta][phi]
};

// A distance map of a room as inverse distances. Pixels below a confidence (at least 1) are
// unknown.
InverseMap inverse_map_of(const DistanceVolume& volume, int map, std::uint8_t least_confidence = 1);

// The map resampled at another width.
InverseMap resized(const InverseMap& map, int width);

struct DistanceSample {
  float distance_m = 0.0f;  // from the station, along the ray; +inf: no surface
  float weight = 0.0f;      // solid angle (cos phi) times confidence in [0, 1]; > 0
};

struct DistanceSamples {
  std::vector<DistanceSample> samples{};
  double known_share = 0.0;  // of the solid angle of all maps, weighted by confidence
};

// About `per_map` pixels of every distance map, spread evenly over rows and columns. Pixels with
// confidence 0 or an invalid distance (0, negative, NaN) count as unknown. Empty if the room has no
// maps.
DistanceSamples sample_distances(const Room& room, int per_map);

// The weighted quantiles of the distances, metres, for `shares` in [0, 1]. Sorts the samples. NaN
// if there are none.
std::vector<double> distance_quantiles(std::span<DistanceSample> samples,
                                       std::span<const double> shares);

}  // namespace raywalk
