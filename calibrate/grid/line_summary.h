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

// By how much a station's pose deviates from the fitted rail.
struct RailDeviation {
  int frame = 0;                          // index into CaptureSet::frames
  Eigen::Vector3d position_mm{0, 0, 0};   // along, across and above the rail
  Eigen::Vector3d rotation_deg{0, 0, 0};  // rotation vector, world axes
};
// Of every station of the line, each of which has a pose.
std::vector<RailDeviation> rail_deviations(const CaptureSet& set, const LineFit& line,
                                           const FramePoses& poses);

}  // namespace raywalk::calibrate
