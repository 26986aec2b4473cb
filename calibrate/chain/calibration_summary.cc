#include "calibrate/chain/calibration_summary.h"

#include <nlohmann/json.hpp>

#include "calibrate/base/frame_poses_json.h"
#include "calibrate/chain/calibration_page.h"
#include "calibrate/rectify/rectify_report.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/files/json_text.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr int kSummaryFormatVersion = 1;

ordered_json read_json(const fs::path& file) {
  try {
    return ordered_json::parse(read_file(file));
  } catch (const json::exception& e) {
    throw Error(file.string() + ": damaged (" + one_line(e.what()) + "); run the step again");
  }
}

// The texts listed under a key of a step's JSON; empty if the step has no file.
std::vector<std::string> listed_in(const fs::path& file, const char* key) {
  if (!fs::exists(file)) return {};
  const CheckedJson document = CheckedJson::read(file, "run the step again");
  return document.has(key) ? document.at(key).texts() : std::vector<std::string>{};
}

fs::path report_of(const Calibration& calibration, CalibrationStep step) {
  // poses.json has no warnings.
  const std::string name = step == CalibrationStep::kPoses ? "poses-report" : step_name(step);
  return calibration.out() / (name + ".json");
}

ordered_json lens_json(const FisheyeLens& lens, const Eigen::Vector3d& position_m) {
  return {{"centre_u_px", lens.centre.u},
          {"centre_v_px", lens.centre.v},
          {"focal_px", lens.focal_px},
          {"k1", lens.k[0]},
          {"k2", lens.k[1]},
          {"k3", lens.k[2]},
          {"k4", lens.k[3]},
          {"largest_angle_deg", degrees_from_radians(lens.largest_angle_rad)},
          {"x_mm", 1000.0 * position_m.x()},
          {"y_mm", 1000.0 * position_m.y()},
          {"z_mm", 1000.0 * position_m.z()}};
}

ordered_json camera_json(const std::optional<DualFisheyeCamera>& camera) {
  if (!camera) return nullptr;
  const DualFisheyeLayout& layout = camera->layout;
  ordered_json back = lens_json(layout.back, layout.back_position_m);
  back["yaw_deg"] = degrees_from_radians(layout.back_attitude.yaw_rad);
  back["pitch_deg"] = degrees_from_radians(layout.back_attitude.pitch_rad);
  back["roll_deg"] = degrees_from_radians(layout.back_attitude.roll_rad);
  return {{"picture_width_px", camera->picture.width},
          {"picture_height_px", camera->picture.height},
          {"two_files", camera->two_files},
          {"front", lens_json(layout.front, layout.front_position_m)},
          {"back", back}};
}

const char* purpose_of(CalibrationStep step) {
  switch (step) {
    case CalibrationStep::kLens:
      return "the lenses and the residuals of their fit";
    case CalibrationStep::kStitch:
      return "two fisheye pictures stitched to a panorama";
    case CalibrationStep::kMask:
      return "masks what moves with the camera";
    case CalibrationStep::kPoses:
      return "poses of the panoramas, solved from their features";
    case CalibrationStep::kGrid:
      return "lines of the rail, their models and crossings";
    case CalibrationStep::kRectify:
      return "frames in world axes, exposures";
  }
  return "";
}

ordered_json steps_json(const std::vector<StepRun>& steps, const fs::path& out) {
  ordered_json list = ordered_json::array();
  for (const StepRun& run : steps) {
    const std::string name = step_name(run.step);
    const std::string page = name + ".html";
    list.push_back({{"step", name},
                    {"purpose", purpose_of(run.step)},
                    {"page", fs::exists(out / page) ? ordered_json(page) : ordered_json(nullptr)},
                    {"seconds", run.seconds},
                    {"reused", run.reused}});
  }
  return list;
}

}  // namespace

std::vector<std::string> step_warnings(const Calibration& calibration, CalibrationStep step) {
  return listed_in(report_of(calibration, step), "warnings");
}

CalibrationSummary summary_of(const Calibration& calibration) {
  CalibrationSummary summary;
  for (const CalibrationStep step : kCalibrationSteps) {
    if (!calibration.has(step)) continue;
    for (const std::string& text : step_warnings(calibration, step)) {
      summary.warnings.push_back(step_name(step) + ": " + text);
    }
    for (const std::string& text : listed_in(report_of(calibration, step), "notes")) {
      summary.notes.push_back(step_name(step) + ": " + text);
    }
  }
  const bool good_lenses = !calibration.has(CalibrationStep::kLens) ||
                           step_warnings(calibration, CalibrationStep::kLens).empty();
  summary.trustworthy = good_lenses && calibration.grid().trustworthy;
  return summary;
}

ordered_json calibration_document(const Calibration& calibration,
                                  const CalibrationSummary& summary) {
  const CaptureSet& set = calibration.captured();
  const ordered_json grid = grid_document(set, calibration.grid());
  const ordered_json rectified = read_json(calibration.out() / "rectify.json");
  return {{"format_version", kSummaryFormatVersion},
          {"source", grid.at("source")},
          {"stations", grid.at("stations")},
          {"method", grid.at("method")},
          {"trustworthy", summary.trustworthy},
          {"warnings", summary.warnings},
          {"notes", summary.notes},
          {"largest_disagreement", grid.at("largest_disagreement")},
          {"lens", camera_json(calibration.camera())},
          {"scale", grid.at("scale")},
          {"lines", grid.at("lines")},
          {"crossings", grid.at("crossings")},
          {"overlays", rectified.at("crossings")},
          {"frames", frame_poses_json(set, calibration.final_poses())},
          {"line_tolerance_mm", rectified.at("line_tolerance_mm")},
          {"same_station_mm", rectified.at("same_station_mm")},
          {"pack_command", pack_command(calibration.rectified(), calibration.out())},
          {"keyframe_trade", keyframe_json(summary.trade)},
          {"steps", steps_json(summary.steps, calibration.out())}};
}

void write_calibration(const Calibration& calibration, const CalibrationSummary& summary) {
  const fs::path& out = calibration.out();
  const ordered_json document = calibration_document(calibration, summary);
  write_file_atomically(out / "calibration.json", json_text(document));
  write_file_atomically(out / "index.html", calibration_page(document, out));
}

}  // namespace raywalk::calibrate
