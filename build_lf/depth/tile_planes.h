// The surfaces that a distance map shows around each of its tiles, as planes.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/pixel_directions.h"

namespace raywalk::build_lf {

// A plane n . X = d around a station, as n / d, 1/m, in world axes: a ray of unit direction u meets
// it at the inverse distance u . (n / d), which is 0 or less where it does not.
using Plane = Eigen::Vector3f;

// Up to three planes around every tile of kPlaneTile x kPlaneTile pixels; the lowest tiles may be
// cut off by the map's end.
//
// Of the confident values around a tile the densest group begins a plane, which is fitted by
// iteratively reweighted least squares (weights of Geman and McClure); what lies on it is put
// aside, and the rest begins the next one. So a tile beside a silhouette has the planes of both
// sides, and they can be carried across it exactly, since u . (n / d) is linear in u.
class TilePlanes {
 public:
  // Values that differ by `pixel_per_m`, 1/m, of inverse distance count as one surface.
  TilePlanes(const InverseDistanceMap& map, double pixel_per_m);

  int columns() const { return columns_; }
  int rows() const { return rows_; }

  // The planes around a tile that differ by over `pixel_per_m` in its middle, at most `most`: those
  // of near tiles, and of many pixels, come first.
  std::vector<Plane> around(int column, int row, std::size_t most) const;

 private:
  struct Fitted {
    Plane plane{0, 0, 0};
    float share = 0.0f;  // of the values around the tile that lie on it
  };
  std::vector<Fitted> fitted(const InverseDistanceMap& map, int column, int row) const;
  std::span<const Fitted> of(int column, int row) const;

  PanoramaSize size_;
  PixelDirections directions_;
  float pixel_per_m_;
  int columns_;
  int rows_;
  std::vector<std::vector<Fitted>> tiles_;  // [column][row]
};

// The width and height of a tile, pixels.
inline constexpr int kPlaneTile = 4;

// Index of a tile, of so many rows of tiles, in a vector [column][row].
inline std::size_t tile_index(int column, int row, int rows) {
  return static_cast<std::size_t>(column) * static_cast<std::size_t>(rows) +
         static_cast<std::size_t>(row);
}

}  // namespace raywalk::build_lf
