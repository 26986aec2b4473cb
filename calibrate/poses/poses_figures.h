// What is worth telling about solved poses: figures per line and crossing, why frames have none,
// and what a user has to know.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/poses/colmap_workspace.h"
#include "calibrate/poses/rail_motion.h"
#include "calibrate/poses/refine_poses.h"
#include "calibrate/poses/solve_poses.h"

namespace raywalk::calibrate {

// Fewer scene points than these do not tie frames or lines together, nor carry a pose: a handful of
// wrong matches may agree by chance.
inline constexpr int kLeastSharedPoints = 15;
inline constexpr int kLeastObservations = 30;

// One for each line that has keyframes, by the poses of `result`.
std::vector<LinePoses> line_figures(const CaptureSet& set, const PosesResult& result,
                                    const FramePoses& start);

// For each crossing the points that stations within half a cell of it see from both lines.
std::vector<CrossingPoints> crossing_figures(const CaptureSet& set,
                                             std::span<const LineCrossing> crossings,
                                             const SeenPoints& inliers);

// What pictures and matches showed before anything was solved.
struct MatchSummary {
  std::map<int, int> features{};      // by keyframe
  std::map<int, int> matches{};       // verified, by keyframe, with all others
  std::vector<RailMotion> motions{};  // by line
};

// Why a keyframe has no pose.
std::string unposed_reason(const CaptureSet& set, const MatchSummary& summary, int frame);

// By the finished figures of `result`: what is missing or not as planned.
std::vector<std::string> pose_warnings(const CaptureSet& set,
                                       std::span<const LineCrossing> crossings,
                                       const MatchSummary& summary, const PosesResult& result);

}  // namespace raywalk::calibrate
