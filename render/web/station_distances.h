// The distances seen from stations, complete: also where a station has no distance map, or its map
// knows nothing.
#pragma once

#include "core/room/distance_maps.h"
#include "core/room/room.h"
#include "core/view/distance_view.h"

namespace raywalk::render {

class StationDistances {
 public:
  // Of stations of `room`, which must outlive the object, at `width`.
  StationDistances(const Room& room, int width) : room_(room), width_(width), view_(room) {}

  // The inverse distances seen from a station, 1/m; all known. Its own map where that is confident
  // (kMinConfidence) and not doubted (smooth_distances.h); elsewhere what a view there is given:
  // gathered from the maps nearest to it and filled. All 0, infinitely far, in a room without maps.
  // Silhouettes stay sharp at any width: distances of two surfaces are never mixed.
  InverseMap seen_from(int line, int station);

 private:
  const Room& room_;
  int width_;
  DistanceView view_;
};

}  // namespace raywalk::render
