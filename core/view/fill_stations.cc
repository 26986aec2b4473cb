#include "core/view/fill_stations.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/panorama_pixels.h"

namespace raywalk {

int FillStations::of(int depth_theta, int depth_row) {
  if (theta_ != depth_theta) {
    theta_ = depth_theta;
    of_row_.assign(static_cast<size_t>(view_.distances->size().height), kUnknown);
  }
  int& station = of_row_[static_cast<size_t>(depth_row)];
  if (station == kUnknown) station = find(depth_theta, depth_row);
  return station;
}

FillStations::Seen FillStations::seen_in(int depth_theta, int depth_row) const {
  const SphereAngles angles =
      angles_from_pixel({double(depth_theta), double(depth_row)}, view_.distances->size());
  return {.eye_m = view_.eye_m(angles.theta_rad),
          .direction = direction_from_angles(angles).cast<float>(),
          .omega = view_.distances->column(depth_theta)[depth_row]};
}

Eigen::Vector3d FillStations::direction_from(const MapStation& map, const Seen& seen) {
  return seen.direction.cast<double>() + double(seen.omega) * (seen.eye_m - map.position_m);
}

bool FillStations::is_left_out(const MapStation& map, int depth_theta, int depth_row) const {
  return is_left_out(map, seen_in(depth_theta, depth_row));
}

int FillStations::find(int depth_theta, int depth_row) const {
  const DistanceView& distances = *view_.distances;
  const Seen seen = seen_in(depth_theta, depth_row);
  const float tolerance = distances.surface_tolerance();
  const float* const trust = distances.trust(depth_theta);
  if (trust != nullptr && trust[depth_row] < 0.5f) {
    return find_unmasked(seen);
  }
  // Next to a silhouette a captured pixel is part foreground: a station that sees the point away
  // from nearer surfaces is preferred to a nearer one that sees it at a silhouette.
  int just_sees = kNone;
  // What moved is shown only where no other station sees the place.
  int shows_moved = kNone;
  for (size_t i = 0; i < view_.fill_maps.size(); ++i) {
    const MapLookup there =
        look_up(view_.room, view_.fill_maps[i], seen.direction, seen.omega, seen.eye_m, tolerance);
    const float hides = there.omega_there * (1.0f + tolerance);
    if (there.omega_map < 0.0f || there.omega_map > hides) continue;
    if (!is_unmasked(view_.fill_maps[i], seen)) continue;
    if (is_left_out(view_.fill_maps[i], seen)) {
      if (shows_moved == kNone) shows_moved = static_cast<int>(i);
      continue;
    }
    if (there.omega_around <= hides) return static_cast<int>(i);
    if (just_sees == kNone) just_sees = static_cast<int>(i);
  }
  return just_sees != kNone ? just_sees : shows_moved;
}

int FillStations::find_unmasked(const Seen& seen) const {
  // Without a distance to rely on it is not known which stations see the point, and farther
  // stations would show something else.
  const size_t nearest = std::min(view_.fill_maps.size(), size_t{2});
  for (size_t i = 0; i < nearest; ++i) {
    if (is_unmasked(view_.fill_maps[i], seen)) return static_cast<int>(i);
  }
  return kNone;
}

bool FillStations::is_unmasked(const MapStation& map, const Seen& seen) const {
  const LineVolume& volume = view_.room.volume(map.line);
  if (!volume.masked()) return true;
  const PanoramaSize captured = volume.panorama();
  const Eigen::Vector3d direction = direction_from(map, seen);
  const SphereAngles angles = angles_from_direction(direction);
  const PixelPosition at = pixel_from_angles(angles, captured);
  // The pixels that a pixel of the distances covers there: more if the station is nearer, and more
  // columns towards a pole.
  const double rows_per_distance = double(captured.height) / view_.distances->size().height;
  const double radius = 0.5 + rows_per_distance * std::max(1.0, 1.0 / direction.norm());
  const double columns =
      std::min(radius / std::max(1e-6, std::cos(angles.phi_rad)), 0.5 * captured.width);
  const auto first_row = static_cast<int>(std::floor(at.v - radius));
  const auto last_row = static_cast<int>(std::ceil(at.v + radius));
  const int first = static_cast<int>(std::floor(at.u - columns));
  const int last = static_cast<int>(std::ceil(at.u + columns));
  for (int u = first; u <= last; ++u) {
    const int theta = wrapped_column(u, captured.width);
    const RowRun rows = volume.valid_rows(map.station, theta);
    if (std::max(first_row, 0) < rows.begin || std::min(last_row, captured.height - 1) >= rows.end)
      return false;
  }
  return true;
}

bool FillStations::is_left_out(const MapStation& map, const Seen& seen) const {
  const LeftOutPixels& left_out = view_.room.distances(map.line).left_out();
  if (!left_out.any(map.station)) return false;
  const PixelPosition at =
      pixel_from_angles(angles_from_direction(direction_from(map, seen)), left_out.size());
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
