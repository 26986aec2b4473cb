// Poses of the panoramas, as known at some step of the calibration, and their file.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"

namespace raywalk::calibrate {

// The source of a pose: "nominal", "solved", "rail", "given" in files.
enum class PoseOrigin {
  kNominal,  // the plan and the slider's feedback
  kSolved,   // from the frame's own picture
  kRail,     // from the neighbours on its rail
  kGiven,    // given by the user
};

// World frame of core/geometry/sphere.h; the camera's frame is that of its panorama.
struct FramePose {
  Eigen::Vector3d position_m{0, 0, 0};
  Eigen::Matrix3d world_from_camera = Eigen::Matrix3d::Identity();
  PoseOrigin origin = PoseOrigin::kNominal;
  // Standard deviations of position (per axis) and rotation (per axis), relative to the other
  // frames; 0: unknown.
  double position_sigma_mm = 0.0;
  double rotation_sigma_deg = 0.0;
  int observations = 0;      // of scene points, used for the pose
  double residual_px = 0.0;  // their root mean square, in pixels of a panorama 4096 wide
};

// By the index of CaptureSet::frames; nullopt: unknown.
using FramePoses = std::vector<std::optional<FramePose>>;

// Every frame at its nominal position and attitude.
FramePoses nominal_poses(const CaptureSet& set);

// The angle between two rotations, radians in [0, pi].
double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

// JSON: {"format_version": 1, "frames": [{"name", "position_m": [x, y, z], "planned_m", "yaw_deg",
// "pitch_deg", "roll_deg", "origin", "position_sigma_mm", "rotation_sigma_deg", "observations",
// "residual_px"}]}, only frames with a pose; frame_poses_json is the list.
// Reading throws Error naming the file if it is missing, not JSON or of a newer format version, has
// a frame that is not in the set, or a value that is not a finite number. `advice`: how the file is
// made again.
nlohmann::ordered_json frame_poses_json(const CaptureSet& set, const FramePoses& poses);
FramePoses read_frame_poses(const std::filesystem::path& file, const CaptureSet& set,
                            const std::string& advice = "solve the poses again");

// Reads poses from a table file,x,y,z,yaw,pitch,roll (metres, degrees), such as ground truth. Rows
// are matched with the frames' names (read_capture_set) by the stem of `file`; other rows are
// ignored. Throws Error naming table and line, and if no row matches a frame.
FramePoses read_pose_table(const std::filesystem::path& table, const CaptureSet& set);

}  // namespace raywalk::calibrate
