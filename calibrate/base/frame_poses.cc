#include "calibrate/base/frame_poses.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/frame_list.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kPosesVersion = 1;

struct NamedOrigin {
  PoseOrigin origin;
  const char* name;
};
constexpr std::array kOrigins{
    NamedOrigin{PoseOrigin::kNominal, "nominal"}, NamedOrigin{PoseOrigin::kSolved, "solved"},
    NamedOrigin{PoseOrigin::kRail, "rail"}, NamedOrigin{PoseOrigin::kGiven, "given"}};

PoseOrigin origin_of(const CheckedJson& name) {
  for (const NamedOrigin& known : kOrigins) {
    if (known.name == name.text()) return known.origin;
  }
  name.fail("unknown origin " + excerpt(name.text()));
}

const char* pose_origin_name(PoseOrigin origin) {
  for (const NamedOrigin& known : kOrigins) {
    if (known.origin == origin) return known.name;
  }
  return "nominal";
}

ordered_json json_of(const CaptureFrame& frame, const FramePose& pose) {
  const Attitude attitude = attitude_from_world_from_camera(pose.world_from_camera);
  const Eigen::Vector3d& planned_m = frame.nominal_m;
  return {{"name", frame.name},
          {"position_m", {pose.position_m.x(), pose.position_m.y(), pose.position_m.z()}},
          {"planned_m", {planned_m.x(), planned_m.y(), planned_m.z()}},
          {"yaw_deg", degrees_from_radians(attitude.yaw_rad)},
          {"pitch_deg", degrees_from_radians(attitude.pitch_rad)},
          {"roll_deg", degrees_from_radians(attitude.roll_rad)},
          {"origin", pose_origin_name(pose.origin)},
          {"position_sigma_mm", pose.position_sigma_mm},
          {"rotation_sigma_deg", pose.rotation_sigma_deg},
          {"observations", pose.observations},
          {"residual_px", pose.residual_px}};
}

FramePose pose_of(const CheckedJson& frame) {
  const auto radians = [&](const char* key) {
    return radians_from_degrees(frame.at(key).number());
  };
  const std::vector<CheckedJson> position = frame.at("position_m").items(3);
  const auto metres = [&](std::size_t axis) {
    return position[axis].number(-kMaxPosition_m, kMaxPosition_m);
  };
  return {.position_m = {metres(0), metres(1), metres(2)},
          .world_from_camera =
              world_from_camera({radians("yaw_deg"), radians("pitch_deg"), radians("roll_deg")}),
          .origin = origin_of(frame.at("origin")),
          .position_sigma_mm = frame.at("position_sigma_mm").number(),
          .rotation_sigma_deg = frame.at("rotation_sigma_deg").number(),
          .observations = frame.at("observations").integer(),
          .residual_px = frame.at("residual_px").number()};
}

FramePoses frame_poses_in(const CheckedJson& frames, const CaptureSet& set) {
  const auto indices = indices_by_name(set);
  FramePoses poses(set.frames.size());
  for (const CheckedJson& frame : frames.items()) {
    const CheckedJson name = frame.at("name");
    const auto found = indices.find(name.text());
    if (found == indices.end()) {
      name.fail("frame " + excerpt(name.text()) + " is not in the capture");
    }
    auto& pose = poses[found->second];
    if (pose) name.fail("lists a frame twice");
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
  return {.position_m = read_position_m(table, row),
          .world_from_camera = world_from_camera(read_attitude(table, row)),
          .origin = PoseOrigin::kGiven};
}

}  // namespace

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
    if (poses[i]) frames.push_back(json_of(set.frames[i], *poses[i]));
  }
  return frames;
}

FramePoses read_frame_poses(const fs::path& file, const CaptureSet& set,
                            const std::string& advice) {
  const auto root = CheckedJson::read(file, advice);
  root.require_version(kPosesVersion);
  return frame_poses_in(root.at("frames"), set);
}

FramePoses read_pose_table(const fs::path& table_file, const CaptureSet& set) {
  const CsvTable table =
      CsvTable::read(table_file, {"file", "x", "y", "z", "yaw", "pitch", "roll"}, {});
  const std::vector<std::string> names = frame_names(column_of(table, "file"), table_file);
  const auto indices = indices_by_name(set);
  FramePoses poses(set.frames.size());
  bool any = false;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto found = indices.find(names[row]);
    if (found == indices.end()) continue;
    poses[found->second] = pose_of_row(table, row);
    any = true;
  }
  if (!any) {
    throw Error(fmt::format("{}: lists none of the capture's frames, such as {}",
                            table_file.string(), set.frames.front().name));
  }
  return poses;
}

}  // namespace raywalk::calibrate
