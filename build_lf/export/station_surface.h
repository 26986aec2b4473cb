// The surface that a station's distance map shows.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/geometry/sphere.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// One map of a room, which has to outlive it. Pixels count that views use: of sufficient confidence
// (kMinConfidence), with a surface, not masked and not left out, and at most `max_distance_m` from
// the station (0: at any distance).
class StationSurface {
 public:
  // `map` is the station's among those of its line.
  StationSurface(const Room& room, StationIndex station, int map, double max_distance_m);

  PanoramaSize size() const { return distances_->size(); }
  const Eigen::Vector3d& position_m() const { return position_m_; }

  std::uint8_t confidence(int theta, int row) const;
  // The unit direction of a pixel's centre.
  Eigen::Vector3d direction(int theta, int row) const;
  // The point of the world that the pixel shows; none where no pixel counts. theta in [0, width),
  // row in [0, height).
  std::optional<Eigen::Vector3d> point_m(int theta, int row) const;

  // The point of the surface that is nearest to `point`, by the plane through the pixel that shows
  // its direction and the pixels around it. None where that pixel does not count, shows another
  // surface or lies at an edge.
  std::optional<Eigen::Vector3d> nearest_point_m(const Eigen::Vector3d& point_m) const;

 private:
  std::optional<double> distance_m(int theta, int row) const;
  // The pixel's point if it is on one surface with what is `distance_m` away beside it.
  std::optional<Eigen::Vector3d> point_near(int theta, int row, double distance_m) const;

  const DistanceVolume* distances_;
  int map_;
  double max_distance_m_;
  Eigen::Vector3d position_m_;
  cv::Mat usable_;  // CV_8UC1 of the map's size [row][theta]
};

}  // namespace raywalk::build_lf
