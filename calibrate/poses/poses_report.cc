#include "calibrate/poses/poses_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/files/atomic_output.h"
#include "core/report/html_page.h"
#include "core/report/plan_drawing.h"

namespace raywalk::calibrate {
namespace {

using Json = nlohmann::ordered_json;

const std::string& frame_name(const CaptureSet& set, int frame) {
  return set.frames[static_cast<std::size_t>(frame)].name;
}

// Frames with a pose, of the stations or of those held out.
int posed_count(const CaptureSet& set, const PosesResult& result, bool held_out) {
  int count = 0;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    if (result.poses[i] && set.frames[i].held_out() == held_out) ++count;
  }
  return count;
}

std::size_t held_out_count(const CaptureSet& set) { return set.frames.size() - set.stations(); }

double total_seconds(const PosesResult& result) {
  double seconds = 0.0;
  for (const StepTime& time : result.times) seconds += time.seconds;
  return seconds;
}

const char* rank_text(int rank) {
  constexpr std::array kTexts{"all stations at one point: the rotation is from orientations alone",
                              "all stations on one line: the roll about it is from orientations",
                              "stations in a plane: the rotation is from positions",
                              "stations in space: the rotation is from positions"};
  return kTexts[static_cast<std::size_t>(std::clamp(rank, 0, 3))];
}

Json alignment_json(const PoseAlignment& alignment) {
  return {{"scale", alignment.scale},
          {"scale_pairs", alignment.scale_pairs},
          {"frames", alignment.frames},
          {"rank", alignment.rank},
          {"spread_m", {alignment.spread_m[0], alignment.spread_m[1], alignment.spread_m[2]}},
          {"rotation_from", rank_text(alignment.rank)}};
}

Json report_json(const CaptureSet& set, const PosesResult& result) {
  Json json{{"format_version", 1},
            {"stations", set.stations()},
            {"keyframes", result.keyframes.size() - held_out_count(set)},
            {"posed", posed_count(set, result, false)},
            {"faces", result.faces},
            {"face_px", result.face_px},
            {"matched_pairs", result.matched_pairs},
            {"points", result.points},
            {"observations", result.observations},
            {"residual_px", result.residual_px},
            {"position_sigma_mm", result.position_sigma_mm},
            {"rotation_sigma_deg", result.rotation_sigma_deg},
            {"alignment", alignment_json(result.alignment)}};
  json["lines"] = Json::array();
  for (const LinePoses& line : result.lines) {
    json["lines"].push_back({{"id", set.line_id(line.line)},
                             {"stations", line.stations},
                             {"keyframes", line.keyframes},
                             {"posed", line.posed},
                             {"observations", line.observations},
                             {"residual_px", line.residual_px},
                             {"moved_mm", line.moved_mm},
                             {"turned_deg", line.turned_deg}});
  }
  json["crossings"] = Json::array();
  for (const CrossingPoints& crossing : result.crossings) {
    json["crossings"].push_back({{"along_x", set.line_id(crossing.along_x)},
                                 {"along_z", set.line_id(crossing.along_z)},
                                 {"points", crossing.points}});
  }
  json["unposed"] = Json::array();
  for (const UnposedFrame& unposed : result.unposed) {
    json["unposed"].push_back(
        {{"name", frame_name(set, unposed.frame)}, {"reason", unposed.reason}});
  }
  if (held_out_count(set) > 0) {
    json["held_out"] = {{"frames", held_out_count(set)}, {"posed", posed_count(set, result, true)}};
  }
  json["warnings"] = result.warnings;
  json["seconds"] = Json::array();
  for (const StepTime& time : result.times) {
    json["seconds"].push_back(
        {{"step", time.step}, {"seconds", time.seconds}, {"reused", time.reused}});
  }
  return json;
}

void add_headline(const CaptureSet& set, const PosesResult& result, HtmlPage* page) {
  std::vector<HtmlFact> facts{
      {"stations with a pose",
       fmt::format("{} of {}", posed_count(set, result, false), set.stations())},
      {"position, 1 sigma", fmt::format("{:.3f} mm", result.position_sigma_mm)},
      {"rotation, 1 sigma", fmt::format("{:.4f}°", result.rotation_sigma_deg)},
      {"residual", fmt::format("{:.2f} px", result.residual_px)},
      {"time", fmt::format("{:.0f} s", total_seconds(result))}};
  if (held_out_count(set) > 0) {
    facts.insert(facts.begin() + 1,
                 {"held-out frames with a pose",
                  fmt::format("{} of {}", posed_count(set, result, true), held_out_count(set))});
  }
  page->add_facts(facts);
  for (const std::string& warning : result.warnings) page->add_paragraph("Warning: " + warning);
  page->add_paragraph(fmt::format(
      "{} of {} stations were solved as keyframes; the others are predicted from their rail "
      "(raywalk-calibrate grid). --keyframes-mm trades time for accuracy: a skipped station is "
      "known only to the carriage's repeatability, a solved one to the sigma above. Residuals are "
      "in pixels of a panorama 4096 wide; sigmas are medians over the stations, each against all "
      "others.",
      result.keyframes.size() - held_out_count(set), set.stations()));
}

void add_lines(const CaptureSet& set, const PosesResult& result, HtmlPage* page) {
  HtmlTable table{.caption = "moved and rotated: largest over the stations, relative to the start",
                  .header = {"line", "stations", "keyframes", "posed", "observations",
                             "residual / px", "moved / mm", "turned / °"}};
  for (const LinePoses& line : result.lines) {
    table.rows.push_back({{set.line_id(line.line)},
                          {std::to_string(line.stations)},
                          {std::to_string(line.keyframes)},
                          {std::to_string(line.posed), line.posed < line.keyframes},
                          {std::to_string(line.observations)},
                          {fmt::format("{:.2f}", line.residual_px)},
                          {fmt::format("{:.1f}", line.moved_mm)},
                          {fmt::format("{:.2f}", line.turned_deg)}});
  }
  page->add_section("Lines");
  page->add_table(table);
}

void add_crossings(const CaptureSet& set, const PosesResult& result, HtmlPage* page) {
  page->add_section("Crossings");
  if (result.crossings.empty()) {
    page->add_paragraph("No two lines cross.");
    return;
  }
  HtmlTable table{.caption = "Scene points seen from both lines near where they cross",
                  .header = {"crossing", "points"}};
  for (const CrossingPoints& crossing : result.crossings) {
    table.rows.push_back({{set.line_id(crossing.along_x) + " × " + set.line_id(crossing.along_z)},
                          {std::to_string(crossing.points)}});
  }
  page->add_table(table);
}

void add_unposed(const CaptureSet& set, const PosesResult& result, HtmlPage* page) {
  if (result.unposed.empty()) return;
  HtmlTable table{.caption = "", .header = {"station", "reason"}};
  for (const UnposedFrame& unposed : result.unposed) {
    table.rows.push_back({{frame_name(set, unposed.frame)}, {unposed.reason}});
  }
  page->add_section(held_out_count(set) > 0 ? "Frames without a pose" : "Stations without a pose");
  page->add_table(table);
}

void add_alignment(const PosesResult& result, HtmlPage* page) {
  const PoseAlignment& alignment = result.alignment;
  page->add_section("Alignment");
  page->add_paragraph(fmt::format(
      "Pictures determine neither the scale nor the common rotation. Scale: {:.6f}, the median "
      "ratio of the slider's distance to the solved one over {} pairs of stations. Rank of the "
      "stations' positions: {} ({}); their spread is {:.3f}, {:.3f} and {:.3f} m.",
      alignment.scale, alignment.scale_pairs, alignment.rank, rank_text(alignment.rank),
      alignment.spread_m[0], alignment.spread_m[1], alignment.spread_m[2]));
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

void add_plan(const CaptureSet& set, const FramePoses& start, const PosesResult& result,
              HtmlPage* page) {
  PlanBounds bounds;
  for (const auto& pose : start) {
    if (pose) bounds.add({pose->position_m.x(), pose->position_m.z()});
  }
  const double extent_m = std::max(bounds.width_m(), bounds.depth_m());
  if (!(extent_m > 0.0)) return;
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
  const std::string svg =
      drawing.svg("Stations as planned and as solved",
                  ".raywalk-plan .planned { fill: var(--soft); }\n"
                  ".raywalk-plan .solved { fill: var(--accent); }\n"
                  ".raywalk-plan .moved { stroke: var(--accent); stroke-width: 1; }\n");
  page->add_section("Plan");
  page->add_figures({svg_figure(
      svg, fmt::format("Stations as planned (grey) and as solved (coloured), with displacements "
                       "exaggerated {:g} times",
                       times))});
}

void add_times(const PosesResult& result, HtmlPage* page) {
  HtmlTable table{.caption = "", .header = {"step", "seconds", ""}};
  for (const StepTime& time : result.times) {
    table.rows.push_back(
        {{time.step}, {fmt::format("{:.1f}", time.seconds)}, {time.reused ? "done before" : ""}});
  }
  page->add_section("Time");
  page->add_table(table);
  page->add_paragraph(fmt::format(
      "{} faces of {} px of each panorama; {} pairs of faces matched; {} scene points, {} "
      "observations.",
      result.faces, result.face_px, result.matched_pairs, result.points, result.observations));
}

}  // namespace

void write_poses_report(const std::filesystem::path& out, const CaptureSet& set,
                        const FramePoses& start, const PosesResult& result) {
  HtmlPage page("Poses of " + set.source.filename().string(),
                fmt::format("{} lines, {} stations", set.lines.size(), set.stations()));
  add_headline(set, result, &page);
  add_lines(set, result, &page);
  add_crossings(set, result, &page);
  add_unposed(set, result, &page);
  add_alignment(result, &page);
  add_plan(set, start, result, &page);
  add_times(result, &page);
  write_file_atomically(
      out / "poses-report.json",
      report_json(set, result)
              .dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
          "\n");
  write_file_atomically(out / "poses.html", page.html());
}

}  // namespace raywalk::calibrate
