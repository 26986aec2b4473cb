// Whether a camera can be where it is asked to be.
#pragma once

#include <Eigen/Core>

#include "capture/simulated/virtual_room/room_plan.h"
#include "capture/simulated/virtual_room/room_scene.h"

namespace raywalk::capture {

// Throws Error naming the position and the seed where it is not finite, outside of the room, or
// inside of something in it.
void require_free_camera(const RoomPlan& plan, const RoomScene& scene,
                         const Eigen::Vector3d& position_m);

// Throws Error naming station and seed where rays from a station of a line meet something at camera
// height nearer than the plan's clearance.
void require_clear_lines(const RoomPlan& plan, const RoomScene& scene);

}  // namespace raywalk::capture
