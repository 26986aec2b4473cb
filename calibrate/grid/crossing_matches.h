// What two lines both see where they cross: features matched between the stations of one and of the
// other that are nearest to the crossing.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "core/geometry/fisheye_lens.h"

namespace raywalk::calibrate {

// A ray of a frame, in its camera's frame.
struct MatchRay {
  Eigen::Vector3d origin_m{0, 0, 0};  // the lens's place, 0 for cameras of one centre
  Eigen::Vector3d bearing{0, 0, 1};   // unit
};

// Two rays to one point of the scene; frames index CaptureSet::frames, the first is of the line
// along x, the second of the line along z.
struct CrossingMatch {
  int frame_x = 0;
  int frame_z = 0;
  MatchRay ray_x{};
  MatchRay ray_z{};
  bool held_out = false;
};

// At most this many stations of each line are matched at a crossing, every one with every one.
inline constexpr int kCrossingStations = 3;
// Rays to one point may differ by so much: by the error of the starting attitudes and by parallax.
inline constexpr double kMatchGate_deg = 25.0;

struct CrossingMatches {
  LineCrossing crossing{};
  std::vector<int> frames_x{};  // nearest to the crossing first
  std::vector<int> frames_z{};
  std::vector<CrossingMatch> matches{};
};

// The stations of the line that are nearest to the crossing along the rail, nearest first.
std::vector<int> nearest_frames(const CaptureSet& set, int line, PlanPoint crossing);

// `held_out` is by place: the sphere is a checkerboard of patches of about 11 degrees, and the
// matches of its black fields are held out. So both halves look to all sides, and no feature is in
// both, by whichever frames it was seen.
bool in_held_out_patch(const Eigen::Vector3d& world_direction);

// Reads the pictures of the frames at the crossings, each once. Throws Error where one cannot be
// read or is no panorama of the set's size; Interrupted.
std::vector<CrossingMatches> find_crossing_matches(const CaptureSet& set, const FramePoses& start,
                                                   const std::optional<cv::Mat>& mask,
                                                   const std::optional<DualFisheyeLayout>& lenses);

}  // namespace raywalk::calibrate
