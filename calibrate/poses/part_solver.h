// Solves one part of a grid: features and matches by COLMAP, then rounds of triangulation and
// adjustment.
#pragma once

#include <vector>

#include "calibrate/poses/part_solution.h"
#include "calibrate/poses/pose_parts.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

// A scene point has to be seen from so many frames: with two, one direction is not checked.
inline constexpr int kLeastFrames = 3;

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
