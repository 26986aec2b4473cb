// The poses of one part of a grid (pose_parts.h), and the file that keeps them until the parts are
// joined.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/refine_poses.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

struct PartSolution {
  std::string colmap{};  // the version that solved it
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

// Exact; the numbers are in the order of bytes of this machine.
std::string bytes_of(const PartSolution& solution);

// Reads bytes_of. Throws Error, naming `part`, if they are not of a solution for that many frames
// and lines.
PartSolution read_part_solution(std::string_view bytes, std::size_t frames, std::size_t lines,
                                const std::string& part);

}  // namespace raywalk::calibrate
