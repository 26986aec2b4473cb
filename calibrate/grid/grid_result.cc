#include "calibrate/grid/grid_result.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "calibrate/base/frame_poses_json.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"

namespace raywalk::calibrate {
namespace {

using nlohmann::json;
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

// nlohmann's exceptions name the key that is missing or of another type.
template <typename Vector>
void read(const json& array, Vector* vector) {
  if (array.size() != static_cast<size_t>(vector->size()))
    throw Error("an array has the wrong length");
  for (Eigen::Index i = 0; i < vector->size(); ++i) {
    (*vector)[i] = array.at(static_cast<size_t>(i)).get<double>();
  }
}

void read(const json& object, Estimate* estimate) {
  estimate->value = object.at("value").get<double>();
  estimate->sigma = object.at("sigma").get<double>();
}

std::vector<RailModelScore> models_of(const json& array) {
  std::vector<RailModelScore> models;
  for (const json& model : array) {
    models.push_back({.name = model.at("name").get<std::string>(),
                      .parameters = model.at("parameters").get<int>(),
                      .residual = model.at("residual").get<double>(),
                      .left_out = model.at("left_out").get<double>(),
                      .bic = model.at("bic").get<double>(),
                      .kept = model.at("kept").get<bool>()});
  }
  return models;
}

Disagreement disagreement_of(const json& object) {
  return {.median_px = object.at("median_px").get<double>(),
          .position_mm = object.at("position_mm").get<double>(),
          .position_sigma_mm = object.at("position_sigma_mm").get<double>(),
          .rotation_deg = object.at("rotation_deg").get<double>(),
          .rotation_sigma_deg = object.at("rotation_sigma_deg").get<double>(),
          .rotation_px = object.at("rotation_px").get<double>()};
}

int line_of(const CaptureSet& set, const std::string& id) {
  for (size_t i = 0; i < set.lines.size(); ++i) {
    if (set.lines[i].id == id) return static_cast<int>(i);
  }
  throw Error("line " + excerpt(id) + " is not in the capture");
}

LineFit line_of(const CaptureSet& set, const json& object) {
  LineFit line{.line = line_of(set, object.at("id").get<std::string>()),
               .id = object.at("id").get<std::string>(),
               .stations = object.at("stations").get<int>(),
               .solved_stations = object.at("solved_stations").get<int>(),
               .connected = object.at("connected").get<bool>(),
               .middle_m = object.at("middle_m").get<double>(),
               .half_length_m = object.at("half_length_m").get<double>()};
  for (const json& name : object.at("rejected")) {
    const std::optional<int> frame = set.find(name.get<std::string>());
    if (!frame) throw Error("frame " + excerpt(name.get<std::string>()) + " is not in the capture");
    line.rejected_frames.push_back(*frame);
  }
  read(object.at("origin_m"), &line.origin_m);
  read(object.at("direction"), &line.direction);
  read(object.at("rotation_deg"), &line.rotation_deg);
  for (size_t i = 0; i < 2; ++i) {
    read(object.at("bow_mm").at(i), &line.bow_mm[i]);
    read(object.at("twist_deg").at(i), &line.twist_deg[i]);
  }
  read(object.at("along_mm"), &line.along_mm);
  read(object.at("across_mm"), &line.across_mm);
  read(object.at("height_mm"), &line.height_mm);
  read(object.at("heading_deg"), &line.heading_deg);
  read(object.at("tilt_deg"), &line.tilt_deg);
  read(object.at("yaw_deg"), &line.yaw_deg);
  read(object.at("pitch_deg"), &line.pitch_deg);
  read(object.at("roll_deg"), &line.roll_deg);
  for (Eigen::Index row = 0; row < line.covariance.rows(); ++row) {
    Eigen::Matrix<double, 8, 1> values;
    read(object.at("covariance").at(static_cast<size_t>(row)), &values);
    line.covariance.row(row) = values.transpose();
  }
  line.jitter_along_mm = object.at("jitter_along_mm").get<double>();
  line.jitter_mm = object.at("jitter_mm").get<double>();
  line.jitter_deg = object.at("jitter_deg").get<double>();
  line.position_models = models_of(object.at("position_models"));
  line.rotation_models = models_of(object.at("rotation_models"));
  return line;
}

CrossingFigures crossing_of(const CaptureSet& set, const json& object) {
  return {.along_x = line_of(set, object.at("along_x").get<std::string>()),
          .along_z = line_of(set, object.at("along_z").get<std::string>()),
          .at = {object.at("x_m").get<double>(), object.at("z_m").get<double>()},
          .matches = object.at("matches").get<int>(),
          .held_out_matches = object.at("held_out_matches").get<int>(),
          .noise_px = object.at("noise_px").get<double>(),
          .before = disagreement_of(object.at("before")),
          .after = disagreement_of(object.at("after")),
          .correction_mm = object.at("correction_mm").get<double>(),
          .correction_deg = object.at("correction_deg").get<double>(),
          .correction_px = object.at("correction_px").get<double>(),
          .sigma_mm = object.at("sigma_mm").get<double>(),
          .sigma_deg = object.at("sigma_deg").get<double>(),
          .sigma_px = object.at("sigma_px").get<double>(),
          .split_half_mm = object.at("split_half_mm").get<double>(),
          .split_half_expected_mm = object.at("split_half_expected_mm").get<double>(),
          .split_half_deg = object.at("split_half_deg").get<double>(),
          .split_half_expected_deg = object.at("split_half_expected_deg").get<double>(),
          .trustworthy = object.at("trustworthy").get<bool>(),
          .warnings = object.at("warnings").get<std::vector<std::string>>()};
}

GridMethod method_of(const std::string& name) {
  if (name == "poses") return GridMethod::kPoses;
  if (name == "rotation") return GridMethod::kRotation;
  throw Error("unknown method " + excerpt(name));
}

GridResult result_of(const CaptureSet& set, const json& root) {
  GridResult result{.method = method_of(root.at("method").get<std::string>()),
                    .scale = root.at("scale").get<double>(),
                    .solved_line_error_mm = root.at("solved_line_error_mm").get<double>(),
                    .solved_line_error_deg = root.at("solved_line_error_deg").get<double>(),
                    .warnings = root.at("warnings").get<std::vector<std::string>>(),
                    .notes = root.at("notes").get<std::vector<std::string>>(),
                    .trustworthy = root.at("trustworthy").get<bool>()};
  for (const json& line : root.at("lines")) result.lines.push_back(line_of(set, line));
  for (const json& crossing : root.at("crossings")) {
    result.crossings.push_back(crossing_of(set, crossing));
  }
  return result;
}

}  // namespace

void write_grid_result(const std::filesystem::path& file, const CaptureSet& set,
                       const GridResult& result) {
  ordered_json root{{"format_version", kFormatVersion},
                    {"method", result.method == GridMethod::kPoses ? "poses" : "rotation"},
                    {"trustworthy", result.trustworthy},
                    {"warnings", result.warnings},
                    {"notes", result.notes},
                    {"scale", result.scale},
                    {"solved_line_error_mm", result.solved_line_error_mm},
                    {"solved_line_error_deg", result.solved_line_error_deg},
                    {"lines", ordered_json::array()},
                    {"crossings", ordered_json::array()}};
  for (const LineFit& line : result.lines) root["lines"].push_back(json_of(set, line));
  for (const CrossingFigures& crossing : result.crossings) {
    root["crossings"].push_back(json_of(set, crossing));
  }
  root["frames"] = frame_poses_json(set, result.poses);
  write_file_atomically(file, root.dump(1) + "\n");
}

GridResult read_grid_result(const std::filesystem::path& file, const CaptureSet& set) {
  const std::string text = read_file(file);
  FramePoses poses = read_frame_poses(file, set);
  try {
    const json root = json::parse(text);
    const int version = root.at("format_version").get<int>();
    if (version > kFormatVersion) {
      throw Error(fmt::format("format version {}, this program reads {}", version, kFormatVersion));
    }
    GridResult result = result_of(set, root);
    for (size_t i = 0; i < poses.size(); ++i) {
      if (!poses[i]) throw Error("frame " + excerpt(set.frames[i].name) + " has no pose");
    }
    result.poses = std::move(poses);
    return result;
  } catch (const json::exception& error) {
    throw Error(file.string() + ": damaged (" + one_line(error.what()) +
                "); run raywalk-calibrate grid again");
  } catch (const Error& error) {
    throw Error(file.string() + ": " + error.what() + "; run raywalk-calibrate grid again");
  }
}

}  // namespace raywalk::calibrate
