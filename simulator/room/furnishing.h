// Builds a complete room from the seed: shell, furniture and lights.
#pragma once

#include "simulator/room/facets.h"
#include "simulator/room/light_sources.h"
#include "simulator/room/room_plan.h"

namespace raywalk::capture {

struct FurnishedRoom {
  Facets facets;
  Facets glass;  // panes that one can see through
  LightSources lights;
};

// Furniture that reaches into the plan's headroom around the cameras keeps the plan's clearance
// from all lines and cells; lower furniture may be anywhere. Throws UsageError naming the seed if
// there is no space for an object.
FurnishedRoom furnish(const RoomPlan& plan, const ContentSettings& contents);

}  // namespace raywalk::capture
