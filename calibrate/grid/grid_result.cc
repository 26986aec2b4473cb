#include "calibrate/grid/grid_result.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "calibrate/base/frame_poses_json.h"
#include "calibrate/grid/line_summary.h"
#include "core/base/error.h"
#include "core/files/checked_json.h"

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

ordered_json largest_json(const std::vector<CrossingFigures>& crossings) {
  if (crossings.empty()) return nullptr;
  const auto json_when = [&](Disagreement CrossingFigures::*when) -> ordered_json {
    const LargestDisagreement largest = largest_disagreement(crossings, when);
    return {{"position_mm", largest.position_mm}, {"rotation_px", largest.rotation_px}};
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

template <typename Vector>
void read(const CheckedJson& array, Vector* vector) {
  const std::vector<CheckedJson> items = array.items(static_cast<size_t>(vector->size()));
  for (size_t i = 0; i < items.size(); ++i) {
    (*vector)[static_cast<Eigen::Index>(i)] = items[i].number();
  }
}

void read(const CheckedJson& object, Estimate* estimate) {
  estimate->value = object.at("value").number();
  estimate->sigma = object.at("sigma").number();
}

std::vector<RailModelScore> models_of(const CheckedJson& array) {
  std::vector<RailModelScore> models;
  for (const CheckedJson& model : array.items()) {
    models.push_back({.name = model.at("name").text(),
                      .parameters = model.at("parameters").integer(),
                      .residual = model.at("residual").number(),
                      .left_out = model.at("left_out").number(),
                      .bic = model.at("bic").number(),
                      .kept = model.at("kept").boolean()});
  }
  return models;
}

Disagreement disagreement_of(const CheckedJson& object) {
  return {.median_px = object.at("median_px").number(),
          .position_mm = object.at("position_mm").number(),
          .position_sigma_mm = object.at("position_sigma_mm").number(),
          .rotation_deg = object.at("rotation_deg").number(),
          .rotation_sigma_deg = object.at("rotation_sigma_deg").number(),
          .rotation_px = object.at("rotation_px").number()};
}

int line_of(const CaptureSet& set, const CheckedJson& id) {
  const std::optional<int> line = set.find_line(id.text());
  if (!line) id.fail("line " + excerpt(id.text()) + " is not in the capture");
  return *line;
}

LineFit line_fit_of(const CaptureSet& set, const CheckedJson& object) {
  LineFit line{.line = line_of(set, object.at("id")),
               .id = object.at("id").text(),
               .stations = object.at("stations").integer(),
               .solved_stations = object.at("solved_stations").integer(),
               .connected = object.at("connected").boolean(),
               .middle_m = object.at("middle_m").number(),
               .half_length_m = object.at("half_length_m").number()};
  for (const CheckedJson& name : object.at("rejected").items()) {
    const std::optional<int> frame = set.find(name.text());
    if (!frame) name.fail("frame " + excerpt(name.text()) + " is not in the capture");
    line.rejected_frames.push_back(*frame);
  }
  read(object.at("origin_m"), &line.origin_m);
  read(object.at("direction"), &line.direction);
  read(object.at("rotation_deg"), &line.rotation_deg);
  for (size_t i = 0; i < 2; ++i) {
    read(object.at("bow_mm").items(2)[i], &line.bow_mm[i]);
    read(object.at("twist_deg").items(2)[i], &line.twist_deg[i]);
  }
  read(object.at("along_mm"), &line.along_mm);
  read(object.at("across_mm"), &line.across_mm);
  read(object.at("height_mm"), &line.height_mm);
  read(object.at("heading_deg"), &line.heading_deg);
  read(object.at("tilt_deg"), &line.tilt_deg);
  read(object.at("yaw_deg"), &line.yaw_deg);
  read(object.at("pitch_deg"), &line.pitch_deg);
  read(object.at("roll_deg"), &line.roll_deg);
  const std::vector<CheckedJson> covariance =
      object.at("covariance").items(static_cast<size_t>(line.covariance.rows()));
  for (Eigen::Index row = 0; row < line.covariance.rows(); ++row) {
    Eigen::Matrix<double, 8, 1> values;
    read(covariance[static_cast<size_t>(row)], &values);
    line.covariance.row(row) = values.transpose();
  }
  line.jitter_along_mm = object.at("jitter_along_mm").number();
  line.jitter_mm = object.at("jitter_mm").number();
  line.jitter_deg = object.at("jitter_deg").number();
  line.position_models = models_of(object.at("position_models"));
  line.rotation_models = models_of(object.at("rotation_models"));
  return line;
}

CrossingFigures crossing_of(const CaptureSet& set, const CheckedJson& object) {
  return {.along_x = line_of(set, object.at("along_x")),
          .along_z = line_of(set, object.at("along_z")),
          .at = {object.at("x_m").number(), object.at("z_m").number()},
          .matches = object.at("matches").integer(),
          .held_out_matches = object.at("held_out_matches").integer(),
          .noise_px = object.at("noise_px").number(),
          .before = disagreement_of(object.at("before")),
          .after = disagreement_of(object.at("after")),
          .correction_mm = object.at("correction_mm").number(),
          .correction_deg = object.at("correction_deg").number(),
          .correction_px = object.at("correction_px").number(),
          .sigma_mm = object.at("sigma_mm").number(),
          .sigma_deg = object.at("sigma_deg").number(),
          .sigma_px = object.at("sigma_px").number(),
          .split_half_mm = object.at("split_half_mm").number(),
          .split_half_expected_mm = object.at("split_half_expected_mm").number(),
          .split_half_deg = object.at("split_half_deg").number(),
          .split_half_expected_deg = object.at("split_half_expected_deg").number(),
          .trustworthy = object.at("trustworthy").boolean(),
          .warnings = object.at("warnings").texts()};
}

GridMethod method_of(const CheckedJson& name) {
  if (name.text() == "poses") return GridMethod::kPoses;
  if (name.text() == "rotation") return GridMethod::kRotation;
  name.fail("unknown method " + excerpt(name.text()));
}

GridResult result_of(const CaptureSet& set, const CheckedJson& root) {
  GridResult result{.method = method_of(root.at("method")),
                    .scale = root.at("scale").number(),
                    .solved_line_error_mm = root.at("solved_line_error_mm").number(),
                    .solved_line_error_deg = root.at("solved_line_error_deg").number(),
                    .warnings = root.at("warnings").texts(),
                    .notes = root.at("notes").texts(),
                    .trustworthy = root.at("trustworthy").boolean()};
  for (const CheckedJson& line : root.at("lines").items()) {
    result.lines.push_back(line_fit_of(set, line));
  }
  for (const CheckedJson& crossing : root.at("crossings").items()) {
    result.crossings.push_back(crossing_of(set, crossing));
  }
  return result;
}

}  // namespace

LargestDisagreement largest_disagreement(const std::vector<CrossingFigures>& crossings,
                                         Disagreement CrossingFigures::*when) {
  LargestDisagreement largest;
  for (const CrossingFigures& crossing : crossings) {
    const Disagreement& figures = crossing.*when;
    largest.position_mm = std::max(largest.position_mm, figures.position_mm);
    largest.rotation_px = std::max(largest.rotation_px, figures.rotation_px);
  }
  return largest;
}

ordered_json crossings_json(const CaptureSet& set, const std::vector<CrossingFigures>& crossings) {
  ordered_json list = ordered_json::array();
  for (const CrossingFigures& crossing : crossings) list.push_back(json_of(set, crossing));
  return list;
}

ordered_json grid_document(const CaptureSet& set, const GridResult& result) {
  ordered_json lines = ordered_json::array(), deviations = ordered_json::array();
  for (const LineFit& line : result.lines) {
    lines.push_back(json_of(set, line));
    deviations.push_back(deviations_json(set, line, result.poses));
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
          {"crossings", crossings_json(set, result.crossings)},
          {"deviations", deviations},
          {"frames", frame_poses_json(set, result.poses)}};
}

GridResult read_grid_result(const std::filesystem::path& file, const CaptureSet& set) {
  const auto root = CheckedJson::read(file, "run raywalk-calibrate grid again");
  root.require_version(kFormatVersion);
  GridResult result = result_of(set, root);
  result.poses = frame_poses_in(root.at("frames"), set);
  for (size_t i = 0; i < result.poses.size(); ++i) {
    if (!result.poses[i] && !set.frames[i].held_out())
      root.fail("frame " + excerpt(set.frames[i].name) + " has no pose");
  }
  return result;
}

}  // namespace raywalk::calibrate
