// An outdoor canyon: a street between two rows of buildings under the open sky, as a vehicle sees
// it. Room units are metres.
#pragma once

#include "simulator/room/furnishing.h"
#include "simulator/room/room_plan.h"

namespace raywalk::capture {

// One line along the middle of the street, with stations unevenly spaced. The plan's floor is the
// pavement; the roadway is a kerb lower. Throws UsageError naming the key if the camera would touch
// the ground or the largest spacing is less than the smallest.
RoomPlan plan_canyon(const VirtualRoomSettings& settings);

// Roadway, kerbs, pavements with bollards, parked cars, buildings on both sides and across both
// ends; the sun is over the street. With contents.glass, windows reflect.
FurnishedRoom build_canyon(const RoomPlan& plan, const VirtualRoomSettings& settings);

}  // namespace raywalk::capture
