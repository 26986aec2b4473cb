// The stations of a virtual room's grid: nominal and true poses.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "simulator/room/camera_pose.h"
#include "simulator/room/room_plan.h"

namespace raywalk::capture {

struct RoomStation {
  std::string line;             // PlannedLine::id
  std::string name;             // "<line>_<number>", for example x0_007
  int number = 0;               // on its line, from 0
  CameraPose nominal{};         // on the grid, in world axes
  CameraPose true_pose{};       // nominal plus jitter
  double gain = 1.0;            // exposure, relative; 1 on average
  std::uint64_t noise_key = 0;  // for apply_sensor
};

// All stations, line by line in the order of RoomPlan::lines. Jitter and gain are normally
// distributed and determined by the seed; the gain is clamped to a factor of 4.
std::vector<RoomStation> room_stations(const RoomPlan& plan, const VirtualRoomSettings& settings);

}  // namespace raywalk::capture
