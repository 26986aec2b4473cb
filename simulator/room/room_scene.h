// A lit scene that can be ray traced. Metres, in the scene's frame.
#pragma once

#include <optional>
#include <span>

#include "simulator/room/embree_scene.h"
#include "simulator/room/light_map.h"
#include "simulator/room/scene_file.h"

namespace raywalk::simulator {

// What is in the room at one moment only: moving objects, and what moves with the camera. They are
// lit evenly, cast no shadow and are not seen in mirrors or panes of glass. Thread-safe.
class Bodies {
 public:
  // The first `moving` facets are those of moving objects, the others are carried.
  Bodies(Facets bodies, std::size_t moving);

  // Sets hits[i] to the first hit of rays[i], facet -1 where it meets nobody.
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
    scene_.intersect(rays, hits);
  }

  // Whether `hit` hides what the same ray hits of the room. Furniture does not hide what is
  // carried, so that lines may be above a chair.
  bool hides(const Hit& hit, const Hit& of_room) const;

  // The light of what the ray hits: linear, relative to white, filtered for a pixel of the angle
  // `pixel_rad`. hit.facet must not be -1.
  Color light_of(const Ray& ray, const Hit& hit, double pixel_rad) const;

 private:
  Facets bodies_;
  int moving_;
  EmbreeScene scene_;
};

// Thread-safe.
class RoomScene {
 public:
  // Lights the scene, which takes about a second. `source_gain` multiplies the light of sky and
  // lamps as it is seen. Throws Error if the ray tracer fails, Interrupted.
  RoomScene(Scene scene, double source_gain);
  // The light map refers to the scene.
  RoomScene(const RoomScene&) = delete;
  RoomScene& operator=(const RoomScene&) = delete;

  // Sets lights[i] to the light along rays[i]: linear, relative to white, filtered for a pixel of
  // the angle `pixel_rad`. `bodies`, if any, are in the room.
  void look(std::span<const Ray> rays, double pixel_rad, std::span<Color> lights,
            const Bodies* bodies = nullptr) const;

  // Sets distances[i] to the distance along rays[i] to the first surface that is not a pane of
  // glass; +inf for the sky.
  void measure(std::span<const Ray> rays, std::span<double> distances) const;

  // Whether the place is inside a solid.
  bool is_inside_solid(const Eigen::Vector3d& place) const;

  const Scene& scene() const { return room_; }
  // Without panes of glass.
  const EmbreeScene& geometry() const { return scene_; }

 private:
  const Facet& facet(const Hit& hit) const;
  const Surface& surface_of(const Facet& facet) const;
  // In the three functions below, `travelled` is the length of the light's path before the ray.
  Color light_of(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;
  Color reflection(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;
  Color diffuse_light(const Ray& ray, const Hit& hit, double travelled, double pixel_rad) const;
  // `seen` at `distance`, as it looks through the panes in front of it.
  Color through_glass(const Ray& ray, double distance, const Color& seen, double pixel_rad) const;

  Scene room_;
  EmbreeScene scene_;
  std::optional<EmbreeScene> glass_;  // none if there are no panes
  float source_gain_;
  LightMap light_map_;
};

}  // namespace raywalk::simulator
