// Precomputed, view-independent irradiance of all facets.
#pragma once

#include <vector>

#include "simulator/room/embree_scene.h"
#include "simulator/room/light_sources.h"

namespace raywalk::capture {

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

}  // namespace raywalk::capture
