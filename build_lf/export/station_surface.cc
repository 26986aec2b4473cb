#include "build_lf/export/station_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "build_lf/export/exported_stations.h"
#include "core/geometry/panorama_pixels.h"
#include "core/room/distance_maps.h"

namespace raywalk::build_lf {
namespace {

// A pixel of the map is usable if the panorama's is at its centre.
cv::Mat usable_pixels(const Room& room, StationIndex station) {
  const PanoramaSize size = room.distances(station.line).size();
  cv::Mat usable;
  cv::resize(station_mask(room, station), usable, cv::Size(size.width, size.height), 0, 0,
             cv::INTER_NEAREST);
  return usable;
}

}  // namespace

StationSurface::StationSurface(const Room& room, StationIndex station, int map,
                               double max_distance_m)
    : distances_(&room.distances(station.line)),
      map_(map),
      max_distance_m_(max_distance_m > 0.0 ? max_distance_m
                                           : std::numeric_limits<double>::infinity()),
      position_m_(room.grid().station(station).position_m),
      usable_(usable_pixels(room, station)) {}

std::uint8_t StationSurface::confidence(int theta, int row) const {
  return distances_->confidence_column(map_, theta)[static_cast<std::size_t>(row)];
}

std::optional<double> StationSurface::distance_m(int theta, int row) const {
  if (confidence(theta, row) < kMinConfidence || usable_.at<uchar>(row, theta) == 0) {
    return std::nullopt;
  }
  const double distance = distances_->distance_column(map_, theta)[static_cast<std::size_t>(row)];
  const bool counts = std::isfinite(distance) && distance > 0.0 && distance <= max_distance_m_;
  return counts ? std::optional(distance) : std::nullopt;
}

Eigen::Vector3d StationSurface::direction(int theta, int row) const {
  return direction_from_angles(
      angles_from_pixel({static_cast<double>(theta), static_cast<double>(row)}, size()));
}

std::optional<Eigen::Vector3d> StationSurface::point_m(int theta, int row) const {
  return point_near(theta, row, 0.0);
}

std::optional<Eigen::Vector3d> StationSurface::point_near(int theta, int row,
                                                          double beside_m) const {
  if (row < 0 || row >= size().height) return std::nullopt;
  const int column = wrapped_column(theta, size().width);
  const std::optional<double> here_m = distance_m(column, row);
  if (!here_m) return std::nullopt;
  const double most_m = surface_tolerance_of(size().width) * std::max(*here_m, beside_m);
  if (beside_m > 0.0 && std::abs(*here_m - beside_m) > most_m) return std::nullopt;
  return Eigen::Vector3d(position_m_ + *here_m * direction(column, row));
}

std::optional<Eigen::Vector3d> StationSurface::nearest_point_m(
    const Eigen::Vector3d& searched_m) const {
  const Eigen::Vector3d ray = searched_m - position_m_;
  const double away_m = ray.norm();
  if (away_m == 0.0) return std::nullopt;
  const PixelsAround pixels =
      pixels_around(pixel_from_angles(angles_from_direction(ray), size()), size());
  const int theta = pixels.nearest_column();
  const int row = pixels.nearest_row();
  const auto here = point_near(theta, row, away_m);
  if (!here) return std::nullopt;
  const double here_m = *distance_m(theta, row);
  const auto left = point_near(theta - 1, row, here_m);
  const auto right = point_near(theta + 1, row, here_m);
  const auto above = point_near(theta, row - 1, here_m);
  const auto below = point_near(theta, row + 1, here_m);
  if (!left || !right || !above || !below) return std::nullopt;
  const Eigen::Vector3d normal = (*right - *left).cross(*below - *above);
  if (normal.norm() == 0.0) return std::nullopt;
  const Eigen::Vector3d unit = normal.normalized();
  return Eigen::Vector3d(searched_m - (searched_m - *here).dot(unit) * unit);
}

}  // namespace raywalk::build_lf
