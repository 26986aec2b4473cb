// Features and matches by COLMAP, then rounds of triangulation and adjustment.
#pragma once

#include <vector>

#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/poses_figures.h"
#include "calibrate/poses/refine_poses.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

// A scene point has to be seen from so many frames: with two, one direction is not checked.
inline constexpr int kLeastFrames = 3;

// What the rounds work on. Refers to the set and the options that it was made from.
struct PoseProblem {
  const CaptureSet& set;
  const PosesOptions& options;
  FramePoses start{};    // initial poses
  FramePoses nominal{};  // of the stations
  std::vector<LineCrossing> crossings{};
  std::vector<int> keyframes{};
  int face_px = 0;
  int threads = 1;
  PoseAnchor anchor{};
};

PoseProblem problem_of(const CaptureSet& set, const PosesOptions& options);

struct SolvedPoses {
  MatchSummary summary{};
  int matched_pairs = 0;  // of faces
  // Near the nominal poses, with sigmas; those of the largest connected group of frames. Empty if
  // nothing was solved.
  RefinedPoses refined{};
  std::vector<StepTime> times{};
};

// Throws Error if there is no supported COLMAP, it fails (quoting its log), or another process
// works in the same directory; Interrupted.
SolvedPoses solve_in_rounds(const PoseProblem& problem);

}  // namespace raywalk::calibrate
