#include "calibrate/base/frame_poses.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "calibrate/base/frame_poses_json.h"
#include "calibrate/base/listed_frames.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

constexpr int kFormatVersion = 1;

struct NamedOrigin {
  PoseOrigin origin;
  const char* name;
};
constexpr std::array kOrigins{
    NamedOrigin{PoseOrigin::kNominal, "nominal"}, NamedOrigin{PoseOrigin::kSolved, "solved"},
    NamedOrigin{PoseOrigin::kRail, "rail"}, NamedOrigin{PoseOrigin::kGiven, "given"}};

PoseOrigin origin_of(const std::string& name) {
  for (const NamedOrigin& known : kOrigins) {
    if (known.name == name) return known.origin;
  }
  throw Error("unknown origin " + excerpt(name));
}

ordered_json json_of(const std::string& name, const FramePose& pose) {
  const Attitude attitude = attitude_from_world_from_camera(pose.world_from_camera);
  return {{"name", name},
          {"position_m", {pose.position_m.x(), pose.position_m.y(), pose.position_m.z()}},
          {"yaw_deg", degrees_from_radians(attitude.yaw_rad)},
          {"pitch_deg", degrees_from_radians(attitude.pitch_rad)},
          {"roll_deg", degrees_from_radians(attitude.roll_rad)},
          {"origin", pose_origin_name(pose.origin)},
          {"position_sigma_mm", pose.position_sigma_mm},
          {"rotation_sigma_deg", pose.rotation_sigma_deg},
          {"observations", pose.observations},
          {"residual_px", pose.residual_px}};
}

double finite_number(const json& frame, const char* key) {
  const double value = frame.at(key).get<double>();
  if (!std::isfinite(value)) throw Error(fmt::format("{} is not a finite number", key));
  return value;
}

FramePose pose_of(const json& frame) {
  FramePose pose;
  const json& position = frame.at("position_m");
  if (position.size() != 3) throw Error("position_m is not three numbers");
  pose.position_m = {position.at(0).get<double>(), position.at(1).get<double>(),
                     position.at(2).get<double>()};
  if (!pose.position_m.allFinite()) throw Error("position_m is not finite");
  pose.world_from_camera =
      world_from_camera({radians_from_degrees(finite_number(frame, "yaw_deg")),
                         radians_from_degrees(finite_number(frame, "pitch_deg")),
                         radians_from_degrees(finite_number(frame, "roll_deg"))});
  pose.origin = origin_of(frame.at("origin").get<std::string>());
  pose.position_sigma_mm = finite_number(frame, "position_sigma_mm");
  pose.rotation_sigma_deg = finite_number(frame, "rotation_sigma_deg");
  pose.observations = frame.at("observations").get<int>();
  pose.residual_px = finite_number(frame, "residual_px");
  return pose;
}

int frame_named(const CaptureSet& set, const std::string& name) {
  const std::optional<int> index = set.find(name);
  if (!index) throw Error("frame " + excerpt(name) + " is not in the capture");
  return *index;
}

FramePoses poses_of(const json& document, const CaptureSet& set) {
  if (document.at("format_version").get<int>() > kFormatVersion) {
    throw Error("written by a newer version of this program");
  }
  FramePoses poses(set.frames.size());
  for (const json& frame : document.at("frames")) {
    const int index = frame_named(set, frame.at("name").get<std::string>());
    auto& pose = poses[static_cast<std::size_t>(index)];
    if (pose) throw Error("lists a frame twice");
    pose = pose_of(frame);
  }
  return poses;
}

std::vector<std::string> column_of(const CsvTable& table, const std::string& column) {
  std::vector<std::string> values;
  for (std::size_t row = 0; row < table.rows(); ++row) values.push_back(table.text(row, column));
  return values;
}

FramePose pose_of_row(const CsvTable& table, std::size_t row) {
  FramePose pose{.origin = PoseOrigin::kGiven};
  pose.position_m = {table.number(row, "x"), table.number(row, "y"), table.number(row, "z")};
  const auto radians = [&](const std::string& column) {
    return radians_from_degrees(table.number(row, column));
  };
  pose.world_from_camera = world_from_camera({radians("yaw"), radians("pitch"), radians("roll")});
  return pose;
}

}  // namespace

const char* pose_origin_name(PoseOrigin origin) {
  for (const NamedOrigin& known : kOrigins) {
    if (known.origin == origin) return known.name;
  }
  return "nominal";
}

FramePoses nominal_poses(const CaptureSet& set) {
  FramePoses poses;
  for (const CaptureFrame& frame : set.frames) {
    FramePose pose{.position_m = frame.nominal_m};
    if (frame.nominal_attitude) pose.world_from_camera = world_from_camera(*frame.nominal_attitude);
    poses.emplace_back(pose);
  }
  return poses;
}

// By the quaternion, whose vector part is accurate for small angles, unlike the trace.
double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Quaterniond turn(Eigen::Matrix3d(a.transpose() * b));
  return 2.0 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
}

ordered_json frame_poses_json(const CaptureSet& set, const FramePoses& poses) {
  ordered_json frames = ordered_json::array();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i]) frames.push_back(json_of(set.frames[i].name, *poses[i]));
  }
  return frames;
}

void write_frame_poses(const fs::path& file, const CaptureSet& set, const FramePoses& poses) {
  const ordered_json document{{"format_version", kFormatVersion},
                              {"frames", frame_poses_json(set, poses)}};
  write_file_atomically(file, document.dump(1) + "\n");
}

FramePoses read_frame_poses(const fs::path& file, const CaptureSet& set) {
  const std::string text = read_file(file);
  try {
    return poses_of(json::parse(text), set);
  } catch (const json::exception& e) {
    throw Error(
        one_line(fmt::format("{}: damaged ({}); solve the poses again", file.string(), e.what())));
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}; solve the poses again", file.string(), e.what()));
  }
}

FramePoses read_pose_table(const fs::path& table_file, const CaptureSet& set) {
  const CsvTable table =
      CsvTable::read(table_file, {"file", "x", "y", "z", "yaw", "pitch", "roll"}, {});
  const std::vector<std::string> names = frame_names(column_of(table, "file"), table_file);
  FramePoses poses(set.frames.size());
  bool any = false;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::optional<int> index = set.find(names[row]);
    if (!index) continue;
    poses[static_cast<std::size_t>(*index)] = pose_of_row(table, row);
    any = true;
  }
  if (!any) {
    throw Error(fmt::format("{}: lists none of the capture's frames, such as {}",
                            table_file.string(), set.frames.front().name));
  }
  return poses;
}

}  // namespace raywalk::calibrate
