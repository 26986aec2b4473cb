// People who walk around the capture grid while it is captured: every station sees them elsewhere.
//
// They walk one behind the other on a loop around the lines, on free floor only, and are far enough
// from the lines not to touch the camera. They are lit evenly, cast no shadow and are not seen in
// mirrors or panes of glass.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "simulator/room/embree_scene.h"
#include "simulator/room/room_plan.h"
#include "simulator/room/shapes.h"

namespace raywalk::capture {

// Where people walk. Room units.
class PeoplePath {
 public:
  // Throws UsageError naming the seed if there is less free floor around the lines than `people`
  // need.
  PeoplePath(const RoomPlan& plan, const EmbreeScene& room, const PeopleSettings& people);

  // Feet of everybody while station `moment` (0 = the first) is captured.
  std::vector<Placement> at(int moment) const;

 private:
  std::vector<Placement> places_;  // kPlaceStep apart, in the order in which they are walked over
  int count_ = 0;
  double start_ = 0.0;  // of the first person at moment 0, in places
  double step_ = 0.0;   // between stations, in places
};

// Everybody at one moment, ready to be ray traced. Room units. Thread-safe.
class PeopleScene {
 public:
  // `seed` determines statures and clothes.
  PeopleScene(const std::vector<Placement>& feet, int seed);

  // Sets hits[i] to the first hit of rays[i], facet -1 where it meets nobody.
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
    scene_.intersect(rays, hits);
  }

  // The light of what the ray hits: linear, relative to white, filtered for a pixel of the angle
  // `pixel_rad`. hit.facet must not be -1.
  Color light_of(const Ray& ray, const Hit& hit, double pixel_rad) const;

 private:
  Facets people_;
  EmbreeScene scene_;
};

}  // namespace raywalk::capture
