// A furnished and lit room that can be ray traced.
#pragma once

#include <optional>
#include <span>

#include "simulator/room/embree_scene.h"
#include "simulator/room/furnishing.h"
#include "simulator/room/light_map.h"
#include "simulator/room/walking_people.h"

namespace raywalk::capture {

// Room units. Thread-safe.
class RoomScene {
 public:
  // Furnishes and lights the room. Throws UsageError naming the seed if there is no space for an
  // object, Error if the ray tracer fails, Interrupted.
  RoomScene(const RoomPlan& plan, const VirtualRoomSettings& settings);
  // The light map refers to the scene.
  RoomScene(const RoomScene&) = delete;
  RoomScene& operator=(const RoomScene&) = delete;

  // Sets lights[i] to the light along rays[i]: linear, relative to white, filtered for a pixel of
  // the angle `pixel_rad`. `people`, if any, are in the room.
  void look(std::span<const Ray> rays, double pixel_rad, std::span<Color> lights,
            const PeopleScene* people = nullptr) const;

  // Sets distances[i] to the distance along rays[i] to the first surface that is not a pane of
  // glass; +inf for the sky.
  void measure(std::span<const Ray> rays, std::span<double> distances) const;

  const Facet& facet(int index) const {
    return room_.facets.facets[static_cast<std::size_t>(index)];
  }
  // The surface of a hit; hit.facet must not be -1.
  const Surface& surface_of(const Hit& hit) const;
  // Without panes of glass.
  const EmbreeScene& geometry() const { return scene_; }
  const Facets& glass() const { return room_.glass; }

 private:
  // In the three functions below, `travelled` is the length of the light's path before the ray.
  Color light_of(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;
  Color reflection(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;
  Color diffuse_light(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;
  // `seen` at `distance`, as it looks through the panes in front of it.
  Color through_glass(const Ray& ray, double distance, const Color& seen, double pixel_rad) const;

  FurnishedRoom room_;
  EmbreeScene scene_;
  std::optional<EmbreeScene> glass_;  // none if there are no panes
  float source_gain_;
  LightMap light_map_;
};

}  // namespace raywalk::capture
