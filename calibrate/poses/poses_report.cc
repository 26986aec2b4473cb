#include "calibrate/poses/poses_report.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/files/atomic_output.h"
#include "core/files/json_text.h"

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
                {"total_seconds", 0.0},
                {"frames", frame_poses_json(set, result.poses)}};
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

}  // namespace

void write_poses_report(const std::filesystem::path& out, const CaptureSet& set,
                        const PosesResult& result) {
  write_file_atomically(out / "poses-report.json", json_text(poses_document(set, result)));
}

}  // namespace raywalk::calibrate
