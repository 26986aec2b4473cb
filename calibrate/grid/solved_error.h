// The error that is common to the solved poses of a line.
#pragma once

#include <span>
#include <vector>

#include "calibrate/grid/joint_estimate.h"
#include "calibrate/grid/prepared_rails.h"
#include "calibrate/grid/rotation_start.h"

namespace raywalk::calibrate {

// Sigmas of bundle adjustment describe a station's error relative to its neighbours. Errors of the
// lens, of the stitching and of long chains of features move a line as a whole and are not in them.
// Where matches at the crossings disagree with the solved poses by more than their scatter, the
// excess is attributed to such motions, with one variance for all lines (the moment estimate of a
// between-group variance; DerSimonian and Laird 1986). `fitted` is at the solved poses. Zeros
// without crossings of solved lines.
SolvedLineError common_error(std::span<const FittedCrossing> fitted, const PreparedRails& prepared);

}  // namespace raywalk::calibrate
