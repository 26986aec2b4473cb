// Maps of inverse distances, and their projection to another position. Parallax is proportional to
// omega = 1 / d. It is 0 for the sky, and on a plane it is linear in the direction's components, so
// that it can be interpolated.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/room/room.h"

namespace raywalk::build_lf {

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

  // Bilinear interpolation over the neighbours on the same surface as the nearest pixel; negative
  // if that pixel is unknown.
  float sample(PixelPosition pixel) const;

  // Neighbouring pixels are on the same surface if their inverse distances differ by at most this,
  // relative to the larger: the change across one pixel of a plane seen at 80 deg incidence.
  float surface_tolerance() const;

 private:
  size_t index(int theta, int row) const {
    return static_cast<size_t>(theta) * static_cast<size_t>(size_.height) +
           static_cast<size_t>(row);
  }

  PanoramaSize size_;
  std::vector<float> omega_;  // [theta][phi]
};

// A distance map of a room as inverse distances. Pixels of confidence 0 are unknown.
OmegaMap omega_map_of(const DistanceVolume& volume, int map);

// The map resampled at another width.
OmegaMap resized(const OmegaMap& map, int width);

// A map and its position.
struct PlacedMap {
  const OmegaMap* map = nullptr;
  Eigen::Vector3d position_m{0, 0, 0};
};

// The direction and inverse distance, 1/m, of a point seen from another position. The point lies in
// the unit direction `direction` at inverse distance `omega` from a position that is at `offset_m`
// relative to the other one.
struct SeenPoint {
  SphereAngles angles{};
  float omega = 0.0f;
};
SeenPoint seen_from(const Eigen::Vector3d& direction, float omega, const Eigen::Vector3d& offset_m);

// The map seen from `position_m`, forward-projected from the maps around it. The nearest surface
// wins (z-buffer); each pixel is then looked up again in the first map that agrees, to avoid
// rounding to pixels. Holes take the farther of the neighbouring surfaces in their row, as occluded
// surfaces are background. Rows seen by no map stay unknown, which is all rows if there are no
// maps.
OmegaMap projected(std::span<const PlacedMap> maps, const Eigen::Vector3d& position_m, int width);

}  // namespace raywalk::build_lf
