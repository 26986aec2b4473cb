// Where in a virtual room the truth is shown, for views to be compared with.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/simulated/virtual_room/room_plan.h"

namespace raywalk::capture {

struct TruthViewpoint {
  std::string name;                     // of its files
  Eigen::Vector3d position_m{0, 0, 0};  // world frame
};

// `count` viewpoints at the height of the lines, spread over the cells by the seed. The first ten
// are the hard cases: a centre, four quarters, near a corner, near two edges, on a line between two
// stations and on a station; the others are drawn freely from the strata of a cell.
std::vector<TruthViewpoint> truth_viewpoints(const RoomPlan& plan, int count);

// Reads a table with columns name,x,z and optionally y (metres). Throws Error naming table and
// line: no rows, a name that cannot be a file's or appears twice, a number that is none.
std::vector<TruthViewpoint> read_truth_viewpoints(const std::filesystem::path& table);

}  // namespace raywalk::capture
