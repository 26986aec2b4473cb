// The light sources of a room, and the precomputed, view-independent irradiance of its facets.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "simulator/room/embree_scene.h"

namespace raywalk::simulator {

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

// The mean irradiance of a room.
inline constexpr float kMeanLight = 0.75F;

// Irradiance on a grid over each facet: window and lamp with soft shadows, plus one bounce from all
// other surfaces, scaled such that the mean over the shell (floor, walls and ceiling; of all facets
// where is none) is kMeanLight, the exposure of the camera. Sunlight has sharp edges and is
// computed per point instead.
class LightMap {
 public:
  // Computes everything except sunlight, in parallel. `scene` is built from `facets` and must
  // outlive this object. Throws Interrupted.
  LightMap(const Facets& facets, const EmbreeScene& scene, const LightSources& lights);

  // Irradiance at the point of a hit, relative to that which makes a white surface white. `normal`
  // is that of the facet's visible side.
  Color at(const Hit& hit, const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

 private:
  struct Grid {
    std::size_t first = 0;  // index into light_
    int columns = 2;        // along u
    int rows = 2;           // along v
  };

  // Calls point(index into light_, GridPoint) for every point of every grid, in parallel.
  template <typename Point>
  void for_each_point(const Facets& facets, const Point& point) const;
  Color interpolate(const Hit& hit) const;
  // Whether the sun shines on the point: through a window, or from the open sky.
  bool is_sunlit(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
  float sunlight(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
  void light_directly(const Facets& facets);
  void add_bounce(const Facets& facets);
  void expose(const Facets& facets);

  const EmbreeScene& scene_;
  LightSources lights_;
  float sun_ = 0.0F;  // irradiance on a surface facing the sun
  std::vector<Grid> grids_;
  std::vector<Color> light_;
};

}  // namespace raywalk::simulator
