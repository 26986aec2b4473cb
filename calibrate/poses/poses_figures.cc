#include "calibrate/poses/poses_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate/poses/match_pairs.h"
#include "calibrate/rails/rail_model.h"

namespace raywalk::calibrate {
namespace {

// A line further from its plan than this share of a cell was probably laid at a wrong place.
constexpr double kFarOff = 0.25;
// Share of a line's keyframes without a pose from which the others are doubted, too.
constexpr double kManyUnsolved = 0.2;
constexpr int kFewFeatures = 100;  // over all faces of a panorama

bool is_solved(const std::optional<FramePose>& pose) {
  return pose && pose->origin == PoseOrigin::kSolved;
}

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
    if (!is_solved(pose)) continue;
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

// A rail laid at the place of another line gives a consistent grid that differs from the plan.
std::string place_found(const CaptureSet& set, const Rail& rail, std::size_t line) {
  const CaptureLine& own = set.lines[line];
  const Eigen::Vector3d middle_m =
      rail_position(rail.frame, rail.parameters.data(), rail.frame.rail_middle_m);
  const double found_m = own.axis == LineAxis::kX ? middle_m.z() : middle_m.x();
  const CaptureLine* nearest = &own;
  for (const CaptureLine& other : set.lines) {
    if (other.axis != own.axis) continue;
    if (std::abs(found_m - other.across_m) < std::abs(found_m - nearest->across_m)) {
      nearest = &other;
    }
  }
  return nearest == &own ? ""
                         : fmt::format(
                               ", nearer to the place of line {}: if the rail was laid "
                               "there, exchange the lines",
                               nearest->id);
}

void warn_of_line(const CaptureSet& set, const LinePoses& line, double cell_m,
                  PosesResult* result) {
  const std::string& id = set.line_id(line.line);
  if (line.posed == 0) {
    result->warnings.push_back(fmt::format(
        "line {}: nothing in its pictures connects it to the rest of the grid; its stations keep "
        "their planned poses. Was the rail laid where it was planned, and are these its pictures?",
        id));
    return;
  }
  const Rail& rail = result->rails[line.line];
  if (line.posed < line.stations) {
    std::string predicted = fmt::format(
        "line {}: {} of {} stations are predicted from the rail, within {:.2g} mm and {:.2g} "
        "degrees",
        id, line.stations - line.posed, line.stations, 1e3 * rail.scatter.across_m,
        degrees_from_radians(rail.scatter.rotation_rad));
    const int unsolved = line.keyframes - line.posed;
    if (unsolved > 0) {
      predicted +=
          fmt::format("; {} of {} keyframes could not be solved", unsolved, line.keyframes);
    }
    const bool many = unsolved > kManyUnsolved * line.keyframes;
    (many ? result->warnings : result->notes).push_back(std::move(predicted));
  }
  if (line.moved_mm > kFarOff * 1e3 * cell_m) {
    result->warnings.push_back(fmt::format("line {}: found {:.0f} mm from where it was planned{}",
                                           id, line.moved_mm, place_found(set, rail, line.line)));
  }
}

// Lines that no other one crosses.
void warn_of_uncrossed(const CaptureSet& set, PosesResult* result) {
  if (set.lines.size() == 1) {
    result->notes.push_back("one line only: no intersection checks the result");
    return;
  }
  for (std::size_t line = 0; line < set.lines.size(); ++line) {
    const auto crosses = [&](const MeasuredIntersection& intersection) {
      const auto id = static_cast<int>(line);
      const LineIntersection& at = intersection.check.intersection;
      return at.along_x == id || at.along_z == id;
    };
    if (std::ranges::any_of(result->intersections, crosses)) continue;
    result->warnings.push_back(
        fmt::format("line {}: no line crosses it, so its agreement with the others cannot be "
                    "checked; capture a line across it",
                    set.lines[line].id));
  }
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

void set_correction(const CaptureSet& set, const FramePoses& planned, const FramePoses& solved,
                    MeasuredIntersection* intersection) {
  const LineIntersection& at = intersection->check.intersection;
  const auto nearest = [&](int line) {
    const CaptureLine& of = set.lines[line];
    const double at_m = of.axis == LineAxis::kX ? at.at.x_m : at.at.z_m;
    return static_cast<std::size_t>(*std::ranges::min_element(
        of.frames, {}, [&](int frame) { return std::abs(set.rail_m(frame) - at_m); }));
  };
  const std::size_t x = nearest(at.along_x), z = nearest(at.along_z);
  const auto apart_m = [&](const FramePoses& poses) -> Eigen::Vector3d {
    return poses[x]->position_m - poses[z]->position_m;
  };
  const auto turned = [&](const FramePoses& poses) -> Eigen::Matrix3d {
    return poses[z]->world_from_camera.transpose() * poses[x]->world_from_camera;
  };
  intersection->correction_mm = 1e3 * (apart_m(solved) - apart_m(planned)).norm();
  intersection->correction_deg =
      degrees_from_radians(angle_between(turned(planned), turned(solved)));
}

std::string unposed_reason(const CaptureSet& set, const MatchSummary& summary, std::size_t frame) {
  const auto count = [frame](const std::map<std::size_t, int>& counts) {
    const auto found = counts.find(frame);
    return found == counts.end() ? 0 : found->second;
  };
  const CaptureFrame& of = set.frames[frame];
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

void add_warnings(const CaptureSet& set, PosesResult* result) {
  for (const Contradiction& one : result->contradictions) {
    result->warnings.push_back(one.text + "; the pictures are believed: correct the positions");
  }
  const std::vector<LineIntersection> intersections = intersections_of(set);
  const double cell_m = cell_side_m(set, intersections);
  for (const LinePoses& line : result->lines) warn_of_line(set, line, cell_m, result);
  warn_of_uncrossed(set, result);
  const auto posed = [&](int line) { return result->lines[line].posed > 0; };
  for (const MeasuredIntersection& intersection : result->intersections) {
    const LineIntersection& at = intersection.check.intersection;
    if (!posed(at.along_x) || !posed(at.along_z)) continue;
    result->warnings.insert(result->warnings.end(), intersection.faults.begin(),
                            intersection.faults.end());
  }
  for (const UnposedFrame& unposed : result->unposed) {
    const CaptureFrame& frame = set.frames[unposed.frame];
    if (!frame.held_out()) continue;
    result->notes.push_back(fmt::format("held-out frame {} ({}) has no pose and is left out: {}",
                                        frame.name, frame.where, unposed.reason));
  }
}

}  // namespace raywalk::calibrate
