#include "calibrate/rectify/rectify_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/base/figures.h"
#include "calibrate/rectify/light_estimate.h"
#include "calibrate/rectify/rectified_frames.h"
#include "core/base/number_text.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kFormatVersion = 1;

bool is_corrected(const LightGain& gain) { return gain != LightGain{1.0, 1.0, 1.0}; }

std::size_t corrected_frames(const ExposureResult& exposure) {
  return static_cast<std::size_t>(
      std::count_if(exposure.gains.begin(), exposure.gains.end(), is_corrected));
}

std::size_t measured_frames(const ExposureResult& exposure) {
  return static_cast<std::size_t>(
      std::count(exposure.measured.begin(), exposure.measured.end(), true));
}

const char* model_text(ExposureModel model) {
  switch (model) {
    case ExposureModel::kEqual:
      return "all frames alike";
    case ExposureModel::kLines:
      return "one value per line";
    case ExposureModel::kDrift:
      return "steady drift along each line";
    case ExposureModel::kStations:
      return "one value per frame";
  }
  return "";
}

const std::string& name_of(const CaptureSet& set, int frame) {
  return set.frames[static_cast<std::size_t>(frame)].name;
}

// Photographic stops (factors of two), mean of the colours.
double mean_stops(const LightGain& gain) {
  return (std::log2(gain[0]) + std::log2(gain[1]) + std::log2(gain[2])) / 3.0;
}

// The key "exposure" of rectify.json, and that of a frame of it; docs/file-formats.md has the keys.
ordered_json exposure_json(const CaptureSet& set, const ExposureResult& exposure) {
  ordered_json kinds = ordered_json::array();
  for (int kind = 0; kind < kLightKinds; ++kind) {
    const MeasuredLight& light = exposure.light[static_cast<std::size_t>(kind)];
    ordered_json tests = ordered_json::array(), halves = ordered_json::array();
    for (const ModelTest& test : light.decision.tests) {
      tests.push_back({{"model", exposure_model_name(test.model)},
                       {"model_text", model_text(test.model)},
                       {"largest_t", test.largest_t},
                       {"frame", name_of(set, test.picture)},
                       {"rejected", test.rejected}});
    }
    for (const HalvesComparison& split : light.halves) {
      halves.push_back({{"split", split.split},
                        {"difference", split.difference},
                        {"by_chance", split.by_chance}});
    }
    kinds.push_back({{"kind", light_kind_name(kind)},
                     {"model", exposure_model_name(light.decision.model)},
                     {"model_text", model_text(light.decision.model)},
                     {"spread", light.spread},
                     {"t_limit", light.decision.t_limit},
                     {"t_limit_single", light.decision.t_limit_single},
                     {"tests", tests},
                     {"halves", halves}});
  }
  return {{"summary", exposure_summary(exposure)},
          {"corrected_frames", corrected_frames(exposure)},
          {"measured_frames", measured_frames(exposure)},
          {"links", exposure.links},
          {"patches", exposure.patches},
          {"scene_parts", exposure.scene_parts},
          {"scene_parts_in_all", kSceneParts},
          {"loops", exposure.loops},
          {"loop_error", exposure.loop_error},
          {"significance", kSignificance},
          {"kinds", kinds}};
}

ordered_json frame_exposure_json(const ExposureResult& exposure, int frame) {
  const bool measured = exposure.measured[static_cast<std::size_t>(frame)];
  const auto if_measured = [measured](double value) {
    return measured ? ordered_json(value) : ordered_json(nullptr);
  };
  ordered_json kinds;
  for (int kind = 0; kind < kLightKinds; ++kind) {
    const ExposureDecision& decision = exposure.light[static_cast<std::size_t>(kind)].decision;
    kinds[light_kind_name(kind)] = {
        {"measured", if_measured(decision.measured[frame])},
        {"fitted", if_measured(decision.fitted[frame])},
        {"measured_change", if_measured(std::expm1(decision.measured[frame]))},
        {"fitted_change", if_measured(std::expm1(decision.fitted[frame]))},
        {"error", if_measured(decision.error[frame])},
        {"corrected", decision.correction[frame] != 0.0}};
  }
  return kinds;
}

ordered_json frame_json(const CaptureSet& set, int index, const FramePose& pose,
                        const RectifyResult& result) {
  const CaptureFrame& frame = set.frames[static_cast<std::size_t>(index)];
  const LightGain& gain = result.gains[static_cast<std::size_t>(index)];
  ordered_json json{{"name", frame.name},
                    {"line", nullptr},
                    {"rail_m", nullptr},
                    {"file", rectified_file(frame).generic_string()},
                    {"position_m", {pose.position_m.x(), pose.position_m.y(), pose.position_m.z()}},
                    {"gain", {{"red", gain[0]}, {"green", gain[1]}, {"blue", gain[2]}}},
                    {"gain_stops", mean_stops(gain)}};
  if (!frame.held_out()) {
    json["line"] = set.line_id(frame.line);
    json["rail_m"] = set.rail_m(index);
  }
  if (result.exposure) json["exposure"] = frame_exposure_json(*result.exposure, index);
  return json;
}

ordered_json comparison_json(const CaptureSet& set, const CrossingComparison& comparison) {
  return {{"along_x", set.lines[static_cast<std::size_t>(comparison.along_x)].id},
          {"along_z", set.lines[static_cast<std::size_t>(comparison.along_z)].id},
          {"frame_x", comparison.frame_x},
          {"frame_z", comparison.frame_z},
          {"difference_before", comparison.difference_before},
          {"difference_after", comparison.difference_after}};
}

// The overlays.
void add_figures(const CaptureSet& set, const CrossingComparison& comparison,
                 ordered_json* figures) {
  const std::string row =
      fmt::format("{} × {}, frames {} and {}", set.line_id(comparison.along_x),
                  set.line_id(comparison.along_z), comparison.frame_x, comparison.frame_z);
  const auto differ = [](const char* when, double levels) {
    return fmt::format("{}: differ by {} levels RMS", when, number_or_dash(levels, 2));
  };
  figures->push_back(
      figure_json(row, differ("before", comparison.difference_before), comparison.before));
  figures->push_back(
      figure_json(row, differ("after", comparison.difference_after), comparison.after));
}

ordered_json masks_json(const CaptureSet& set, const MaskFigures& masks) {
  if (masks.frames == 0) return nullptr;
  return {
      {"frames", masks.frames}, {"of_frames", set.frames.size()}, {"masked_share", masks.share}};
}

ordered_json json_of(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

// The next step.
std::string pack_command(const RectifyResult& result, const fs::path& out) {
  std::string command =
      fmt::format("raywalk-build-lf pack --frames {} --out ROOM.lf", (out / "poses.csv").string());
  if (result.line_tolerance_mm.value_or(0.0) > 0.0) {
    command += fmt::format(" --line-tolerance-mm {:g}", *result.line_tolerance_mm);
  }
  if (result.same_station_mm) {
    command += fmt::format(" --same-station-mm {:g}", *result.same_station_mm);
  }
  return command;
}

using nlohmann::ordered_json;

}  // namespace

ordered_json rectify_document(const CaptureSet& set, const FramePoses& poses,
                              const RectifyResult& result, const fs::path& out) {
  ordered_json frames = ordered_json::array(), crossings = ordered_json::array();
  ordered_json figures = ordered_json::array();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) frames.push_back(frame_json(set, static_cast<int>(i), *poses[i], result));
  }
  for (const CrossingComparison& comparison : result.crossings) {
    crossings.push_back(comparison_json(set, comparison));
    add_figures(set, comparison, &figures);
  }
  ordered_json exposure;
  if (result.exposure) exposure = exposure_json(set, *result.exposure);
  return {{"format_version", kFormatVersion},
          {"source", set.source.string()},
          {"grid_frames", result.frames},
          {"validation_frames", result.validation_frames},
          {"left_out", result.left_out},
          {"frame_masks", masks_json(set, result.masks)},
          {"line_tolerance_mm", json_of(result.line_tolerance_mm)},
          {"same_station_mm", json_of(result.same_station_mm)},
          {"pack_command", pack_command(result, out)},
          {"before_list", (out / "before.csv").string()},
          {"crossings", crossings},
          {"exposure", exposure},
          {"frames", frames},
          {"figures", figures}};
}

void write_rectify_report(const CaptureSet& set, const FramePoses& poses,
                          const RectifyResult& result, const fs::path& out) {
  write_file_atomically(out / "rectify.json", json_text(rectify_document(set, poses, result, out)));
}

std::string exposure_summary(const ExposureResult& exposure) {
  const std::size_t measured = measured_frames(exposure);
  if (measured == 0)
    return "no two frames show enough in common to compare exposures; none is corrected";
  const bool testable = !exposure.light[0].decision.tests.empty();
  if (!testable)
    return "too little of the scene is comparable to judge exposures; none is corrected";
  const std::size_t corrected = corrected_frames(exposure);
  if (corrected == 0) {
    return "no difference of exposure or colour exceeds its uncertainty; none is corrected";
  }
  double largest = 0.0;
  for (const LightGain& gain : exposure.gains) {
    largest = std::max(largest, std::abs(mean_stops(gain)));
  }
  return fmt::format(
      "exposures or colours differ; {} of {} frames are corrected, by at most {:.3f} stops",
      corrected, measured, largest);
}

}  // namespace raywalk::calibrate
