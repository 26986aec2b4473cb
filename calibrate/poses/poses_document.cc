#include "calibrate/poses/poses_document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "calibrate/base/rotation.h"
#include "core/files/atomic_output.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

using Json = nlohmann::ordered_json;

// Frames with a pose, of the stations or of those held out.
int posed_count(const CaptureSet& set, const PosesResult& result, bool held_out) {
  int count = 0;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    const auto& pose = result.poses[i];
    const bool solved = pose && pose->origin == PoseOrigin::kSolved;
    if (solved && set.frames[i].held_out() == held_out) ++count;
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

Json intersection_json(const CaptureSet& set, const MeasuredIntersection& intersection) {
  const IntersectionCheck& check = intersection.check;
  const auto sigma = [&](Eigen::Index first) {
    return std::sqrt(check.covariance.block<3, 3>(first, first).trace() / 3.0);
  };
  Json json{{"along_x", set.line_id(check.intersection.along_x)},
            {"along_z", set.line_id(check.intersection.along_z)},
            {"x_m", check.intersection.at.x_m},
            {"z_m", check.intersection.at.z_m},
            {"correction_mm", intersection.correction_mm},
            {"correction_deg", intersection.correction_deg},
            {"held_out_points", check.points}};
  if (check.points >= kLeastCheckPoints) {
    json.update(Json{{"position_mm", 1e3 * check.motion_m.norm()},
                     {"position_sigma_mm", 1e3 * sigma(0)},
                     {"rotation_px", kResidualPx_per_rad * check.rotation_rad.norm()},
                     {"rotation_sigma_px", kResidualPx_per_rad * sigma(3)}});
  }
  json["faults"] = intersection.faults;
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
                {"intersections", Json::array()},
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
  for (const MeasuredIntersection& intersection : result.intersections) {
    document["intersections"].push_back(intersection_json(set, intersection));
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

void write_poses(const std::filesystem::path& file, const CaptureSet& set,
                 const PosesResult& result) {
  write_file_atomically(file, json_text(poses_document(set, result)));
}

}  // namespace raywalk::calibrate
