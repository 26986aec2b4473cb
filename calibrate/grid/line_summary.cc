#include "calibrate/grid/line_summary.h"

#include <algorithm>
#include <cmath>

namespace raywalk::calibrate {
namespace {

using P = RailParameter;

double sigma_along(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& direction) {
  return std::sqrt(std::max(0.0, direction.dot(covariance * direction)));
}

Eigen::Vector3d three(const RailParameters& parameters, size_t first) {
  return {parameters[first], parameters[first + 1], parameters[first + 2]};
}

}  // namespace

void describe_rail(const RailFrame& frame, const RailParameters& parameters,
                   const Eigen::Matrix<double, kRigidParameters, kRigidParameters>& covariance,
                   LineFit* line) {
  const RailAxes<double> axes =
      rail_axes(frame.axis, parameters[P::kHeading], parameters[P::kTilt]);
  const Eigen::Vector3d offset_m = three(parameters, P::kOffset);
  const Eigen::Vector3d rotation_rad = three(parameters, P::kRotation);
  line->middle_m = frame.rail_middle_m;
  line->half_length_m = frame.half_length_m;
  line->origin_m = frame.middle_m + offset_m;
  line->direction = axes.direction;
  line->rotation_deg = rotation_rad * degrees_from_radians(1.0);
  for (size_t i = 0; i < 2; ++i) {
    const size_t bow = P::kBow + 2 * i;
    line->bow_mm[i] = 1e3 * Eigen::Vector2d(parameters[bow], parameters[bow + 1]);
    line->twist_deg[i] = three(parameters, P::kTwist + 3 * i) * degrees_from_radians(1.0);
  }

  // In the axes without heading and tilt, so that along, across and height refer to the plan.
  const RailAxes<double> planned = rail_axes(frame.axis, 0.0, 0.0);
  const Eigen::Matrix3d offset_covariance = covariance.topLeftCorner<3, 3>();
  const auto offset_mm = [&](const Eigen::Vector3d& direction) {
    return Estimate{1e3 * offset_m.dot(direction), 1e3 * sigma_along(offset_covariance, direction)};
  };
  line->along_mm = offset_mm(planned.direction);
  line->across_mm = offset_mm(planned.across);
  line->height_mm = offset_mm(planned.up);
  const auto angle_deg = [&](double value_rad, int parameter) {
    return Estimate{
        degrees_from_radians(value_rad),
        degrees_from_radians(std::sqrt(std::max(0.0, covariance(parameter, parameter))))};
  };
  line->heading_deg = angle_deg(parameters[P::kHeading], P::kHeading);
  line->tilt_deg = angle_deg(parameters[P::kTilt], P::kTilt);
  // Yaw is about y, pitch about -x and roll about -z; the sign does not affect sigmas.
  const Attitude attitude = attitude_from_world_from_camera(matrix_of(rotation_rad));
  line->yaw_deg = angle_deg(attitude.yaw_rad, P::kRotation + 1);
  line->pitch_deg = angle_deg(attitude.pitch_rad, P::kRotation);
  line->roll_deg = angle_deg(attitude.roll_rad, P::kRotation + 2);

  Eigen::Matrix<double, kRigidParameters, 1> units;
  units << Eigen::Vector3d::Constant(1e3),
      Eigen::Matrix<double, 5, 1>::Constant(degrees_from_radians(1.0));
  line->covariance = units.asDiagonal() * covariance * units.asDiagonal();
}

RailParameters rail_parameters(const RailFrame& frame, const LineFit& line) {
  RailParameters parameters{};
  const auto store = [&](size_t first, const Eigen::Vector3d& values) {
    std::copy_n(values.data(), 3, parameters.begin() + static_cast<std::ptrdiff_t>(first));
  };
  store(P::kOffset, line.origin_m - frame.middle_m);
  parameters[P::kHeading] = radians_from_degrees(line.heading_deg.value);
  parameters[P::kTilt] = radians_from_degrees(line.tilt_deg.value);
  store(P::kRotation, line.rotation_deg * radians_from_degrees(1.0));
  for (size_t i = 0; i < 2; ++i) {
    parameters[P::kBow + 2 * i] = 1e-3 * line.bow_mm[i].x();
    parameters[P::kBow + 2 * i + 1] = 1e-3 * line.bow_mm[i].y();
    store(P::kTwist + 3 * i, line.twist_deg[i] * radians_from_degrees(1.0));
  }
  return parameters;
}

std::vector<RailDeviation> rail_deviations(const CaptureSet& set, const LineFit& line,
                                           const FramePoses& poses) {
  const RailFrame frame = rail_frame(set, line.line);
  const RailParameters parameters = rail_parameters(frame, line);
  const RailAxes<double> axes =
      rail_axes(frame.axis, parameters[P::kHeading], parameters[P::kTilt]);
  std::vector<RailDeviation> deviations;
  for (const int index : set.lines[static_cast<size_t>(line.line)].frames) {
    const FramePose& pose = *poses[static_cast<size_t>(index)];
    const double rail_m = set.rail_m(index);
    const Eigen::Vector3d off_m = pose.position_m - rail_position(frame, parameters.data(), rail_m);
    const Eigen::Matrix3d expected = matrix_of(rail_rotation(frame, parameters.data(), rail_m)) *
                                     planned_attitude(set.frames[static_cast<size_t>(index)]);
    deviations.push_back(
        {.frame = index,
         .position_mm = 1e3 * Eigen::Vector3d(off_m.dot(axes.direction), off_m.dot(axes.across),
                                              off_m.dot(axes.up)),
         .rotation_deg =
             degrees_from_radians(1.0) * vector_of(pose.world_from_camera * expected.transpose())});
  }
  return deviations;
}

}  // namespace raywalk::calibrate
