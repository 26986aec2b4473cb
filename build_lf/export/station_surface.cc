#include "build_lf/export/station_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "build_lf/export/exported_stations.h"
#include "core/geometry/panorama_pixels.h"
#include "core/room/distance_maps.h"

namespace raywalk::build_lf {
namespace {

// A pixel of the map is usable if the panorama's is at its centre.
cv::Mat usable_pixels(const Room& room, int line, int station, PanoramaSize size) {
  cv::Mat mask = station_mask(room, {.line = line, .station = station});
  if (mask.cols == size.width) return mask;
  cv::Mat usable;
  cv::resize(mask, usable, cv::Size(size.width, size.height), 0, 0, cv::INTER_NEAREST);
  return usable;
}

}  // namespace

StationSurface::StationSurface(const Room& room, int line, int map, SurfaceLimits limits)
    : distances_(&room.distances(line)),
      map_(map),
      station_(distances_->stations()[static_cast<std::size_t>(map)]),
      limits_(limits),
      size_(distances_->size()),
      position_m_(room.grid()
                      .lines[static_cast<std::size_t>(line)]
                      .stations[static_cast<std::size_t>(station_)]
                      .position_m),
      usable_(usable_pixels(room, line, station_, size_)) {}

std::uint8_t StationSurface::confidence(int theta, int row) const {
  return distances_->confidence_column(map_, theta)[static_cast<std::size_t>(row)];
}

std::optional<double> StationSurface::distance_m(int theta, int row) const {
  if (confidence(theta, row) < kMinConfidence || usable_.at<uchar>(row, theta) == 0) {
    return std::nullopt;
  }
  const double distance = distances_->distance_column(map_, theta)[static_cast<std::size_t>(row)];
  if (!std::isfinite(distance) || distance <= 0.0) return std::nullopt;
  if (limits_.max_distance_m > 0.0 && distance > limits_.max_distance_m) return std::nullopt;
  return distance;
}

Eigen::Vector3d StationSurface::direction(int theta, int row) const {
  return direction_from_angles(
      angles_from_pixel({static_cast<double>(theta), static_cast<double>(row)}, size_));
}

std::optional<Eigen::Vector3d> StationSurface::point_m(int theta, int row) const {
  const std::optional<double> distance = distance_m(theta, row);
  if (!distance) return std::nullopt;
  return Eigen::Vector3d(position_m_ + *distance * direction(theta, row));
}

bool StationSurface::same_surface(double a_m, double b_m) const {
  return std::abs(a_m - b_m) <= surface_tolerance_of(size_.width) * std::max(a_m, b_m);
}

std::optional<Eigen::Vector3d> StationSurface::neighbour(int theta, int row,
                                                         double distance_m_here) const {
  if (row < 0 || row >= size_.height) return std::nullopt;
  const int column = wrapped_column(theta, size_.width);
  const std::optional<double> distance = distance_m(column, row);
  if (!distance || !same_surface(*distance, distance_m_here)) return std::nullopt;
  return point_m(column, row);
}

std::optional<Eigen::Vector3d> StationSurface::nearest_point_m(
    const Eigen::Vector3d& point_m_searched) const {
  const Eigen::Vector3d ray = point_m_searched - position_m_;
  const double away_m = ray.norm();
  if (away_m == 0.0) return std::nullopt;
  const PixelsAround pixels =
      pixels_around(pixel_from_angles(angles_from_direction(ray), size_), size_);
  const int theta = pixels.nearest_column();
  const int row = pixels.nearest_row();
  const std::optional<double> here_m = distance_m(theta, row);
  if (!here_m || !same_surface(*here_m, away_m)) return std::nullopt;
  const auto left = neighbour(theta - 1, row, *here_m);
  const auto right = neighbour(theta + 1, row, *here_m);
  const auto above = neighbour(theta, row - 1, *here_m);
  const auto below = neighbour(theta, row + 1, *here_m);
  if (!left || !right || !above || !below) return std::nullopt;
  const Eigen::Vector3d normal = (*right - *left).cross(*below - *above);
  if (normal.norm() == 0.0) return std::nullopt;
  const Eigen::Vector3d on_surface = *point_m(theta, row);
  const Eigen::Vector3d unit = normal.normalized();
  return Eigen::Vector3d(point_m_searched - (point_m_searched - on_surface).dot(unit) * unit);
}

std::array<std::uint8_t, 3> colour_at(const cv::Mat& columns, const Eigen::Vector3d& direction) {
  const PanoramaSize size{columns.rows, columns.cols};  // transposed
  const PixelsAround pixels =
      pixels_around(pixel_from_angles(angles_from_direction(direction), size), size);
  const cv::Vec3b colour = columns.at<cv::Vec3b>(pixels.nearest_column(), pixels.nearest_row());
  return {colour[0], colour[1], colour[2]};
}

}  // namespace raywalk::build_lf
