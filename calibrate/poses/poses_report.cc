#include "calibrate/poses/poses_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/files/atomic_output.h"
#include "core/files/json_text.h"
#include "core/report/json_page.h"
#include "core/report/plan_drawing.h"

namespace raywalk::calibrate {
namespace {

using Json = nlohmann::ordered_json;

// Frames with a pose, of the stations or of those held out.
int posed_count(const CaptureSet& set, const PosesResult& result, bool held_out) {
  int count = 0;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    if (result.poses[i] && set.frames[i].held_out() == held_out) ++count;
  }
  return count;
}

const char* rank_text(int rank) {
  constexpr std::array kTexts{"all stations at one point: the rotation is from orientations alone",
                              "all stations on one line: the roll about it is from orientations",
                              "stations in a plane: the rotation is from positions",
                              "stations in space: the rotation is from positions"};
  return kTexts[static_cast<std::size_t>(std::clamp(rank, 0, 3))];
}

Json alignment_json(const PoseAlignment& alignment) {
  const Eigen::Vector3d& spread_m = alignment.spread_m;
  return {{"scale", alignment.scale},
          {"scale_pairs", alignment.scale_pairs},
          {"frames", alignment.frames},
          {"rank", alignment.rank},
          {"spread_m", {spread_m[0], spread_m[1], spread_m[2]}},
          {"rotation_from", rank_text(alignment.rank)}};
}

Json lines_json(const CaptureSet& set, const std::vector<LinePoses>& lines) {
  Json json = Json::array();
  for (const LinePoses& line : lines) {
    json.push_back({{"id", set.line_id(line.line)},
                    {"stations", line.stations},
                    {"keyframes", line.keyframes},
                    {"posed", line.posed},
                    {"observations", line.observations},
                    {"residual_px", line.residual_px},
                    {"moved_mm", line.moved_mm},
                    {"turned_deg", line.turned_deg}});
  }
  return json;
}

Json poses_document(const CaptureSet& set, const PosesResult& result) {
  const std::size_t held_out = set.frames.size() - set.stations();
  Json document{{"format_version", 1},
                {"source", set.source.filename().string()},
                {"stations", set.stations()},
                {"keyframes", result.keyframes.size() - held_out},
                {"posed", posed_count(set, result, false)},
                {"faces", result.faces},
                {"face_px", result.face_px},
                {"matched_pairs", result.matched_pairs},
                {"points", result.points},
                {"observations", result.observations},
                {"residual_px", result.residual_px},
                {"position_sigma_mm", result.position_sigma_mm},
                {"rotation_sigma_deg", result.rotation_sigma_deg},
                {"alignment", alignment_json(result.alignment)},
                {"lines", lines_json(set, result.lines)},
                {"crossings", Json::array()},
                {"unposed", Json::array()},
                {"held_out", nullptr},
                {"warnings", result.warnings},
                {"seconds", Json::array()},
                {"total_seconds", 0.0}};
  for (const CrossingPoints& crossing : result.crossings) {
    document["crossings"].push_back({{"along_x", set.line_id(crossing.along_x)},
                                     {"along_z", set.line_id(crossing.along_z)},
                                     {"points", crossing.points}});
  }
  for (const UnposedFrame& unposed : result.unposed) {
    document["unposed"].push_back(
        {{"name", set.frames[static_cast<std::size_t>(unposed.frame)].name},
         {"reason", unposed.reason}});
  }
  if (held_out > 0) {
    document["held_out"] = {{"frames", held_out}, {"posed", posed_count(set, result, true)}};
  }
  double total_seconds = 0.0;
  for (const StepTime& time : result.times) {
    document["seconds"].push_back(
        {{"step", time.step}, {"seconds", time.seconds}, {"reused", time.reused}});
    total_seconds += time.seconds;
  }
  document["total_seconds"] = total_seconds;
  return document;
}

// The factor by which displacements are exaggerated in the drawing: a round number that makes the
// largest a twentieth of the drawing.
double exaggeration(const FramePoses& start, const FramePoses& solved, double extent_m) {
  double largest_m = 0.0;
  for (std::size_t i = 0; i < solved.size(); ++i) {
    if (!solved[i] || !start[i]) continue;
    largest_m = std::max(largest_m, (solved[i]->position_m - start[i]->position_m).norm());
  }
  if (largest_m <= 0.0) return 1.0;
  const double wanted = 0.05 * extent_m / largest_m;
  return wanted <= 1.0 ? 1.0 : std::pow(10.0, std::floor(std::log10(wanted)));
}

// Without markup where the stations have no extent.
HtmlFigure plan_figure(const CaptureSet& set, const FramePoses& start, const PosesResult& result) {
  PlanBounds bounds;
  for (const auto& pose : start) {
    if (pose) bounds.add({pose->position_m.x(), pose->position_m.z()});
  }
  const double extent_m = std::max(bounds.width_m(), bounds.depth_m());
  if (!(extent_m > 0.0)) return {};
  const double times = exaggeration(start, result.poses, extent_m);
  PlanDrawing drawing(bounds, 40.0);
  for (std::size_t i = 0; i < set.frames.size(); ++i) {
    if (!start[i]) continue;
    const PlanPoint from{start[i]->position_m.x(), start[i]->position_m.z()};
    drawing.add_dot("planned", from, 2.0);
    if (!result.poses[i]) continue;
    const Eigen::Vector3d moved = result.poses[i]->position_m - start[i]->position_m;
    const PlanPoint to{from.x_m + times * moved.x(), from.z_m + times * moved.z()};
    drawing.add_line("moved", from, to);
    drawing.add_dot("solved", to, 2.0);
  }
  return svg_figure(
      drawing.svg("Stations as planned and as solved",
                  ".raywalk-plan .planned { fill: var(--soft); }\n"
                  ".raywalk-plan .solved { fill: var(--accent); }\n"
                  ".raywalk-plan .moved { stroke: var(--accent); stroke-width: 1; }\n"),
      fmt::format("Stations as planned (grey) and as solved (coloured), with displacements "
                  "exaggerated {:g} times",
                  times));
}

void add_lines(JsonPage page) {
  page.section("Lines").table("lines",
                              {{"line", "{id}"},
                               {"stations", "{stations}"},
                               {"keyframes", "{keyframes}"},
                               {"posed", "{posed}", "posed < keyframes"},
                               {"observations", "{observations}"},
                               {"residual / px", "{residual_px:.2f}"},
                               {"moved / mm", "{moved_mm:.1f}"},
                               {"turned / °", "{turned_deg:.2f}"}},
                              "moved and turned: largest over the stations, relative to the start");
  page.section("Crossings")
      .table("crossings", {{"crossing", "{along_x} × {along_z}"}, {"points", "{points}"}},
             "Scene points seen from both lines near where they cross")
      .when("!crossings")
      .paragraph("No two lines cross.");
  page.when("unposed")
      .section("{!held_out:Stations|Frames} without a pose")
      .table("unposed", {{"station", "{name}"}, {"reason", "{reason}"}});
}

std::string poses_page(const Json& document, const HtmlFigure& plan) {
  JsonPage page(document, "Poses of {source}", "{lines:counted line}, {stations:counted station}");
  page.facts({{"stations with a pose", "{posed} of {stations}"},
              {"held-out frames with a pose", "{held_out.posed} of {held_out.frames}", "held_out"},
              {"position, 1 sigma", "{position_sigma_mm:.3f mm}"},
              {"rotation, 1 sigma", "{rotation_sigma_deg:.4f°}"},
              {"residual", "{residual_px:.2f px}"},
              {"time", "{total_seconds:.0f s}"}});
  page.warnings("warnings");
  page.paragraph(
      "{keyframes} of {stations} stations were solved as keyframes; the others are predicted from "
      "their rail (raywalk-calibrate grid). --keyframes-mm trades time for accuracy: a skipped "
      "station is known only to the carriage's repeatability, a solved one to the sigma above. "
      "Residuals are in pixels of a panorama 4096 wide; sigmas are medians over the stations, each "
      "against all others.");
  add_lines(page);
  page.within("alignment")
      .section("Alignment")
      .paragraph(
          "Pictures determine neither the scale nor the common rotation. Scale: {scale:.6f}, the "
          "median ratio of the slider's distance to the solved one over {scale_pairs} pairs of "
          "stations. Rank of the stations' positions: {rank} ({rotation_from}); their spread is "
          "{spread_m.0:.3f}, {spread_m.1:.3f} and {spread_m.2:.3f m}.");
  if (!plan.markup.empty()) page.section("Plan").figures({plan});
  page.section("Time")
      .table("seconds",
             {{"step", "{step}"}, {"seconds", "{seconds:.1f}"}, {"", "{reused:done before|}"}})
      .paragraph(
          "{faces} faces of {face_px} px of each panorama; {matched_pairs} pairs of faces matched; "
          "{points} scene points, {observations} observations.");
  return page.html();
}

}  // namespace

void write_poses_report(const std::filesystem::path& out, const CaptureSet& set,
                        const FramePoses& start, const PosesResult& result) {
  const Json document = poses_document(set, result);
  write_file_atomically(out / "poses-report.json", json_text(document));
  write_file_atomically(out / "poses.html", poses_page(document, plan_figure(set, start, result)));
}

}  // namespace raywalk::calibrate
