#include "calibrate/poses/poses_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/poses/frame_links.h"

namespace raywalk::calibrate {
namespace {

// A line further from its plan than this share of a cell was probably laid at a wrong place.
constexpr double kFarOff = 0.25;
constexpr int kFewFeatures = 100;  // over all faces of a panorama

LinePoses figures_of(const CaptureSet& set, const PosesResult& result, const FramePoses& start,
                     int line) {
  LinePoses figures;
  figures.line = line;
  double squares = 0.0;
  for (const int frame : set.lines[static_cast<std::size_t>(line)].frames) {
    ++figures.stations;
    if (!std::binary_search(result.keyframes.begin(), result.keyframes.end(), frame)) continue;
    ++figures.keyframes;
    const auto& pose = result.poses[static_cast<std::size_t>(frame)];
    const auto& planned = start[static_cast<std::size_t>(frame)];
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

// Flags of the frames of a line near a position.
std::vector<bool> frames_near(const CaptureSet& set, int line, PlanPoint at, double reach_m) {
  std::vector<bool> near(set.frames.size(), false);
  const CaptureLine& of = set.lines[static_cast<std::size_t>(line)];
  const double at_m = of.axis == LineAxis::kX ? at.x_m : at.z_m;
  for (const int frame : of.frames) {
    near[static_cast<std::size_t>(frame)] = std::abs(set.rail_m(frame) - at_m) <= reach_m;
  }
  return near;
}

void warn_of_line(const CaptureSet& set, const MatchSummary& summary, const LinePoses& line,
                  double cell_m, std::vector<std::string>* warnings) {
  const std::string& id = set.line_id(line.line);
  if (line.posed == 0) {
    const bool reversed =
        summary.motions[static_cast<std::size_t>(line.line)] == RailMotion::kReversed;
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

}  // namespace

std::vector<LinePoses> line_figures(const CaptureSet& set, const PosesResult& result,
                                    const FramePoses& start) {
  std::vector<LinePoses> lines;
  for (std::size_t i = 0; i < set.lines.size(); ++i) {
    lines.push_back(figures_of(set, result, start, static_cast<int>(i)));
  }
  return lines;
}

std::vector<CrossingPoints> crossing_figures(const CaptureSet& set,
                                             std::span<const LineCrossing> crossings,
                                             const SeenPoints& inliers) {
  const double reach_m = 0.5 * cell_side_m(set, crossings);
  std::vector<CrossingPoints> figures;
  for (const LineCrossing& crossing : crossings) {
    const int points =
        common_points(inliers, frames_near(set, crossing.along_x, crossing.at, reach_m),
                      frames_near(set, crossing.along_z, crossing.at, reach_m));
    figures.push_back({crossing.along_x, crossing.along_z, points});
  }
  return figures;
}

std::string unposed_reason(const CaptureSet& set, const MatchSummary& summary, int frame) {
  const auto count = [frame](const std::map<int, int>& counts) {
    const auto found = counts.find(frame);
    return found == counts.end() ? 0 : found->second;
  };
  const CaptureFrame& of = set.frames[static_cast<std::size_t>(frame)];
  const auto line = static_cast<std::size_t>(of.line);
  if (!of.held_out() && line < summary.motions.size() &&
      summary.motions[line] == RailMotion::kReversed) {
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
  const auto posed = [&](int line) {
    return result.lines[static_cast<std::size_t>(line)].posed > 0;
  };
  for (const CrossingPoints& crossing : result.crossings) {
    if (!posed(crossing.along_x) || !posed(crossing.along_z)) continue;
    if (crossing.points >= kLeastSharedPoints) continue;
    warnings.push_back(
        fmt::format("lines {} and {} have only {} scene points in common where they should cross: "
                    "they are connected only by other crossings",
                    set.line_id(crossing.along_x), set.line_id(crossing.along_z), crossing.points));
  }
  for (const UnposedFrame& unposed : result.unposed) {
    const CaptureFrame& frame = set.frames[static_cast<std::size_t>(unposed.frame)];
    if (!frame.held_out()) continue;
    warnings.push_back(fmt::format("held-out frame {} ({}) has no pose and is left out: {}",
                                   frame.name, frame.where, unposed.reason));
  }
  return warnings;
}

}  // namespace raywalk::calibrate
