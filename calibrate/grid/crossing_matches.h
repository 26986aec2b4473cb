// Features matched between two lines where they cross, in the stations nearest to the crossing.
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
  Eigen::Vector3d origin_m{0, 0, 0};  // the lens's position, 0 for a single centre of projection
  Eigen::Vector3d bearing{0, 0, 1};   // unit
};

// Two rays to one scene point, from a frame of the line along x and from one of the line along z
// (indices into CaptureSet::frames).
struct CrossingMatch {
  int frame_x = 0;
  int frame_z = 0;
  MatchRay ray_x{};
  MatchRay ray_z{};
  bool held_out = false;
};

// At most this many stations of each line are matched at a crossing, all pairs of them.
inline constexpr int kCrossingStations = 3;
// Largest angle between matched rays in the start's world axes: the error of the starting attitudes
// plus parallax.
inline constexpr double kMatchGate_deg = 25.0;

struct CrossingMatches {
  LineCrossing crossing{};
  std::vector<int> frames_x{};  // nearest to the crossing first
  std::vector<int> frames_z{};
  std::vector<CrossingMatch> matches{};
};

// The stations of the line that are nearest to the crossing along the rail, nearest first.
std::vector<int> nearest_frames(const CaptureSet& set, int line, PlanPoint crossing);

// Whether a match in this direction is held out. The sphere is a checkerboard of patches of about
// 11 degrees, of which the black ones are held out: both halves cover all directions, and no
// feature is in both, whichever frames saw it.
bool in_held_out_patch(const Eigen::Vector3d& world_direction);

// Reads each picture of the frames at the crossings once. `mask` is that of all frames, which their
// own masks are joined with. Throws Error for a picture that cannot be
// read or is not a panorama of the set's size; Interrupted.
std::vector<CrossingMatches> find_crossing_matches(const CaptureSet& set, const FramePoses& start,
                                                   const std::optional<cv::Mat>& mask,
                                                   const std::optional<DualFisheyeLayout>& lenses);

}  // namespace raywalk::calibrate
