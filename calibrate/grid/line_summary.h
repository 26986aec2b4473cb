// The reported figures of a line.
#pragma once

#include "calibrate/grid/grid_result.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

// Fills in the members of LineFit from middle_m to covariance, from the parameters (metres,
// radians) and their covariance.
void describe_rail(const RailFrame& frame, const RailParameters& parameters,
                   const Eigen::Matrix<double, kRigidParameters, kRigidParameters>& covariance,
                   LineFit* line);

// The inverse of describe_rail: the parameters of a reported line.
RailParameters rail_parameters(const RailFrame& frame, const LineFit& line);

}  // namespace raywalk::calibrate
