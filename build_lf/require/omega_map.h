// Inverse distances in every direction from one place, and how they are carried to another place.
// The inverse omega = 1 / d is what pictures move by: it is 0 for the sky, and on a plane it is
// linear in the direction's components, so that it can be interpolated.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/room/room.h"

namespace raywalk::build_lf {

class OmegaMap {
 public:
  // Nothing is known.
  explicit OmegaMap(PanoramaSize size)
      : size_(size),
        omega_(static_cast<size_t>(size.width) * static_cast<size_t>(size.height), -1.0f) {}

  PanoramaSize size() const { return size_; }
  // 1/m, at least 0; negative where it is not known. Column theta in [0, width), row in
  // [0, height).
  float at(int theta, int row) const { return omega_[index(theta, row)]; }
  float& at(int theta, int row) { return omega_[index(theta, row)]; }

  // Interpolated over the neighbours that show the same surface as the nearest pixel; negative
  // where that one is unknown.
  float sample(PixelPosition pixel) const;

  // Two inverse distances of neighbouring pixels that differ by no more than this, relative to the
  // larger, count as one surface: the change across one pixel of a plane seen at 80 deg incidence.
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

// The same map sampled at another width.
OmegaMap resized(const OmegaMap& map, int width);

// A map and where it was captured.
struct PlacedMap {
  const OmegaMap* map = nullptr;
  Eigen::Vector3d position_m{0, 0, 0};
};

// How a point looks from another place: its direction there and its inverse distance. The point is
// in the unit direction `direction` at inverse distance `omega` from a place that lies at
// `offset_m` from the other one.
struct SeenPoint {
  SphereAngles angles{};
  float omega = 0.0f;
};
SeenPoint seen_from(const Eigen::Vector3d& direction, float omega, const Eigen::Vector3d& offset_m);

// What `position_m` sees, by the maps around it: all points of the maps are projected there, the
// nearest surface wins, and each pixel is then looked up again in the first map that agrees, so
// that the result is not rounded to pixels. Directions no map sees take the farther of the
// surfaces beside them along the row, as what a near object hides is background. Rows of which no
// map sees anything stay unknown: all of them where there are no maps.
OmegaMap projected(std::span<const PlacedMap> maps, const Eigen::Vector3d& position_m, int width);

}  // namespace raywalk::build_lf
