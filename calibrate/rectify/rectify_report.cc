#include "calibrate/rectify/rectify_report.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "calibrate/rectify/crossing_table.h"
#include "calibrate/rectify/exposure_report.h"
#include "calibrate/rectify/rectified_frames.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/files/image_file.h"
#include "core/report/markup.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kFormatVersion = 1;
constexpr const char* kReport = "rectify.json";
constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

ordered_json frame_json(const CaptureFrame& frame, const FramePose& pose, const LightGain& gain) {
  return {{"name", frame.name},
          {"file", rectified_file(frame).generic_string()},
          {"position_m", {pose.position_m.x(), pose.position_m.y(), pose.position_m.z()}},
          {"gain", {{"red", gain[0]}, {"green", gain[1]}, {"blue", gain[2]}}}};
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

ordered_json result_json(const CaptureSet& set, const FramePoses& poses,
                         const RectifyResult& result) {
  ordered_json frames = ordered_json::array(), crossings = ordered_json::array();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!poses[i]) continue;
    frames.push_back(frame_json(set.frames[i], *poses[i], result.gains[i]));
    if (!result.exposure) continue;
    frames.back()["exposure"] = frame_exposure_json(*result.exposure, static_cast<int>(i));
  }
  for (const CrossingComparison& comparison : result.crossings) {
    crossings.push_back(comparison_json(set, comparison));
  }
  ordered_json exposure;
  if (result.exposure) exposure = exposure_json(set, *result.exposure);
  ordered_json tolerance, same_station;
  if (result.line_tolerance_mm) tolerance = *result.line_tolerance_mm;
  if (result.same_station_mm) same_station = *result.same_station_mm;
  ordered_json document{{"format_version", kFormatVersion},
                        {"grid_frames", result.frames},
                        {"validation_frames", result.validation_frames},
                        {"left_out", result.left_out},
                        {"line_tolerance_mm", tolerance},
                        {"same_station_mm", same_station},
                        {"crossings", crossings},
                        {"exposure", exposure},
                        {"frames", frames}};
  if (result.masks.frames > 0) {
    document["frame_masks"] = {{"frames", result.masks.frames},
                               {"of_frames", set.frames.size()},
                               {"masked_share", result.masks.share}};
  }
  return document;
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
  if (document.has("frame_masks")) {
    const CheckedJson masks = document.at("frame_masks");
    result.masks = {.frames = masks.at("frames").integer(),
                    .share = masks.at("masked_share").number()};
  }
  return result;
}

HtmlFigure overlay_figure(const fs::path& file, const std::string& caption) {
  return picture_figure(read_picture(file), EmbeddedFormat::kJpeg, caption, caption);
}

void add_head(const RectifyResult& result, const fs::path& out, HtmlPage* page) {
  std::vector<HtmlFact> facts{{"frames", std::to_string(result.frames)},
                              {"validation frames", std::to_string(result.validation_frames)},
                              {"left out", std::to_string(result.left_out.size())}};
  if (result.masks.frames > 0) {
    facts.push_back({"frames with a mask of their own", std::to_string(result.masks.frames)});
    facts.push_back(
        {"of their sphere is masked", fmt::format("{:.2f} %", 100.0 * result.masks.share)});
  }
  page->add_facts(facts);
  page->add_paragraph(
      "Frames are rotated to world axes in one resampling; their positions are those of the "
      "estimated poses. The next step:");
  page->add_paragraph(pack_command(result, out));
  page->add_paragraph(
      fmt::format("What the calibration gains: pack {} too, the frames at their planned positions, "
                  "and give its "
                  "room to raywalk-render validate --before.",
                  (out / "before.csv").string()));
  if (!result.left_out.empty()) {
    std::string names;
    for (const std::string& name : result.left_out) names += (names.empty() ? "" : ", ") + name;
    page->add_paragraph("Omitted, without a pose: " + names + ".");
  }
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

void add_overlays(const CaptureSet& set, const RectifyResult& result, const fs::path& out,
                  HtmlPage* page) {
  if (result.crossings.empty()) return;
  page->add_section("Overlays of the lines");
  page->add_paragraph(
      "The two panoramas nearest to each crossing, one in red, the other in cyan, in the direction "
      "with the most texture: where they agree the picture is grey. They were not taken at exactly "
      "the same position, so near objects keep a little parallax.");
  for (const CrossingComparison& crossing : result.crossings) {
    const std::string what =
        fmt::format("{}, frames {} and {}", crossing_name(set, crossing.along_x, crossing.along_z),
                    crossing.frame_x, crossing.frame_z);
    page->add_figures(
        {overlay_figure(out / crossing.before,
                        fmt::format("{}, before: differ by {:.2f} levels RMS", what,
                                    crossing.difference_before)),
         overlay_figure(out / crossing.after, fmt::format("{}, after: differ by {:.2f} levels RMS",
                                                          what, crossing.difference_after))});
  }
}

void write_rectify_report(const CaptureSet& set, const FramePoses& poses, const GridResult* grid,
                          const RectifyResult& result, const fs::path& out) {
  HtmlPage page("Rectified frames", set.source.string());
  add_head(result, out, &page);
  if (grid != nullptr && !grid->crossings.empty()) {
    page.add_section("At the crossings");
    page.add_table(crossing_table(set, grid->crossings));
  }
  add_overlays(set, result, out, &page);
  page.add_section("Exposure");
  if (result.exposure) {
    add_exposure(set, *result.exposure, &page);
  } else {
    page.add_paragraph("Not compared (--no-gain): the frames' light is as captured.");
  }
  write_file_atomically(out / "rectify.html", page.html());
  write_file_atomically(
      out / kReport,
      result_json(set, poses, result)
              .dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
          "\n");
}

RectifyResult read_rectify_result(const fs::path& file, const CaptureSet& set) {
  return result_of(CheckedJson::read(file, "rectify again"), set);
}

}  // namespace raywalk::calibrate
