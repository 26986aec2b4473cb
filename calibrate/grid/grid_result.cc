#include "calibrate/grid/grid_result.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "calibrate/grid/line_summary.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::ordered_json;

constexpr int kFormatVersion = 1;

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

ordered_json deviations_json(const CaptureSet& set, const LineFit& line, const FramePoses& poses) {
  ordered_json stations = ordered_json::array();
  for (const RailDeviation& off : rail_deviations(set, line, poses)) {
    stations.push_back({{"name", set.frames[static_cast<size_t>(off.frame)].name},
                        {"rail_m", set.rail_m(off.frame)},
                        {"along_mm", off.position_mm.x()},
                        {"across_mm", off.position_mm.y()},
                        {"up_mm", off.position_mm.z()},
                        {"about_x_deg", off.rotation_deg.x()},
                        {"about_y_deg", off.rotation_deg.y()},
                        {"about_z_deg", off.rotation_deg.z()}});
  }
  return {{"line", line.id}, {"stations", stations}};
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
  return {{"format_version", kFormatVersion},
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

}  // namespace raywalk::calibrate
