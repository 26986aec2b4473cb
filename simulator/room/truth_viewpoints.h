// Viewpoints of the ground truth views of a virtual room.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "simulator/room/virtual_room.h"

namespace raywalk::capture {

struct TruthViewpoint {
  std::string name;                     // of its files
  Eigen::Vector3d position_m{0, 0, 0};  // world frame
};

// `count` viewpoints at the height of the lines, one cell after the other, spread over the grid.
// The first ten are the hard cases: the centre, four quarter points, near a corner, near two edges,
// on a line between two stations and on a station. The others are stratified random positions in a
// cell, determined by the seed. Cells in which the place is not free are passed over. A single line
// has viewpoints between its stations, half of them a little beside the line. Throws Error if a
// viewpoint has no free place in any cell.
std::vector<TruthViewpoint> truth_viewpoints(const VirtualRoom& room, int count);

// Reads a CSV table with columns name,x,z and optionally y (metres, default 0). Throws Error naming
// file and line if it has no rows, a name is not a valid file name or appears twice, or a number
// cannot be parsed.
std::vector<TruthViewpoint> read_truth_viewpoints(const std::filesystem::path& table);

}  // namespace raywalk::capture
