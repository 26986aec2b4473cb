// For tests: panoramas of a virtual room along two lines that cross, as files.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/grid/rail_model.h"
#include "capture/simulated/virtual_room/test_rooms.h"
#include "capture/simulated/virtual_room/virtual_room.h"

namespace raywalk::calibrate {

struct RoomCaptureSettings {
  int stations = 3;  // of each line, 50 mm apart about the crossing
  PanoramaSize size{512, 256};
  bool blank = false;  // grey pictures, for tests that do not need their content
  // The true motion of the line along x relative to the plan.
  Eigen::Vector3d motion_m{0, 0, 0};
  Eigen::Vector3d turn_rad{0, 0, 0};
};

struct RoomCapture {
  CaptureSet set{};
  FramePoses truth{};
};

// A draft is aliased, which does not disturb the features.
inline cv::Mat seen_in_room(const FramePose& pose, PanoramaSize size) {
  static const capture::VirtualRoom room(capture::furnished_room(1));
  return room.panorama({pose.position_m, attitude_from_world_from_camera(pose.world_from_camera)},
                       size, capture::Sampling::kDraft);
}

inline RoomCapture capture_room(const std::filesystem::path& directory,
                                const RoomCaptureSettings& settings) {
  constexpr double kSpacing_m = 0.05;
  RoomCapture capture;
  capture.set.source = directory;
  capture.set.frame = settings.size;
  for (const LineAxis axis : {LineAxis::kX, LineAxis::kZ}) {
    const bool along_x = axis == LineAxis::kX;
    const int line = static_cast<int>(capture.set.lines.size());
    capture.set.lines.push_back({.id = along_x ? "x0" : "z0", .axis = axis});
    for (int i = 0; i < settings.stations; ++i) {
      // The crossing lies between stations of both.
      const double rail_m = kSpacing_m * (i - 0.5 * settings.stations + 0.3);
      CaptureFrame frame{.name = fmt::format("{}_{}", along_x ? "x0" : "z0", i), .line = line};
      frame.file = directory / (frame.name + ".png");
      (along_x ? frame.nominal_m.x() : frame.nominal_m.z()) = rail_m;
      FramePose pose{.position_m = frame.nominal_m};
      if (along_x) {
        pose.position_m += settings.motion_m;
        pose.world_from_camera = matrix_of(settings.turn_rad);
      }
      cv::imwrite(frame.file.string(), settings.blank
                                           ? cv::Mat(settings.size.height, settings.size.width,
                                                     CV_8UC3, cv::Scalar::all(128))
                                           : seen_in_room(pose, settings.size));
      capture.set.lines.back().frames.push_back(static_cast<int>(capture.set.frames.size()));
      capture.set.frames.push_back(std::move(frame));
      capture.truth.emplace_back(pose);
    }
  }
  return capture;
}

}  // namespace raywalk::calibrate
