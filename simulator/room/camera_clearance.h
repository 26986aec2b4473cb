// Checks that cameras are in free space.
#pragma once

#include <Eigen/Core>

#include "simulator/room/room_plan.h"
#include "simulator/room/room_scene.h"

namespace raywalk::capture {

// Throws Error naming the position (metres) and the seed if it is not finite, outside the room or
// inside an object.
void require_free_camera(const RoomPlan& plan, const RoomScene& scene,
                         const Eigen::Vector3d& position_m);

// Throws Error naming station and seed if anything at camera height is nearer to a station than the
// plan's clearance.
void require_clear_lines(const RoomPlan& plan, const RoomScene& scene);

}  // namespace raywalk::capture
