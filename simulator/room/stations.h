// The capture grid of a virtual room: its lines and stations, with nominal and true poses.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/grid.h"
#include "simulator/room/cameras.h"
#include "simulator/room/room_settings.h"

namespace raywalk::simulator {

// One run of the slider; metres, from the middle of the grid.
struct PlannedLine {
  std::string id;  // as Line::id of core/geometry/grid.h
  LineAxis axis = LineAxis::kX;
  double across_m = 0.0;        // z of a line along x, x of a line along z
  std::vector<double> along_m;  // positions of its stations, increasing

  // In world axes.
  Eigen::Vector3d position_m(double at_along_m) const {
    return axis == LineAxis::kX ? Eigen::Vector3d(at_along_m, 0.0, across_m)
                                : Eigen::Vector3d(across_m, 0.0, at_along_m);
  }
};

// The lines, along x in order of z, then along z in order of x. Throws UsageError naming the key if
// a line would have more than 10,000 stations.
std::vector<PlannedLine> plan_lines(const GridSettings& grid);

struct RoomStation {
  std::string line;             // PlannedLine::id
  std::string name;             // "<line>_<number>", for example x0_007
  int number = 0;               // on its line, from 0
  CameraPose nominal{};         // on the grid, in world axes
  CameraPose true_pose{};       // nominal plus jitter
  double gain = 1.0;            // exposure, relative; 1 on average
  std::uint64_t noise_key = 0;  // for apply_sensor
};

// All stations, line by line. Jitter and gain are normally distributed and determined by the seed;
// the gain is clamped to a factor of 4.
std::vector<RoomStation> room_stations(const VirtualRoomSettings& settings);

}  // namespace raywalk::simulator
