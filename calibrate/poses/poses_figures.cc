#include "calibrate/poses/poses_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibrate/base/rotation.h"
#include "calibrate/poses/match_pairs.h"
#include "calibrate/rails/rail_model.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

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
    result->notes.push_back("one line only: no crossing checks the result");
    return;
  }
  for (std::size_t line = 0; line < set.lines.size(); ++line) {
    const auto crosses = [&](const MeasuredCrossing& crossing) {
      const auto id = static_cast<int>(line);
      const LineCrossing& at = crossing.check.crossing;
      return at.along_x == id || at.along_z == id;
    };
    if (std::ranges::any_of(result->crossings, crosses)) continue;
    result->warnings.push_back(
        fmt::format("line {}: no line crosses it, so its agreement with the others cannot be "
                    "checked; capture a line across it",
                    set.lines[line].id));
  }
}

using Json = nlohmann::ordered_json;

// Frames with a pose, of the stations or of those held out.
int posed_count(const CaptureSet& set, const PosesResult& result, bool held_out) {
  int count = 0;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    if (is_solved(result.poses[i]) && set.frames[i].held_out() == held_out) ++count;
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

// The rail relative to the plan, and its stations relative to the rail.
void add_rail(const CaptureSet& set, const Rail& rail, const FramePoses& poses, std::size_t line,
              Json* json) {
  using P = RailParameter;
  const RailParameters& p = rail.parameters;
  const RailAxes<double> planned = rail_axes(rail.frame.axis, 0.0, 0.0);
  const Eigen::Vector3d offset_m(p[P::kOffset], p[P::kOffset + 1], p[P::kOffset + 2]);
  const Attitude turn = attitude_from_world_from_camera(
      matrix_of({p[P::kRotation], p[P::kRotation + 1], p[P::kRotation + 2]}));
  Json stations = Json::array();
  for (const std::size_t frame : set.lines[line].frames) {
    if (!poses[frame]) continue;
    const RailDeviation off = deviation_of(set, rail, frame, *poses[frame]);
    const Eigen::Vector3d turned_deg = degrees_from_radians(1.0) * off.turned_rad;
    stations.push_back({{"name", set.frames[frame].name},
                        {"rail_m", set.rail_m(frame)},
                        {"along_mm", 1e3 * off.off_m[0]},
                        {"across_mm", 1e3 * off.off_m[1]},
                        {"up_mm", 1e3 * off.off_m[2]},
                        {"about_x_deg", turned_deg.x()},
                        {"about_y_deg", turned_deg.y()},
                        {"about_z_deg", turned_deg.z()}});
  }
  json->update(Json{{"along_mm", 1e3 * offset_m.dot(planned.direction)},
                    {"across_mm", 1e3 * offset_m.dot(planned.across)},
                    {"height_mm", 1e3 * offset_m.dot(planned.up)},
                    {"heading_deg", degrees_from_radians(p[P::kHeading])},
                    {"tilt_deg", degrees_from_radians(p[P::kTilt])},
                    {"yaw_deg", degrees_from_radians(turn.yaw_rad)},
                    {"pitch_deg", degrees_from_radians(turn.pitch_rad)},
                    {"roll_deg", degrees_from_radians(turn.roll_rad)},
                    {"bow_mm", {1e3 * p[P::kBow], 1e3 * p[P::kBow + 1]}},
                    {"scatter_along_mm", 1e3 * rail.scatter.along_m},
                    {"scatter_mm", 1e3 * rail.scatter.across_m},
                    {"scatter_deg", degrees_from_radians(rail.scatter.rotation_rad)},
                    {"deviations", stations}});
}

Json lines_json(const CaptureSet& set, const PosesResult& result) {
  Json json = Json::array();
  for (const LinePoses& line : result.lines) {
    Json one{{"id", set.line_id(line.line)},      {"stations", line.stations},
             {"keyframes", line.keyframes},       {"posed", line.posed},
             {"observations", line.observations}, {"residual_px", line.residual_px},
             {"moved_mm", line.moved_mm},         {"turned_deg", line.turned_deg}};
    add_rail(set, result.rails[line.line], result.poses, line.line, &one);
    json.push_back(std::move(one));
  }
  return json;
}

Json crossing_json(const CaptureSet& set, const MeasuredCrossing& crossing) {
  const CrossingCheck& check = crossing.check;
  const auto sigma = [&](Eigen::Index first) {
    return std::sqrt(check.covariance.block<3, 3>(first, first).trace() / 3.0);
  };
  Json json{{"along_x", set.line_id(check.crossing.along_x)},
            {"along_z", set.line_id(check.crossing.along_z)},
            {"x_m", check.crossing.at.x_m},
            {"z_m", check.crossing.at.z_m},
            {"correction_mm", crossing.correction_mm},
            {"correction_deg", crossing.correction_deg},
            {"held_out_points", check.points}};
  if (check.points >= kLeastCheckPoints) {
    json.update(Json{{"position_mm", 1e3 * check.motion_m.norm()},
                     {"position_sigma_mm", 1e3 * sigma(0)},
                     {"rotation_px", kResidualPx_per_rad * check.rotation_rad.norm()},
                     {"rotation_sigma_px", kResidualPx_per_rad * sigma(3)}});
  }
  json["faults"] = crossing.faults;
  return json;
}

Json poses_document(const CaptureSet& set, const PosesResult& result) {
  const std::size_t held_out = set.frames.size() - set.stations();
  Json document{{"format_version", 1},
                {"source", set.source.string()},
                {"trustworthy", result.trustworthy()},
                {"warnings", result.warnings},
                {"notes", result.notes},
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
                {"contradictions", Json::array()},
                {"lines", lines_json(set, result)},
                {"crossings", Json::array()},
                {"unposed", Json::array()},
                {"held_out", nullptr},
                {"seconds", Json::array()},
                {"total_seconds", 0.0},
                {"frames", frame_poses_json(set, result.poses)}};
  for (const Contradiction& one : result.contradictions) {
    Json stations = Json::array();
    for (const std::size_t frame : one.frames) stations.push_back(set.frames[frame].name);
    document["contradictions"].push_back(
        {{"kind", one.kind}, {"text", one.text}, {"stations", stations}});
  }
  for (const MeasuredCrossing& crossing : result.crossings) {
    document["crossings"].push_back(crossing_json(set, crossing));
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

void set_correction(const CaptureSet& set, const FramePoses& planned, const FramePoses& solved,
                    MeasuredCrossing* crossing) {
  const LineCrossing& at = crossing->check.crossing;
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
  crossing->correction_mm = 1e3 * (apart_m(solved) - apart_m(planned)).norm();
  crossing->correction_deg = degrees_from_radians(angle_between(turned(planned), turned(solved)));
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
  const std::vector<LineCrossing> crossings = crossings_of(set);
  const double cell_m = cell_side_m(set, crossings);
  for (const LinePoses& line : result->lines) warn_of_line(set, line, cell_m, result);
  warn_of_uncrossed(set, result);
  const auto posed = [&](int line) { return result->lines[line].posed > 0; };
  for (const MeasuredCrossing& crossing : result->crossings) {
    const LineCrossing& at = crossing.check.crossing;
    if (!posed(at.along_x) || !posed(at.along_z)) continue;
    result->warnings.insert(result->warnings.end(), crossing.faults.begin(), crossing.faults.end());
  }
  for (const UnposedFrame& unposed : result->unposed) {
    const CaptureFrame& frame = set.frames[unposed.frame];
    if (!frame.held_out()) continue;
    result->notes.push_back(fmt::format("held-out frame {} ({}) has no pose and is left out: {}",
                                        frame.name, frame.where, unposed.reason));
  }
}

void write_poses(const std::filesystem::path& file, const CaptureSet& set,
                 const PosesResult& result) {
  write_file_atomically(file, json_text(poses_document(set, result)));
}

}  // namespace raywalk::calibrate
