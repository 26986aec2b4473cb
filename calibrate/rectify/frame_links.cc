#include "calibrate/rectify/frame_links.h"

#include <algorithm>

namespace raywalk::calibrate {
namespace {

// Position of a frame's pose in the x-z plane.
Eigen::Vector2d plan_position(const FramePoses& poses, int frame) {
  const Eigen::Vector3d& at = poses[static_cast<std::size_t>(frame)]->position_m;
  return {at.x(), at.z()};
}

std::vector<int> posed_frames(const CaptureLine& line, const FramePoses& poses) {
  std::vector<int> frames;
  for (const int frame : line.frames) {
    if (poses[static_cast<std::size_t>(frame)]) frames.push_back(frame);
  }
  return frames;
}

std::vector<int> nearest_two(const CaptureLine& line, const FramePoses& poses, PlanPoint at) {
  std::vector<int> frames = posed_frames(line, poses);
  const Eigen::Vector2d place(at.x_m, at.z_m);
  const std::size_t count = std::min<std::size_t>(2, frames.size());
  std::partial_sort(frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count),
                    frames.end(), [&](int a, int b) {
                      return (plan_position(poses, a) - place).norm() <
                             (plan_position(poses, b) - place).norm();
                    });
  frames.resize(count);
  return frames;
}

}  // namespace

std::vector<FrameLink> links_of(const CaptureSet& set, const FramePoses& poses) {
  std::vector<FrameLink> links;
  for (const CaptureLine& line : set.lines) {
    const std::vector<int> frames = posed_frames(line, poses);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      for (std::size_t j = i + 1; j < std::min(i + 3, frames.size()); ++j) {
        links.push_back({frames[i], frames[j]});
      }
    }
  }
  for (const LineCrossing& crossing : crossings_of(set)) {
    const auto near = [&](int line) {
      return nearest_two(set.lines[static_cast<std::size_t>(line)], poses, crossing.at);
    };
    const std::vector<int> along_z = near(crossing.along_z);
    for (const int from : near(crossing.along_x)) {
      for (const int to : along_z) links.push_back({from, to});
    }
  }
  return links;
}

}  // namespace raywalk::calibrate
