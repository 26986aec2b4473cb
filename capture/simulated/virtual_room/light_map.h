// How much light falls on every facet: computed once, so that it is the same from every viewpoint.
#pragma once

#include <vector>

#include "capture/simulated/virtual_room/embree_scene.h"
#include "capture/simulated/virtual_room/light_sources.h"

namespace raywalk::capture {

// Irradiance on a grid over each facet: the light of window and lamp with their soft shadows, and
// one bounce from all other surfaces; scaled so that the mean over floor, walls and ceiling is
// kMeanLight (the camera's exposure). Sunlight has sharp edges, which no grid holds: it is computed
// at the point itself.
class LightMap {
 public:
  // Computes all but the sunlight, in parallel. The scene, made of the facets, has to outlive it.
  // Throws Interrupted.
  LightMap(const Facets& facets, const EmbreeScene& scene, const LightSources& lights);

  // Light that falls on the point of a hit, in units in which a white surface under 1 is white.
  // `normal` is that of the facet on the side that is seen.
  Color at(const Hit& hit, const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

 private:
  struct Grid {
    std::size_t first = 0;  // index into light_
    int columns = 2;        // along u
    int rows = 2;           // along v
  };

  Color interpolate(const Hit& hit) const;
  float sunlight(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
  void light_directly(const Facets& facets);
  void add_bounce(const Facets& facets);
  void expose(const Facets& facets);

  const EmbreeScene& scene_;
  LightSources lights_;
  float sun_ = 0.0F;  // irradiance on a surface that faces the sun
  std::vector<Grid> grids_;
  std::vector<Color> light_;
};

}  // namespace raywalk::capture
