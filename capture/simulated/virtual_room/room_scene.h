// A furnished and lit room that can be ray traced.
#pragma once

#include <span>

#include "capture/simulated/virtual_room/embree_scene.h"
#include "capture/simulated/virtual_room/furnishing.h"
#include "capture/simulated/virtual_room/light_map.h"

namespace raywalk::capture {

// Room units. Thread-safe.
class RoomScene {
 public:
  // Furnishes and lights the room. Throws UsageError naming the seed if there is no space for an
  // object, Error if the ray tracer fails, Interrupted.
  RoomScene(const RoomPlan& plan, const ContentSettings& contents);
  // The light map refers to the scene.
  RoomScene(const RoomScene&) = delete;
  RoomScene& operator=(const RoomScene&) = delete;

  // Sets lights[i] to the light along rays[i]: linear, relative to white, filtered for a pixel of
  // the angle `pixel_rad`.
  void look(std::span<const Ray> rays, double pixel_rad, std::span<Color> lights) const;

  // Sets distances[i] to the distance along rays[i] to the first surface; +inf for the sky.
  void measure(std::span<const Ray> rays, std::span<double> distances) const;

  const Facet& facet(int index) const {
    return room_.facets.facets[static_cast<std::size_t>(index)];
  }
  // The surface of a hit; hit.facet must not be -1.
  const Surface& surface_of(const Hit& hit) const;
  const EmbreeScene& geometry() const { return scene_; }

 private:
  Color light_of(const Ray& ray, const Hit& hit, double pixel_rad) const;
  Color reflection(const Ray& ray, const Hit& hit, double pixel_rad) const;
  // Light of the diffuse surface at the hit; `travelled` is the length of the path before the ray.
  Color diffuse_light(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;

  FurnishedRoom room_;
  EmbreeScene scene_;
  LightMap light_map_;
};

}  // namespace raywalk::capture
