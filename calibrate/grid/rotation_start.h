// Initial poses of the lines when none were solved: moved and rotated to agree best at all
// crossings.
#pragma once

#include <span>
#include <vector>

#include "calibrate/grid/crossing_fit.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

struct FittedCrossing {
  LineCrossing crossing{};
  CrossingFit fit{};
};

// The rigid motion of a line from the plan to the start, averaged over its stations; by line.
struct LineMotion {
  Eigen::Vector3d rotation_rad{0, 0, 0};
  Eigen::Vector3d offset_m{0, 0, 0};
};
std::vector<LineMotion> motions_of_start(const CaptureSet& set, const FramePoses& start);

// Adds to each line of `may_move` the motion that reduces the crossings' differences: the
// minimum-norm least-squares solution. So the mean motion of connected lines stays the same, and an
// unconnected line does not move.
void align_at_crossings(std::span<const FittedCrossing> crossings,
                        const std::vector<bool>& may_move, std::vector<LineMotion>* lines);

}  // namespace raywalk::calibrate
