// Maps of inverse distances at other widths. Parallax is proportional to omega = 1 / d. It is 0 for
// the sky, and on a plane it is linear in the direction's components, so that it can be
// interpolated.
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

class OmegaMap {
 public:
  // All pixels unknown.
  explicit OmegaMap(PanoramaSize size)
      : size_(size),
        omega_(static_cast<size_t>(size.width) * static_cast<size_t>(size.height), -1.0f) {}

  PanoramaSize size() const { return size_; }
  // 1/m, at least 0; negative if unknown. Column theta in [0, width), row in [0, height).
  float at(int theta, int row) const { return omega_[index(theta, row)]; }
  float& at(int theta, int row) { return omega_[index(theta, row)]; }
  // All of them, [theta][row].
  std::span<const float> values() const { return omega_; }
  std::span<float> values() { return omega_; }

  // Bilinear interpolation over the neighbours on the same surface as the nearest pixel; negative
  // if that pixel is unknown.
  float sample(PixelPosition pixel) const;

 private:
  size_t index(int theta, int row) const {
    return static_cast<size_t>(theta) * static_cast<size_t>(size_.height) +
           static_cast<size_t>(row);
  }

  PanoramaSize size_;
  std::vector<float> omega_;  // [theta][phi]
};

// A distance map of a room as inverse distances. Pixels below a confidence (at least 1) are
// unknown.
OmegaMap omega_map_of(const DistanceVolume& volume, int map, std::uint8_t least_confidence = 1);

// The map resampled at another width.
OmegaMap resized(const OmegaMap& map, int width);

}  // namespace raywalk
