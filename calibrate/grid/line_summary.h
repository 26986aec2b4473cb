// A line's estimate as it is reported.
#pragma once

#include "calibrate/grid/grid_result.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

// Fills in what follows from the parameters (metres, radians) and their covariance: everything of
// LineFit from middle_m to covariance.
void describe_rail(const RailFrame& frame, const RailParameters& parameters,
                   const Eigen::Matrix<double, kRigidParameters, kRigidParameters>& covariance,
                   LineFit* line);

// The parameters that a reported line was described from.
RailParameters rail_parameters(const RailFrame& frame, const LineFit& line);

}  // namespace raywalk::calibrate
