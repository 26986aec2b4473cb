// Where lines start from when no poses were solved: moved and turned so that they agree, as nearly
// as they can, at all crossings.
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

// By line: how the start has it, averaged over its stations, against the plan.
struct LineMotion {
  Eigen::Vector3d rotation_rad{0, 0, 0};
  Eigen::Vector3d offset_m{0, 0, 0};
};
std::vector<LineMotion> motions_of_start(const CaptureSet& set, const FramePoses& start);

// Adds to each line that may move what the crossings ask for: least squares over the crossings'
// differences, of all solutions the smallest. So the mean over lines that are connected stays as it
// is, and a line that nothing connects stays where it is.
void agree_at_crossings(std::span<const FittedCrossing> crossings,
                        const std::vector<bool>& may_move, std::vector<LineMotion>* lines);

}  // namespace raywalk::calibrate
