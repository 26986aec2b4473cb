// Solves one part of a grid: features and matches by COLMAP, then rounds of triangulation and
// adjustment.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/pose_parts.h"
#include "calibrate/poses/refine_poses.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

// A scene point has to be seen from so many frames: with two, one direction is not checked.
inline constexpr int kLeastFrames = 3;

// The poses of one part.
struct PartSolution {
  // Of the frames at home.
  std::map<int, int> features{};
  std::map<int, int> matches{};  // verified, with all other frames
  int matched_pairs = 0;         // of faces; every pair counts in one part only
  // By line: evidence of its pairs of neighbours (motion_evidence).
  std::vector<std::vector<double>> evidence{};
  // Near the nominal poses, with sigmas; those of the largest connected group of frames, at home or
  // not. Empty if nothing was solved.
  RefinedPoses refined{};
  std::vector<StepTime> times{};

  bool solved() const { return !refined.points.observations.empty(); }
};

// What a solution works on. Refers to the set and the options that it was made from.
struct PoseProblem {
  const CaptureSet& set;
  const PosesOptions& options;
  FramePoses start{};    // initial poses
  FramePoses nominal{};  // of the stations
  std::vector<LineCrossing> crossings{};
  std::vector<int> keyframes{};
  std::vector<PosePart> parts{};
  int face_px = 0;
  int threads = 1;
  PoseAnchor anchor{};
};

PoseProblem problem_of(const CaptureSet& set, const PosesOptions& options);

// "part 3 of 16".
std::string part_name(const PoseProblem& problem, std::size_t part);

// One of several parts keeps only what the others do not see as well, and as many points as the
// adjustment of all takes. Throws Error if there is no supported COLMAP, it fails (quoting its
// log), or another process works at the same part in the same directory; Interrupted.
PartSolution solve_part(const PoseProblem& problem, std::size_t part);

}  // namespace raywalk::calibrate
