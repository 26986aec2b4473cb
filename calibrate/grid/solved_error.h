// How wrong the solved poses of a line are in common.
#pragma once

#include <span>
#include <vector>

#include "calibrate/grid/joint_estimate.h"
#include "calibrate/grid/prepared_rails.h"
#include "calibrate/grid/rotation_start.h"

namespace raywalk::calibrate {

// Bundle adjustment tells a station's error against its neighbours, but errors of the lens, of the
// stitching and of long chains of features move a line as a whole, and its sigmas do not know of
// it. Where matches at the crossings disagree with the solved poses by more than they scatter, the
// excess is put down to such motions, alike for all lines (the moment estimate of a variance
// between groups; DerSimonian and Laird 1986). `fitted` at the solved poses; zeros without
// crossings of solved lines.
SolvedLineError common_error(std::span<const FittedCrossing> fitted, const PreparedRails& prepared);

}  // namespace raywalk::calibrate
