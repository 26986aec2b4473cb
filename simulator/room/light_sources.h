// The light sources of a room.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace raywalk::capture {

// The pane of a window: a rectangle from `corner`, facing `inward`.
struct WindowLight {
  Eigen::Vector3d corner{0, 0, 0};
  Eigen::Vector3d edge_s{1, 0, 0};
  Eigen::Vector3d edge_t{0, 1, 0};
  Eigen::Vector3d inward{0, 0, 1};
};

struct LampLight {
  Eigen::Vector3d centre{0, 0, 0};
  double radius = 0.15;
};

// Metres.
struct LightSources {
  std::vector<WindowLight> windows{};
  std::vector<LampLight> lamps{};
  // A lamp gives no light farther away.
  double lamp_reach = std::numeric_limits<double>::infinity();
  std::uint32_t sky_seed = 0;
  // Outdoors: light from the sky wherever it is open, not only through windows; so for the sun.
  bool open_sky = false;
  // Unit vector towards the sun; empty: no sunlight.
  std::optional<Eigen::Vector3d> sun{};
  double grid_step = 0.12;  // of the light map
};

}  // namespace raywalk::capture
