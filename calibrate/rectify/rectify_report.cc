#include "calibrate/rectify/rectify_report.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "calibrate/rectify/exposure_report.h"
#include "calibrate/rectify/rectified_frames.h"
#include "calibrate/rectify/rectify_page.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/files/json_text.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kFormatVersion = 1;
constexpr const char* kReport = "rectify.json";
constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

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
          {"before", comparison.before.generic_string()},
          {"after", comparison.after.generic_string()},
          {"difference_before", comparison.difference_before},
          {"difference_after", comparison.difference_after}};
}

ordered_json masks_json(const CaptureSet& set, const MaskFigures& masks) {
  if (masks.frames == 0) return nullptr;
  return {
      {"frames", masks.frames}, {"of_frames", set.frames.size()}, {"masked_share", masks.share}};
}

ordered_json json_of(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

int line_named(const CaptureSet& set, const CheckedJson& id) {
  const std::optional<int> line = set.find_line(id.text());
  if (!line) id.fail("line " + excerpt(id.text()) + " is not in the capture");
  return *line;
}

CrossingComparison comparison_of(const CheckedJson& document, const CaptureSet& set) {
  return {.along_x = line_named(set, document.at("along_x")),
          .along_z = line_named(set, document.at("along_z")),
          .frame_x = document.at("frame_x").text(),
          .frame_z = document.at("frame_z").text(),
          .before = document.at("before").text(),
          .after = document.at("after").text(),
          .difference_before = document.at("difference_before").number_or(kNotMeasured),
          .difference_after = document.at("difference_after").number_or(kNotMeasured)};
}

RectifyResult result_of(const CheckedJson& document, const CaptureSet& set) {
  document.require_version(kFormatVersion);
  RectifyResult result{.frames = document.at("grid_frames").integer(),
                       .validation_frames = document.at("validation_frames").integer(),
                       .left_out = document.at("left_out").texts()};
  result.gains.assign(set.frames.size(), LightGain{1.0, 1.0, 1.0});
  for (const CheckedJson& frame : document.at("frames").items()) {
    const auto index = set.find(frame.at("name").text());
    if (!index) frame.at("name").fail("is not in the capture");
    const CheckedJson gain = frame.at("gain");
    result.gains[static_cast<std::size_t>(*index)] = {
        gain.at("red").number(), gain.at("green").number(), gain.at("blue").number()};
  }
  for (const CheckedJson& crossing : document.at("crossings").items()) {
    result.crossings.push_back(comparison_of(crossing, set));
  }
  const CheckedJson tolerance = document.at("line_tolerance_mm");
  if (!tolerance.is_null()) result.line_tolerance_mm = tolerance.number();
  const CheckedJson same_station = document.at("same_station_mm");
  if (!same_station.is_null()) result.same_station_mm = same_station.number();
  // Earlier versions wrote it only with masks.
  if (document.has("frame_masks") && !document.at("frame_masks").is_null()) {
    const CheckedJson masks = document.at("frame_masks");
    result.masks = {.frames = masks.at("frames").integer(),
                    .share = masks.at("masked_share").number()};
  }
  return result;
}

}  // namespace

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

ordered_json rectify_document(const CaptureSet& set, const FramePoses& poses,
                              const GridResult* grid, const RectifyResult& result,
                              const fs::path& out) {
  ordered_json frames = ordered_json::array(), crossings = ordered_json::array();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) frames.push_back(frame_json(set, static_cast<int>(i), *poses[i], result));
  }
  for (const CrossingComparison& comparison : result.crossings) {
    crossings.push_back(comparison_json(set, comparison));
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
          {"grid_crossings", grid ? crossings_json(set, grid->crossings) : ordered_json::array()},
          {"crossings", crossings},
          {"exposure", exposure},
          {"frames", frames}};
}

void write_rectify_report(const CaptureSet& set, const FramePoses& poses, const GridResult* grid,
                          const RectifyResult& result, const fs::path& out) {
  const ordered_json document = rectify_document(set, poses, grid, result, out);
  write_file_atomically(out / kReport, json_text(document));
  write_file_atomically(out / "rectify.html", rectify_page(document, out));
}

RectifyResult read_rectify_result(const fs::path& file, const CaptureSet& set) {
  return result_of(CheckedJson::read(file, "rectify again"), set);
}

}  // namespace raywalk::calibrate
