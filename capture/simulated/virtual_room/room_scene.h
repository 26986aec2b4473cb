// A furnished and lit room that answers what a ray sees.
#pragma once

#include <span>

#include "capture/simulated/virtual_room/embree_scene.h"
#include "capture/simulated/virtual_room/furnishing.h"
#include "capture/simulated/virtual_room/light_map.h"

namespace raywalk::capture {

// Room units. Safe to use from several threads at once.
class RoomScene {
 public:
  // Furnishes and lights the room. Throws UsageError naming the seed where something finds no
  // place, Error if the ray tracer fails, Interrupted.
  RoomScene(const RoomPlan& plan, const ContentSettings& contents);
  // The light map refers to the scene.
  RoomScene(const RoomScene&) = delete;
  RoomScene& operator=(const RoomScene&) = delete;

  // lights[i] is what rays[i] sees: linear, relative to white, averaged over a pixel that covers
  // the angle `pixel_rad`.
  void look(std::span<const Ray> rays, double pixel_rad, std::span<Color> lights) const;

  // distances[i] is how far along rays[i] the first surface is; +inf for the sky.
  void measure(std::span<const Ray> rays, std::span<double> distances) const;

  const Facet& facet(int index) const {
    return room_.facets.facets[static_cast<std::size_t>(index)];
  }
  // Of what was hit; the hit must be one.
  const Surface& surface_of(const Hit& hit) const;
  const EmbreeScene& geometry() const { return scene_; }

 private:
  Color light_of(const Ray& ray, const Hit& hit, double pixel_rad) const;
  Color reflection(const Ray& ray, const Hit& hit, double pixel_rad) const;
  // Of the surface where the ray, having come `travelled` before, meets it.
  Color matt_light(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;

  FurnishedRoom room_;
  EmbreeScene scene_;
  LightMap light_map_;
};

}  // namespace raywalk::capture
