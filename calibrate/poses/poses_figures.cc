#include "calibrate/poses/poses_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/poses/match_pairs.h"
#include "calibrate/poses/pose_accuracy.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

// A line further from its plan than this share of a cell was probably laid at a wrong place.
constexpr double kFarOff = 0.25;
constexpr int kFewFeatures = 100;  // over all faces of a panorama

LinePoses figures_of(const CaptureSet& set, const PosesResult& result, const FramePoses& start,
                     std::size_t line) {
  LinePoses figures{.line = line};
  double squares = 0.0;
  for (const std::size_t frame : set.lines[line].frames) {
    ++figures.stations;
    if (!std::binary_search(result.keyframes.begin(), result.keyframes.end(), frame)) continue;
    ++figures.keyframes;
    const auto& pose = result.poses[frame];
    const auto& planned = start[frame];
    if (!pose) continue;
    ++figures.posed;
    figures.observations += pose->observations;
    squares += pose->observations * pose->residual_px * pose->residual_px;
    if (!planned) continue;
    figures.moved_mm =
        std::max(figures.moved_mm, 1e3 * (pose->position_m - planned->position_m).norm());
    figures.turned_deg = std::max(
        figures.turned_deg,
        degrees_from_radians(angle_between(pose->world_from_camera, planned->world_from_camera)));
  }
  if (figures.observations > 0) figures.residual_px = std::sqrt(squares / figures.observations);
  return figures;
}

// Flags of the points that stations of a line within `reach_m` of a place see.
std::vector<bool> seen_near(const CaptureSet& set, const CaptureLine& line, PlanPoint at,
                            double reach_m, const SeenPoints& points) {
  const double at_m = line.axis == LineAxis::kX ? at.x_m : at.z_m;
  std::vector<bool> near(set.frames.size(), false);
  for (const std::size_t frame : line.frames) {
    near[frame] = std::abs(set.rail_m(frame) - at_m) <= reach_m;
  }
  std::vector<bool> seen(points.points_m.size(), false);
  for (const PointObservation& one : points.observations) {
    if (near[one.frame]) seen[one.point] = true;
  }
  return seen;
}

void warn_of_line(const CaptureSet& set, const MatchSummary& summary, const LinePoses& line,
                  double cell_m, std::vector<std::string>* warnings) {
  const std::string& id = set.line_id(line.line);
  if (line.posed == 0) {
    const bool reversed = summary.motions[line.line] == RailMotion::kReversed;
    warnings->push_back(
        reversed
            ? fmt::format(
                  "line {}: its pictures move against the slider, unlike those of the others: the "
                  "rail was laid the other way round, or its pictures are in reverse order",
                  id)
            : fmt::format("line {}: nothing in its pictures connects it to the rest of the grid; "
                          "its stations have no pose. Was the rail laid where it was planned, and "
                          "are these its pictures?",
                          id));
    return;
  }
  if (line.posed < line.keyframes) {
    warnings->push_back(fmt::format("line {}: {} of {} stations have no pose", id,
                                    line.keyframes - line.posed, line.keyframes));
  }
  if (line.moved_mm > kFarOff * 1e3 * cell_m) {
    warnings->push_back(
        fmt::format("line {}: found {:.0f} mm from where it was planned; if the rail was not laid "
                    "there, check the matches",
                    id, line.moved_mm));
  }
}

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
  static constexpr std::array kTexts{
      "all stations at one point: the rotation is from orientations alone",
      "all stations on one line: the roll about it is from orientations",
      "stations in a plane: the rotation is from positions",
      "stations in space: the rotation is from positions"};
  return kTexts.at(std::clamp(rank, 0, 3));
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
                {"total_seconds", 0.0},
                {"frames", frame_poses_json(set, result.poses)}};
  for (const CrossingPoints& crossing : result.crossings) {
    document["crossings"].push_back({{"along_x", set.line_id(crossing.along_x)},
                                     {"along_z", set.line_id(crossing.along_z)},
                                     {"points", crossing.points}});
  }
  for (const UnposedFrame& unposed : result.unposed) {
    document["unposed"].push_back(
        {{"name", set.frames[unposed.frame].name}, {"reason", unposed.reason}});
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

}  // namespace

std::vector<LinePoses> line_figures(const CaptureSet& set, const PosesResult& result,
                                    const FramePoses& start) {
  std::vector<LinePoses> lines;
  for (std::size_t i = 0; i < set.lines.size(); ++i) {
    lines.push_back(figures_of(set, result, start, i));
  }
  return lines;
}

std::vector<CrossingPoints> crossing_figures(const CaptureSet& set,
                                             std::span<const LineCrossing> crossings,
                                             const SeenPoints& inliers) {
  const double reach_m = 0.5 * cell_side_m(set, crossings);
  std::vector<CrossingPoints> figures;
  for (const LineCrossing& crossing : crossings) {
    const auto seen_from = [&](std::size_t line) {
      return seen_near(set, set.lines[line], crossing.at, reach_m, inliers);
    };
    const std::vector<bool> along_x = seen_from(crossing.along_x);
    const std::vector<bool> along_z = seen_from(crossing.along_z);
    int points = 0;
    for (std::size_t i = 0; i < along_x.size(); ++i) points += along_x[i] && along_z[i] ? 1 : 0;
    figures.push_back({crossing.along_x, crossing.along_z, points});
  }
  return figures;
}

std::string unposed_reason(const CaptureSet& set, const MatchSummary& summary, std::size_t frame) {
  const auto count = [frame](const std::map<std::size_t, int>& counts) {
    const auto found = counts.find(frame);
    return found == counts.end() ? 0 : found->second;
  };
  const CaptureFrame& of = set.frames[frame];
  if (!of.held_out() && summary.motions[of.line] == RailMotion::kReversed) {
    return "its line runs against the slider";
  }
  const int features = count(summary.features);
  if (features < kFewFeatures) {
    return fmt::format("only {} features: too dark, too blurred or too plain{}", features,
                       of.mask ? ", or too much of it is masked" : "");
  }
  const int matches = count(summary.matches);
  if (matches == 0) {
    return of.held_out() ? "no matches with the stations near it: is it a picture of this place?"
                         : "no matches with its neighbours: is it a picture of this station?";
  }
  return fmt::format("too few scene points in common with the others ({} matches)", matches);
}

std::vector<std::string> pose_warnings(const CaptureSet& set,
                                       std::span<const LineCrossing> crossings,
                                       const MatchSummary& summary, const PosesResult& result) {
  std::vector<std::string> warnings;
  const double cell_m = cell_side_m(set, crossings);
  for (const LinePoses& line : result.lines) {
    warn_of_line(set, summary, line, cell_m, &warnings);
  }
  const auto posed = [&](std::size_t line) { return result.lines[line].posed > 0; };
  for (const CrossingPoints& crossing : result.crossings) {
    if (!posed(crossing.along_x) || !posed(crossing.along_z)) continue;
    if (crossing.points >= kLeastSharedPoints) continue;
    warnings.push_back(
        fmt::format("lines {} and {} have only {} scene points in common where they should cross: "
                    "they are connected only by other crossings",
                    set.line_id(crossing.along_x), set.line_id(crossing.along_z), crossing.points));
  }
  for (const UnposedFrame& unposed : result.unposed) {
    const CaptureFrame& frame = set.frames[unposed.frame];
    if (!frame.held_out()) continue;
    warnings.push_back(fmt::format("held-out frame {} ({}) has no pose and is left out: {}",
                                   frame.name, frame.where, unposed.reason));
  }
  return warnings;
}

void write_poses_report(const std::filesystem::path& out, const CaptureSet& set,
                        const PosesResult& result) {
  write_file_atomically(out / "poses-report.json", json_text(poses_document(set, result)));
}

}  // namespace raywalk::calibrate
