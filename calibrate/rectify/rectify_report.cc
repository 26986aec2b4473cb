#include "calibrate/rectify/rectify_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "calibrate/base/figures.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kRectifyVersion = 1;

ordered_json frame_json(const CaptureSet& set, int index, const FramePose& pose,
                        const RectifyResult& result) {
  const CaptureFrame& frame = set.frames[static_cast<std::size_t>(index)];
  ordered_json json{
      {"name", frame.name},
      {"line", nullptr},
      {"rail_m", nullptr},
      {"file", result.files[static_cast<std::size_t>(index)]},
      {"position_m", {pose.position_m.x(), pose.position_m.y(), pose.position_m.z()}}};
  if (!frame.held_out()) {
    json["line"] = set.line_id(frame.line);
    json["rail_m"] = set.rail_m(index);
  }
  return json;
}

ordered_json comparison_json(const CaptureSet& set, const IntersectionComparison& comparison) {
  return {{"along_x", set.lines[static_cast<std::size_t>(comparison.along_x)].id},
          {"along_z", set.lines[static_cast<std::size_t>(comparison.along_z)].id},
          {"frame_x", comparison.frame_x},
          {"frame_z", comparison.frame_z},
          {"difference_before", comparison.difference_before},
          {"difference_after", comparison.difference_after}};
}

// The overlays.
void add_figures(const CaptureSet& set, const IntersectionComparison& comparison,
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
std::string next_command(const RectifyResult& result, const fs::path& out) {
  std::string command = fmt::format("raywalk-build-lf all --frames {} --out ROOM.lf",
                                    shell_word((out / "poses.csv").string()));
  if (result.line_tolerance_mm.value_or(0.0) > 0.0) {
    command += fmt::format(" --line-tolerance-mm {:g}", *result.line_tolerance_mm);
  }
  if (result.same_station_mm) {
    command += fmt::format(" --same-station-mm {:g}", *result.same_station_mm);
  }
  return command;
}

ordered_json rectify_document(const CaptureSet& set, const FramePoses& poses,
                              const RectifyResult& result, const fs::path& out) {
  ordered_json frames = ordered_json::array(), intersections = ordered_json::array();
  ordered_json figures = ordered_json::array();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) frames.push_back(frame_json(set, static_cast<int>(i), *poses[i], result));
  }
  for (const IntersectionComparison& comparison : result.intersections) {
    intersections.push_back(comparison_json(set, comparison));
    add_figures(set, comparison, &figures);
  }
  return {{"format_version", kRectifyVersion},
          {"source", set.source.string()},
          {"grid_frames", result.frames},
          {"validation_frames", result.validation_frames},
          {"left_out", result.left_out},
          {"frame_masks", masks_json(set, result.masks)},
          {"line_tolerance_mm", json_of(result.line_tolerance_mm)},
          {"same_station_mm", json_of(result.same_station_mm)},
          {"next_command", next_command(result, out)},
          {"before_list", (out / "before.csv").string()},
          {"intersections", intersections},
          {"frames", frames},
          {"figures", figures}};
}

}  // namespace

void write_rectify_report(const CaptureSet& set, const FramePoses& poses,
                          const RectifyResult& result, const fs::path& out) {
  write_file_atomically(out / "rectify.json", json_text(rectify_document(set, poses, result, out)));
}

}  // namespace raywalk::calibrate
