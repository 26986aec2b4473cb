// The input of the joint estimate: every line fitted to its solved poses, where it has any, else
// moved and rotated to agree best at all crossings; and the error common to a line's solved poses.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calibrate/grid/crossing_fit.h"
#include "calibrate/grid/joint_estimate.h"
#include "calibrate/grid/rail_fit.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

struct PreparedRails {
  std::vector<RailStart> rails{};                  // by line
  std::vector<std::vector<RailSample>> samples{};  // by line, without those rejected
  std::vector<std::optional<RailFit>> fits{};      // by line, nullopt without solved poses
  std::vector<std::vector<int>> rejected{};        // by line, frames
  FramePoses solved{};                             // without those rejected, sigmas set
};

// `solved` are in the world. A pose without sigmas gets the smallest plausible ones: a tenth of a
// pixel, and a two-hundredth of the stations' spacing.
PreparedRails prepare_rails(const CaptureSet& set, const FramePoses& solved,
                            const FramePoses& start, const GridScale& scale);

// Initial poses: a station's solved pose, else the prediction of its rail.
FramePoses poses_on_rails(const CaptureSet& set, const std::vector<RailStart>& rails,
                          const FramePoses& solved);

struct FittedCrossing {
  LineCrossing crossing{};
  CrossingFit fit{};
};

// The rigid motion of a line from the plan to the start, averaged over its stations; by line.
struct LineMotion {
  Eigen::Vector3d rotation_rad{0, 0, 0};
  Eigen::Vector3d offset_m{0, 0, 0};
};

// Adds to each line of `may_move` the motion that reduces the crossings' differences: the
// minimum-norm least-squares solution. So the mean motion of connected lines stays the same, and an
// unconnected line does not move.
void align_at_crossings(std::span<const FittedCrossing> crossings,
                        const std::vector<bool>& may_move, std::vector<LineMotion>* lines);

// Sigmas of bundle adjustment describe a station's error relative to its neighbours. Errors of the
// lens, of the stitching and of long chains of features move a line as a whole and are not in them.
// Where matches at the crossings disagree with the solved poses by more than their scatter, the
// excess is attributed to such motions, with one variance for all lines (the moment estimate of a
// between-group variance; DerSimonian and Laird 1986). `fitted` is at the solved poses. Zeros
// without crossings of solved lines.
SolvedLineError common_error(std::span<const FittedCrossing> fitted, const PreparedRails& prepared);

}  // namespace raywalk::calibrate
