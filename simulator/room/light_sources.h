// The light sources of a room.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace raywalk::capture {

// The pane of the window: a rectangle from `corner`, facing `inward`.
struct WindowLight {
  Eigen::Vector3d corner{0, 0, 0};
  Eigen::Vector3d edge_s{1, 0, 0};
  Eigen::Vector3d edge_t{0, 1, 0};
  Eigen::Vector3d inward{0, 0, 1};
  // Unit vector towards the sun; empty: no sunlight.
  std::optional<Eigen::Vector3d> sun{};
};

struct LampLight {
  Eigen::Vector3d centre{0, 0, 0};
  double radius = 0.15;
  double reach = std::numeric_limits<double>::infinity();  // gives no light farther away
};

// Room units.
struct LightSources {
  std::optional<WindowLight> window{};
  std::vector<LampLight> lamps{};
  std::uint32_t sky_seed = 0;
  // Outdoors: light from the sky wherever it is open, and the sun in this direction.
  bool open_sky = false;
  std::optional<Eigen::Vector3d> open_sun{};
  double grid_step = 0.12;  // of the light map
};

}  // namespace raywalk::capture
