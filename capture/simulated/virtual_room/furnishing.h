// A whole room: shell, furniture and lights, placed by the seed.
#pragma once

#include "capture/simulated/virtual_room/facets.h"
#include "capture/simulated/virtual_room/light_sources.h"
#include "capture/simulated/virtual_room/room_plan.h"

namespace raywalk::capture {

struct FurnishedRoom {
  Facets facets;
  LightSources lights;
};

// Furniture that reaches up to the cameras, less the plan's headroom, keeps the plan's clearance
// from all lines and cells; lower furniture stands anywhere. Throws UsageError naming the seed
// where something finds no place.
FurnishedRoom furnish(const RoomPlan& plan, const ContentSettings& contents);

}  // namespace raywalk::capture
