// For tests: what can be seen from where in a synthetic room, in closed form.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "core/view/test_room.h"
#include "core/view/view_inputs.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

// A room with a pillar in the cell, up to above the stations: lines do not see its far side nor
// what is behind it. Two panorama rows for each row of the distances.
inline SyntheticRoomSpec pillar_spec() {
  SyntheticRoomSpec spec;
  spec.overhang_m = 0.25;
  spec.width = 256;
  spec.distance_width = 128;
  spec.scene.obstacle = SceneBox{{0.1, -1.2, 0.12}, {0.3, 0.4, 0.32}};
  return spec;
}

// The same room without the pillar: every station sees everything.
inline SyntheticRoomSpec smooth_spec() {
  SyntheticRoomSpec spec = pillar_spec();
  spec.scene.obstacle.reset();
  return spec;
}

// These rooms, written once per program.
inline const TestRoom& pillar_room() {
  static const TestRoom room(pillar_spec());
  return room;
}
inline const TestRoom& smooth_room() {
  static const TestRoom room(smooth_spec());
  return room;
}

// Where the pixel (u, v) of a panorama of the given size at `from_m` lies.
inline Eigen::Vector3d point_at(const SyntheticScene& scene, const Eigen::Vector3d& from_m,
                                PixelPosition pixel, PanoramaSize size) {
  const Eigen::Vector3d direction = direction_from_angles(angles_from_pixel(pixel, size));
  return from_m + direction * distance_at(scene, from_m, direction);
}

// Whether a surface point is seen from a place. Surfaces are told apart that are further apart than
// 1 % of the distance.
inline bool sees(const SyntheticScene& scene, const Eigen::Vector3d& from_m,
                 const Eigen::Vector3d& point_m) {
  const Eigen::Vector3d ray = point_m - from_m;
  return distance_at(scene, from_m, ray.normalized()) > 0.99 * ray.norm();
}

// The same of all points around a pixel of a view's distances, seen from the viewpoint; none where
// it differs between them: a silhouette.
inline std::optional<bool> all_seen(const SyntheticScene& scene, const ViewInputs& view,
                                    const Eigen::Vector3d& from_m, int depth_theta, int depth_row) {
  constexpr int kAround = 2;
  int seen = 0;
  int all = 0;
  for (int du = -kAround; du <= kAround; ++du) {
    for (int dv = -kAround; dv <= kAround; ++dv) {
      const PixelPosition at{double(depth_theta + du), double(depth_row + dv)};
      seen += sees(scene, from_m, point_at(scene, view.viewpoint_m(), at, view.distances->size()))
                  ? 1
                  : 0;
      ++all;
    }
  }
  if (seen != 0 && seen != all) return std::nullopt;
  return seen == all;
}

// Where the ray of a column crosses the line of a source, at the height of the lines.
inline Eigen::Vector3d acquisition_point(const ViewInputs& view, const RaySource& source,
                                         double theta_rad) {
  return view.viewpoint_m() - Eigen::Vector3d(0.0, view.plan.above_lines_m(), 0.0) +
         source.d_p_m * Eigen::Vector3d(std::sin(theta_rad), 0.0, std::cos(theta_rad));
}

inline Eigen::Vector3d station_position(const ViewInputs& view, int line, int station) {
  return view.room.grid()
      .lines[static_cast<std::size_t>(line)]
      .stations[static_cast<std::size_t>(station)]
      .position_m;
}

}  // namespace raywalk
