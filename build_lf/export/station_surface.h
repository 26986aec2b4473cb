// The surface that a station's distance map shows, as coloured points.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "core/geometry/sphere.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Which pixels of distance maps count.
struct SurfaceLimits {
  double max_distance_m = 0.0;  // from the station; 0: any
};

// One map of a room, which has to outlive it. Pixels count that views use: of sufficient confidence
// (kMinConfidence), with a surface, not masked and not left out.
class StationSurface {
 public:
  StationSurface(const Room& room, int line, int map, SurfaceLimits limits);

  PanoramaSize size() const { return size_; }
  int station() const { return station_; }  // of the line
  const Eigen::Vector3d& position_m() const { return position_m_; }

  // Distance from the station along the ray; none where no pixel counts. theta in [0, width), row
  // in [0, height).
  std::optional<double> distance_m(int theta, int row) const;
  std::uint8_t confidence(int theta, int row) const;
  // The unit direction of a pixel's centre.
  Eigen::Vector3d direction(int theta, int row) const;
  // The point of the world that the pixel shows.
  std::optional<Eigen::Vector3d> point_m(int theta, int row) const;

  // The point of the surface that is nearest to `point`, by the plane through the pixel that shows
  // its direction and the pixels around it. None where that pixel does not count, shows another
  // surface or lies at an edge.
  std::optional<Eigen::Vector3d> nearest_point_m(const Eigen::Vector3d& point_m) const;

 private:
  bool same_surface(double a_m, double b_m) const;
  std::optional<Eigen::Vector3d> neighbour(int theta, int row, double distance_m) const;

  const DistanceVolume* distances_;
  int map_;
  int station_;
  SurfaceLimits limits_;
  PanoramaSize size_;
  Eigen::Vector3d position_m_;
  cv::Mat usable_;  // CV_8UC1 of the map's size [row][theta]
};

// The colour that a station shows in a direction: red, green, blue. `columns` as station_columns.
std::array<std::uint8_t, 3> colour_at(const cv::Mat& columns, const Eigen::Vector3d& direction);

}  // namespace raywalk::build_lf
