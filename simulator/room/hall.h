// A hall: a room whose grid has any number of cells, with aisles between rows of stands. The stands
// are inside of cells, so that neighbouring cells see different things.
#pragma once

#include "simulator/room/furnishing.h"
#include "simulator/room/room_plan.h"

namespace raywalk::capture {

// As plan_room, with walls and ceiling farther away the more cells there are across the hall. True
// views are in the cells without a stand, spread over all of them. Throws UsageError as plan_room.
RoomPlan plan_hall(const VirtualRoomSettings& settings);

// Whether something stands in the cell of this column (along x) and row (along z), from 0.
bool has_stand(const HallSettings& hall, int column, int row);

// Shell, stands (shelves with goods, columns, posters), boxes on the floor of the other cells,
// beams, lamps and signs under the ceiling. What reaches up to the cameras keeps the plan's
// clearance from all lines. Throws UsageError naming the seed if the pictures do not fit on the
// walls.
FurnishedRoom build_hall(const RoomPlan& plan, const VirtualRoomSettings& settings);

}  // namespace raywalk::capture
