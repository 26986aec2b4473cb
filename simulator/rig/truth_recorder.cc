#include "simulator/rig/truth_recorder.h"

#include <fmt/format.h>

#include <utility>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "simulator/room/truth_files.h"

namespace raywalk::capture {

TruthRecorder::TruthRecorder(const VirtualRoom* room, PanoramaSize size,
                             std::filesystem::path directory)
    : room_(room), size_(size), directory_(std::move(directory)) {
  make_directories(directory_ / "dist");
  make_directories(directory_ / "gt");
  const std::filesystem::path table = directory_ / "true_poses.csv";
  std::error_code none_yet;
  const auto bytes = std::filesystem::file_size(table, none_yet);
  poses_.open(table, std::ios::app);
  if (none_yet || bytes == 0) poses_ << "file,line,x,y,z,yaw,pitch,roll\n" << std::flush;
  if (!poses_) throw Error("cannot write " + table.string());
}

void TruthRecorder::write_views(int count) {
  const auto viewpoints = truth_viewpoints(*room_, count);
  Progress progress("rendering true views", count, "views");
  write_truth_views(*room_, viewpoints, size_, directory_, false, &progress);
}

void TruthRecorder::record(const std::string& picture, const std::string& line,
                           const CameraPose& pose) {
  poses_ << fmt::format("{},{},{}\n", picture, line, pose_fields(pose)) << std::flush;
  if (!poses_) throw Error("cannot write " + (directory_ / "true_poses.csv").string());
}

void TruthRecorder::write_distances(const std::string& picture, const CameraPose& pose) {
  const std::string stem = std::filesystem::path(picture).stem().string();
  write_distance_map(*room_, pose, size_, directory_ / "dist" / (stem + ".png"));
}

}  // namespace raywalk::capture
