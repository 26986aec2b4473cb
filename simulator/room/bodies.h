// What stands in a room for one picture only.
#pragma once

#include <cstddef>

#include "simulator/room/embree_scene.h"
#include "simulator/room/shapes.h"

namespace raywalk::simulator {

// What is in the room at one moment only: moving objects, and what moves with the camera. They are
// lit evenly, cast no shadow and are not seen in mirrors or panes of glass. Thread-safe.
class Bodies {
 public:
  // The first `moving` facets are those of moving objects, the others are carried.
  Bodies(Facets bodies, std::size_t moving);

  // The first hit of the ray, facet -1 where it meets nobody.
  Hit intersect(const Ray& ray) const { return scene_.intersect(ray); }

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

}  // namespace raywalk::simulator
