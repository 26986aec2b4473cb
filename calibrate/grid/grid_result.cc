#include "calibrate/grid/grid_result.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;
using P = RailParameter;

constexpr int kGridVersion = 1;

template <typename Vector>
ordered_json json_of(const Eigen::MatrixBase<Vector>& vector) {
  ordered_json array = ordered_json::array();
  for (Eigen::Index i = 0; i < vector.size(); ++i) array.push_back(vector[i]);
  return array;
}

ordered_json json_of(const Estimate& estimate) {
  return {{"value", estimate.value}, {"sigma", estimate.sigma}};
}

ordered_json json_of(const std::vector<RailModelScore>& models) {
  ordered_json array = ordered_json::array();
  for (const RailModelScore& model : models) {
    array.push_back({{"name", model.name},
                     {"parameters", model.parameters},
                     {"residual", model.residual},
                     {"left_out", model.left_out},
                     {"bic", model.bic},
                     {"kept", model.kept}});
  }
  return array;
}

ordered_json kept_name(const std::vector<RailModelScore>& models) {
  const auto kept = std::ranges::find(models, true, &RailModelScore::kept);
  return kept == models.end() ? ordered_json(nullptr) : ordered_json(kept->name);
}

ordered_json json_of(const Disagreement& disagreement) {
  return {{"median_px", disagreement.median_px},
          {"position_mm", disagreement.position_mm},
          {"position_sigma_mm", disagreement.position_sigma_mm},
          {"rotation_deg", disagreement.rotation_deg},
          {"rotation_sigma_deg", disagreement.rotation_sigma_deg},
          {"rotation_px", disagreement.rotation_px}};
}

ordered_json json_of(const CaptureSet& set, const LineFit& line) {
  ordered_json rejected = ordered_json::array();
  for (const int frame : line.rejected_frames) {
    rejected.push_back(set.frames[static_cast<size_t>(frame)].name);
  }
  ordered_json covariance = ordered_json::array();
  for (Eigen::Index row = 0; row < line.covariance.rows(); ++row) {
    covariance.push_back(json_of(line.covariance.row(row)));
  }
  return {{"id", line.id},
          {"stations", line.stations},
          {"solved_stations", line.solved_stations},
          {"rejected", rejected},
          {"connected", line.connected},
          {"middle_m", line.middle_m},
          {"half_length_m", line.half_length_m},
          {"origin_m", json_of(line.origin_m)},
          {"direction", json_of(line.direction)},
          {"bow_mm", {json_of(line.bow_mm[0]), json_of(line.bow_mm[1])}},
          {"rotation_deg", json_of(line.rotation_deg)},
          {"twist_deg", {json_of(line.twist_deg[0]), json_of(line.twist_deg[1])}},
          {"along_mm", json_of(line.along_mm)},
          {"across_mm", json_of(line.across_mm)},
          {"height_mm", json_of(line.height_mm)},
          {"heading_deg", json_of(line.heading_deg)},
          {"tilt_deg", json_of(line.tilt_deg)},
          {"yaw_deg", json_of(line.yaw_deg)},
          {"pitch_deg", json_of(line.pitch_deg)},
          {"roll_deg", json_of(line.roll_deg)},
          {"covariance", covariance},
          {"jitter_along_mm", line.jitter_along_mm},
          {"jitter_mm", line.jitter_mm},
          {"jitter_deg", line.jitter_deg},
          {"position_model", kept_name(line.position_models)},
          {"rotation_model", kept_name(line.rotation_models)},
          {"position_models", json_of(line.position_models)},
          {"rotation_models", json_of(line.rotation_models)}};
}

ordered_json json_of(const CaptureSet& set, const CrossingFigures& crossing) {
  return {{"along_x", set.lines[static_cast<size_t>(crossing.along_x)].id},
          {"along_z", set.lines[static_cast<size_t>(crossing.along_z)].id},
          {"x_m", crossing.at.x_m},
          {"z_m", crossing.at.z_m},
          {"matches", crossing.matches},
          {"held_out_matches", crossing.held_out_matches},
          {"noise_px", crossing.noise_px},
          {"before", json_of(crossing.before)},
          {"after", json_of(crossing.after)},
          {"correction_mm", crossing.correction_mm},
          {"correction_deg", crossing.correction_deg},
          {"correction_px", crossing.correction_px},
          {"sigma_mm", crossing.sigma_mm},
          {"sigma_deg", crossing.sigma_deg},
          {"sigma_px", crossing.sigma_px},
          {"split_half_mm", crossing.split_half_mm},
          {"split_half_expected_mm", crossing.split_half_expected_mm},
          {"split_half_deg", crossing.split_half_deg},
          {"split_half_expected_deg", crossing.split_half_expected_deg},
          {"trustworthy", crossing.trustworthy},
          {"warnings", crossing.warnings}};
}

// Of two lines at a crossing; null without crossings.
ordered_json largest_json(const std::vector<CrossingFigures>& crossings) {
  if (crossings.empty()) return nullptr;
  const auto json_when = [&](Disagreement CrossingFigures::*when) -> ordered_json {
    double position_mm = 0.0, rotation_px = 0.0;
    for (const CrossingFigures& crossing : crossings) {
      position_mm = std::max(position_mm, (crossing.*when).position_mm);
      rotation_px = std::max(rotation_px, (crossing.*when).rotation_px);
    }
    return {{"position_mm", position_mm}, {"rotation_px", rotation_px}};
  };
  return {{"before", json_when(&CrossingFigures::before)},
          {"after", json_when(&CrossingFigures::after)}};
}

// By how much the pose of every station of the line deviates from the fitted rail. Each has a pose.
ordered_json deviations_json(const CaptureSet& set, const LineFit& line, const FramePoses& poses) {
  const RailFrame frame = rail_frame(set, line.line);
  const RailParameters parameters = rail_parameters(frame, line);
  const RailAxes<double> axes =
      rail_axes(frame.axis, parameters[P::kHeading], parameters[P::kTilt]);
  ordered_json stations = ordered_json::array();
  for (const int index : set.lines[static_cast<size_t>(line.line)].frames) {
    const CaptureFrame& station = set.frames[static_cast<size_t>(index)];
    const FramePose& pose = *poses[static_cast<size_t>(index)];
    const double rail_m = set.rail_m(index);
    const Eigen::Vector3d off_m = pose.position_m - rail_position(frame, parameters.data(), rail_m);
    const Eigen::Matrix3d expected =
        matrix_of(rail_rotation(frame, parameters.data(), rail_m)) * planned_attitude(station);
    const Eigen::Vector3d turned_deg =
        degrees_from_radians(1.0) * vector_of(pose.world_from_camera * expected.transpose());
    stations.push_back({{"name", station.name},
                        {"rail_m", rail_m},
                        {"along_mm", 1e3 * off_m.dot(axes.direction)},
                        {"across_mm", 1e3 * off_m.dot(axes.across)},
                        {"up_mm", 1e3 * off_m.dot(axes.up)},
                        {"about_x_deg", turned_deg.x()},
                        {"about_y_deg", turned_deg.y()},
                        {"about_z_deg", turned_deg.z()}});
  }
  return {{"line", line.id}, {"stations", stations}};
}

double sigma_along(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& direction) {
  return std::sqrt(std::max(0.0, direction.dot(covariance * direction)));
}

Eigen::Vector3d three(const RailParameters& parameters, size_t first) {
  return {parameters[first], parameters[first + 1], parameters[first + 2]};
}

}  // namespace

ordered_json grid_document(const CaptureSet& set, const GridResult& result) {
  ordered_json lines = ordered_json::array(), deviations = ordered_json::array();
  ordered_json crossings = ordered_json::array();
  for (const LineFit& line : result.lines) {
    lines.push_back(json_of(set, line));
    deviations.push_back(deviations_json(set, line, result.poses));
  }
  for (const CrossingFigures& crossing : result.crossings) {
    crossings.push_back(json_of(set, crossing));
  }
  return {{"format_version", kGridVersion},
          {"source", set.source.string()},
          {"stations", set.stations()},
          {"method", result.method == GridMethod::kPoses ? "poses" : "rotation"},
          {"trustworthy", result.trustworthy},
          {"warnings", result.warnings},
          {"notes", result.notes},
          {"scale", result.scale},
          {"solved_line_error_mm", result.solved_line_error_mm},
          {"solved_line_error_deg", result.solved_line_error_deg},
          {"largest_disagreement", largest_json(result.crossings)},
          {"lines", lines},
          {"crossings", crossings},
          {"deviations", deviations},
          {"frames", frame_poses_json(set, result.poses)}};
}

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

}  // namespace raywalk::calibrate
