#include "core/view/fill_stations.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"

namespace raywalk {
namespace {

// The direction of a point from a station, of any length.
Eigen::Vector3d direction_from(const MapStation& map, const ViewPoint& point) {
  return point.direction.cast<double>() + double(point.inverse) * (point.eye_m - map.position_m);
}

}  // namespace

ViewPoint point_in(const DistanceView& distances, int theta, int row) {
  const double theta_rad = theta_of_column(theta, distances.size().width);
  const auto sin_theta = static_cast<float>(std::sin(theta_rad));
  const auto cos_theta = static_cast<float>(std::cos(theta_rad));
  const auto i = static_cast<std::size_t>(row);
  const float sin_phi = distances.latitudes().sin_phi[i],
              cos_phi = distances.latitudes().cos_phi[i];
  const float* const trust = distances.trust(theta);
  return {.eye_m = distances.eye().position_m(theta_rad),
          .direction = {cos_phi * sin_theta, sin_phi, cos_phi * cos_theta},
          .inverse = distances.column(theta)[row],
          .trust = trust == nullptr ? 1.0f : trust[row]};
}

int FillStations::find(const DistanceView& distances, const ViewPoint& point) const {
  if (point.trust < 0.5f) return find_unmasked(distances, point);
  const float tolerance = distances.surface_tolerance();
  int just_sees = kNone, shows_moved = kNone;
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    const MapLookup there =
        look_up(*room_, maps_[i], point.direction, point.inverse, point.eye_m, tolerance);
    const float occludes = there.inverse_there * (1.0f + tolerance);
    if (there.inverse_map < 0.0f || there.inverse_map > occludes) continue;
    if (!is_unmasked(maps_[i], distances, point)) continue;
    if (is_left_out(maps_[i], point)) {
      if (shows_moved == kNone) shows_moved = static_cast<int>(i);
      continue;
    }
    if (there.inverse_around <= occludes) return static_cast<int>(i);
    if (just_sees == kNone) just_sees = static_cast<int>(i);
  }
  return just_sees != kNone ? just_sees : shows_moved;
}

int FillStations::find_unmasked(const DistanceView& distances, const ViewPoint& point) const {
  const std::size_t nearest = std::min(maps_.size(), std::size_t{2});
  for (std::size_t i = 0; i < nearest; ++i) {
    if (is_unmasked(maps_[i], distances, point)) return static_cast<int>(i);
  }
  return kNone;
}

bool FillStations::is_unmasked(const MapStation& map, const DistanceView& distances,
                               const ViewPoint& point) const {
  const LineVolume& volume = room_->volume(map.line);
  if (!volume.masked()) return true;
  const PanoramaSize captured = volume.panorama();
  const Eigen::Vector3d direction = direction_from(map, point);
  const SphereAngles angles = angles_from_direction(direction);
  const PixelPosition at = pixel_from_angles(angles, captured);
  // The pixels that a pixel of the distances covers there: more if the station is nearer, and more
  // columns towards a pole.
  const double rows_per_distance = double(captured.height) / distances.size().height;
  const double radius = 0.5 + rows_per_distance * std::max(1.0, 1.0 / direction.norm());
  const double columns =
      std::min(radius / std::max(1e-6, std::cos(angles.phi_rad)), 0.5 * captured.width);
  const auto first_row = static_cast<int>(std::floor(at.v - radius));
  const auto last_row = static_cast<int>(std::ceil(at.v + radius));
  const int first = static_cast<int>(std::floor(at.u - columns));
  const int last = static_cast<int>(std::ceil(at.u + columns));
  for (int u = first; u <= last; ++u) {
    const RowRun rows = volume.valid_rows(map.station, wrapped_column(u, captured.width));
    if (std::max(first_row, 0) < rows.begin || std::min(last_row, captured.height - 1) >= rows.end)
      return false;
  }
  return true;
}

bool FillStations::is_left_out(const MapStation& map, const ViewPoint& point) const {
  const LeftOutPixels& left_out = room_->distances(map.line).left_out();
  if (!left_out.any(map.station)) return false;
  const PixelPosition at =
      pixel_from_angles(angles_from_direction(direction_from(map, point)), left_out.size());
  const auto row = static_cast<int>(std::lround(at.v));
  const auto column = static_cast<int>(std::lround(at.u));
  for (int u = column - 1; u <= column + 1; ++u) {
    for (const RowRun& run : left_out.rows(map.station, wrapped_column(u, left_out.size().width))) {
      if (row - 1 < run.end && row + 1 >= run.begin) return true;
    }
  }
  return false;
}

}  // namespace raywalk
